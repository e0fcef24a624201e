//! The finitely extensible nonlinear elastic spring of Warner; in the bead-spring polymers of Kremer and Grest,
//! J. Chem. Phys. 92, 5057 (1990), k = 30 ε/σ² and R = 1.5 σ together with the repulsion of WCA.

use super::PairPotential;
use crate::elementary::ln;
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

/// u(r) = −½ k R² ln(1 − (r/R)²), f(r) = −k r/(1 − (r/R)²) for r < R, which no bond can reach.
///
/// It only attracts: what keeps the bonded particles apart is their pair potential.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fene {
    /// k: the stiffness of a short bond.
    pub stiffness: f64,
    /// R: the length that a bond can't reach.
    pub longest: f64,
}

impl PairPotential for Fene {
    fn cutoff(&self) -> f64 {
        self.longest
    }

    #[inline(always)]
    fn energy(&self, r: f64) -> f64 {
        let squared = (r / self.longest).powi(2);
        let rest = 1.0 - squared;
        // ln(1 − x) with what rounding took from 1 − x given back: a short bond has its energy to full precision.
        let logarithm = ln(rest) - (squared - (1.0 - rest)) / rest;
        -0.5 * self.stiffness * self.longest * self.longest * logarithm
    }

    #[inline(always)]
    fn force<R: Real>(&self, r: R) -> R {
        let stretch = r / R::splat(self.longest);
        R::splat(-self.stiffness) * r / (R::splat(1.0) - stretch * stretch)
    }

    #[inline(always)]
    fn force_derivative(&self, r: f64) -> f64 {
        let squared = (r / self.longest).powi(2);
        -self.stiffness * (1.0 + squared) / (1.0 - squared).powi(2)
    }

    fn parameters(&self) -> Vec<(&'static str, f64, super::Requirement)> {
        use super::Requirement::Positive;
        vec![("stiffness", self.stiffness, Positive), ("longest", self.longest, Positive)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_bond_is_a_spring_and_a_long_one_costs_more_than_anything() {
        let law = Fene { stiffness: 30.0, longest: 1.5 };
        assert_eq!((law.energy(0.0), law.force(0.0)), (0.0, 0.0));
        assert!((law.energy(1e-3) / (15.0 * 1e-6) - 1.0).abs() < 1e-6);
        assert!((law.force(0.75) + 30.0).abs() < 1e-12, "30 · 0.75/(1 − ¼) = 30");
        assert!(law.energy(1.5 - 1e-12) > 800.0 && law.force(1.5 - 1e-12) < -1e12);
        crate::potential::checks::check_gradients(&law, 0.01, 1.4);
    }
}
