//! The harmonic spring.

use super::PairPotential;
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

/// u(r) = ½ k (r − l)², f(r) = −k (r − l), at any distance: a law for bonds.
///
/// Mind the ½: some programs give a bond coefficient K = k/2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// k.
    pub stiffness: f64,
    /// l: where the spring is at rest.
    pub length: f64,
}

impl PairPotential for Harmonic {
    fn cutoff(&self) -> f64 {
        f64::INFINITY
    }

    #[inline(always)]
    fn energy(&self, r: f64) -> f64 {
        0.5 * self.stiffness * (r - self.length).powi(2)
    }

    #[inline(always)]
    fn force<R: Real>(&self, r: R) -> R {
        R::splat(self.stiffness) * (R::splat(self.length) - r)
    }

    #[inline(always)]
    fn force_derivative(&self, _r: f64) -> f64 {
        -self.stiffness
    }

    fn parameters(&self) -> Vec<(&'static str, f64, super::Requirement)> {
        use super::Requirement::{NotNegative, Positive};
        vec![("stiffness", self.stiffness, Positive), ("length", self.length, NotNegative)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spring_is_at_rest_at_its_length() {
        let law = Harmonic { stiffness: 40.0, length: 0.7 };
        assert_eq!((law.energy(0.7), law.force(0.7)), (0.0, 0.0));
        assert!((law.energy(1.7) - 20.0).abs() < 1e-12 && (law.force(1.7) + 40.0).abs() < 1e-12);
        crate::potential::checks::check_gradients(&law, 0.01, 3.0);
    }
}
