//! A friction coefficient that falls with the square of a speed, with the parameters that *Cross* and *Dot* have in common.

use super::PairFriction;
use super::linear::Linear;
use crate::elementary::exp;
use crate::lanes::Real;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// γ₀ e^(−γ₁ S) (1 − r/r_c)^s (Naseri, Salueña & Bonet Avalos, Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 28 to 30); which speed S
/// is the square of is what the laws differ in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thinning {
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

impl Thinning {
    /// The linear friction that is left at rest.
    pub(super) fn at_rest(&self) -> Linear {
        Linear { coefficient: self.coefficient, cutoff: self.cutoff, exponent: self.exponent }
    }

    /// e^(−γ₁ S).
    #[inline(always)]
    pub(super) fn factor<R: Real>(&self, s: R) -> R {
        exp(R::splat(-self.thinning) * s)
    }

    /// Name, value and requirement of every number that a user gives.
    pub(super) fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        let mut parameters = self.at_rest().parameters();
        parameters.push(("thinning", self.thinning, Requirement::NotNegative));
        parameters
    }
}
