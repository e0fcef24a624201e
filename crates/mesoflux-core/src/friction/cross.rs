//! Friction that weakens with the speed at which two particles pass each other.

use super::linear::Linear;
use super::{Dependence, Factor, Motion, PairFriction};
use crate::elementary::exp;
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// γ₀ e^(−γ₁ S) (1 − r/r_c)^s with S = (r_ij × v_ij)² = r² w², w the transverse relative speed (Naseri, Salueña & Bonet Avalos,
/// Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 28, 30): the model *Cross*.
///
/// An impulse along the line of centers leaves S as it is, so that friction and noise balance without any correction (Λ = 0).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cross {
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

impl Cross {
    /// The linear friction that is left at rest.
    pub(super) fn at_rest(&self) -> Linear {
        Linear { coefficient: self.coefficient, cutoff: self.cutoff, exponent: self.exponent }
    }
}

impl PairFriction for Cross {
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        self.at_rest().amplitude(r)
    }

    #[inline(always)]
    fn factor<R: Real>(&self, motion: Motion<R>) -> Factor<R> {
        let squared = motion.distance * motion.distance * motion.transverse_squared;
        Factor { value: exp(R::splat(-self.thinning) * squared), slope: R::splat(0.0) }
    }

    fn dependence(&self) -> Dependence {
        Dependence::Transverse
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
        let law = Cross { coefficient: 5.0, thinning: 0.7, cutoff: 1.0, exponent: 2.0 };
        crate::friction::checks::check_law(&law, |r, _, w| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * w).powi(2)).exp());
    }
}
