//! Friction linear in the relative velocity, the common case of dissipative particle dynamics.

use super::PairFriction;
use crate::elementary::power;
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// Dissipative force −γ ω(r) (e·v) e with ω(r) = (1 − r/r_c)^s for r < r_c, zero beyond (Groot & Warren 1997 with s = 2;
/// Fan, Phan-Thien, Chen, Wu & Ng, Phys. Fluids 18, 063102 (2006) for other s).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// γ.
    pub coefficient: f64,
    /// r_c: the friction's own cutoff.
    pub cutoff: f64,
    /// s.
    #[serde(default = "Linear::default_exponent")]
    pub exponent: f64,
}

impl Linear {
    pub(super) fn default_exponent() -> f64 {
        2.0
    }
}

impl Linear {
    /// The same law where s = 2, for loops without a general power.
    #[inline(always)]
    pub(super) fn quadratic(&self) -> Quadratic {
        Quadratic(*self)
    }
}

/// A linear friction with s = 2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quadratic(Linear);

impl PairFriction for Quadratic {
    fn cutoff(&self) -> f64 {
        self.0.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        let overlap = R::splat(1.0) - r * R::splat(1.0 / self.0.cutoff);
        R::splat(self.0.coefficient) * (overlap * overlap)
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        self.0.parameters()
    }
}

impl PairFriction for Linear {
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        R::splat(self.coefficient) * power(R::splat(1.0) - r * R::splat(1.0 / self.cutoff), self.exponent)
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        vec![
            ("coefficient", self.coefficient, Requirement::NotNegative),
            ("cutoff", self.cutoff, Requirement::Positive),
            ("exponent", self.exponent, Requirement::Positive),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_friction_is_the_documented_power_and_vanishes_at_the_cutoff() {
        for exponent in [0.5, 1.0, 2.0, 3.5] {
            let law = Linear { coefficient: 4.5, cutoff: 2.5, exponent };
            assert!((law.amplitude(0.0) - 4.5).abs() < 1e-14);
            assert_eq!(law.amplitude(2.5), 0.0);
            for r in [0.1, 1.0, 2.4] {
                let expected = 4.5 * (1.0 - r / 2.5f64).powf(exponent);
                assert!(exponent != 2.0 || (law.quadratic().amplitude(r) / expected - 1.0).abs() < 1e-15);
                assert!((law.amplitude(r) / expected - 1.0).abs() < 1e-13);
            }
        }
    }
}
