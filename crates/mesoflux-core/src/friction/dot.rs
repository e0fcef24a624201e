//! Friction that weakens with the speed at which two particles approach or part.

use super::thinning::Thinning;
use super::{Dependence, Factor, Motion, PairFriction};
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// [`Thinning`] with S = (r_ij · v_ij)² = r² u², u the radial relative speed (Naseri, Salueña & Bonet Avalos,
/// Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 29, 30): the model *Dot*.
///
/// The impulses of the pair change S itself: the noise needs the correction Λ (see [`super::fluctuation_dissipation`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dot(pub Thinning);

impl PairFriction for Dot {
    fn cutoff(&self) -> f64 {
        self.0.cutoff
    }

    #[inline(always)]
    fn amplitude<R: Real>(&self, r: R) -> R {
        self.0.at_rest().amplitude(r)
    }

    #[inline(always)]
    fn factor<R: Real>(&self, motion: Motion<R>) -> Factor<R> {
        let rate = motion.distance * motion.distance * motion.radial;
        let value = self.0.factor(rate * motion.radial);
        Factor { value, slope: R::splat(-2.0 * self.0.thinning) * rate * value }
    }

    fn dependence(&self) -> Dependence {
        Dependence::Radial
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
        let law = Dot(Thinning { coefficient: 5.0, thinning: 0.7, cutoff: 1.0, exponent: 2.0 });
        crate::friction::checks::check_law(&law, |r, u, _| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * u).powi(2)).exp());
    }
}
