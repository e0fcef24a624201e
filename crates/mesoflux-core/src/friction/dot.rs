//! Friction that weakens with the speed at which two particles approach or part.

use super::linear::Linear;
use super::{Dependence, Factor, Motion, PairFriction};
use crate::elementary::exp;
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// γ₀ e^(−γ₁ S) (1 − r/r_c)^s with S = (r_ij · v_ij)² = r² u², u the radial relative speed (Naseri, Salueña & Bonet Avalos,
/// Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 29, 30): the model *Dot*.
///
/// The impulses of the pair change S itself: the noise needs the correction Λ (see [`super::fluctuation_dissipation`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dot {
    /// γ₀: the friction coefficient at rest.
    pub coefficient: f64,
    /// γ₁: how fast the friction falls with S.
    pub thinning: f64,
    /// r_c.
    pub cutoff: f64,
    /// s.
    #[serde(default = "Linear::default_exponent")]
    pub exponent: f64,
}

impl Dot {
    /// The linear friction that is left at rest.
    pub(super) fn at_rest(&self) -> Linear {
        Linear { coefficient: self.coefficient, cutoff: self.cutoff, exponent: self.exponent }
    }
}

impl PairFriction for Dot {
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        self.at_rest().amplitude(r)
    }

    #[inline(always)]
    fn factor<R: Real>(&self, motion: Motion<R>) -> Factor<R> {
        let rate = R::splat(-self.thinning) * (motion.distance * motion.distance) * motion.radial;
        let value = exp(rate * motion.radial);
        Factor { value, slope: (rate + rate) * value }
    }

    fn dependence(&self) -> Dependence {
        Dependence::Radial
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        let mut parameters = self.at_rest().parameters();
        parameters.push(("thinning", self.thinning, Requirement::NotNegative));
        parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_documented_law() {
        let law = Dot { coefficient: 5.0, thinning: 0.7, cutoff: 1.0, exponent: 2.0 };
        crate::friction::checks::check_law(&law, |r, u, _| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * u).powi(2)).exp());
    }
}
