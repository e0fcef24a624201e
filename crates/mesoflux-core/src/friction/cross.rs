//! Friction that weakens with the speed at which two particles pass each other.

use super::thinning::Thinning;
use super::{Dependence, Factor, Motion, PairFriction};
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// [`Thinning`] with S = (r_ij × v_ij)² = r² w², w the transverse relative speed (Naseri, Salueña & Bonet Avalos,
/// Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 28, 30): the model *Cross*.
///
/// An impulse along the line of centers leaves S as it is, so that friction and noise balance without any correction (Λ = 0).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cross(pub Thinning);

impl PairFriction for Cross {
    fn cutoff(&self) -> f64 {
        self.0.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        self.0.at_rest().amplitude(r)
    }

    #[inline(always)]
    fn factor<R: Real>(&self, motion: Motion<R>) -> Factor<R> {
        let squared = motion.distance * motion.distance * motion.transverse_squared;
        Factor { value: self.0.factor(squared), slope: R::splat(0.0) }
    }

    fn dependence(&self) -> Dependence {
        Dependence::Transverse
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        self.0.parameters()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_documented_law() {
        let law = Cross(Thinning { coefficient: 5.0, thinning: 0.7, cutoff: 1.0, exponent: 2.0 });
        crate::friction::checks::check_law(&law, |r, _, w| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * w).powi(2)).exp());
    }
}
