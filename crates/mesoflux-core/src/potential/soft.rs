//! The soft repulsion of Groot and Warren, J. Chem. Phys. 107, 4423 (1997).

use super::PairPotential;
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

/// u(r) = ½ a r_c (1 − r/r_c)², f(r) = a (1 − r/r_c) for r < r_c, nothing beyond.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soft {
    /// a: the force at contact.
    pub repulsion: f64,
    /// r_c.
    pub cutoff: f64,
}

impl PairPotential for Soft {
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn energy(&self, r: f64) -> f64 {
        0.5 * self.repulsion * self.cutoff * (1.0 - r / self.cutoff).powi(2)
    }

    #[inline(always)]
    fn force<R: Real>(&self, r: R) -> R {
        R::splat(self.repulsion) * (R::splat(1.0) - r * R::splat(1.0 / self.cutoff))
    }

    #[inline(always)]
    fn force_derivative(&self, _r: f64) -> f64 {
        -self.repulsion / self.cutoff
    }

    fn parameters(&self) -> Vec<(&'static str, f64, super::Requirement)> {
        use super::Requirement::{Finite, Positive};
        vec![("repulsion", self.repulsion, Finite), ("cutoff", self.cutoff, Positive)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_at_contact_and_at_the_cutoff() {
        let law = Soft { repulsion: 25.0, cutoff: 2.0 };
        assert_eq!((law.energy(0.0), law.force(0.0)), (25.0, 25.0));
        assert_eq!((law.energy(2.0), law.force(2.0)), (0.0, 0.0));
        crate::potential::checks::check_law(&law, 0.01, true);
    }
}
