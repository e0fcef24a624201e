//! The repulsive potential of Weeks, Chandler and Andersen, J. Chem. Phys. 54, 5237 (1971).

use super::PairPotential;
use super::lennard_jones::{LennardJones, Truncation};
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

/// The Lennard-Jones potential cut at its minimum r_c = 2^(1/6) σ and shifted to zero there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wca {
    /// ε.
    pub epsilon: f64,
    /// σ.
    pub sigma: f64,
}

impl Wca {
    /// 2^(1/6).
    const MINIMUM: f64 = 1.122_462_048_309_373;

    #[inline(always)]
    fn lennard_jones(&self) -> LennardJones {
        LennardJones {
            epsilon: self.epsilon,
            sigma: self.sigma,
            cutoff: Self::MINIMUM * self.sigma,
            truncation: Truncation::Shifted,
        }
    }
}

impl PairPotential for Wca {
    fn cutoff(&self) -> f64 {
        self.lennard_jones().cutoff
    }

    #[inline(always)]
    fn energy(&self, r: f64) -> f64 {
        self.lennard_jones().energy(r)
    }

    #[inline(always)]
    fn force<R: Real>(&self, r: R) -> R {
        self.lennard_jones().force(r)
    }

    #[inline(always)]
    fn force_derivative(&self, r: f64) -> f64 {
        self.lennard_jones().force_derivative(r)
    }

    fn parameters(&self) -> Vec<(&'static str, f64, super::Requirement)> {
        use super::Requirement::{NotNegative, Positive};
        vec![("epsilon", self.epsilon, NotNegative), ("sigma", self.sigma, Positive)]
    }

    fn contact_distance(&self) -> f64 {
        self.lennard_jones().contact_distance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_at_sigma_is_epsilon_and_nothing_jumps() {
        let law = Wca { epsilon: 2.0, sigma: 1.1 };
        assert!((law.energy(1.1) - 2.0).abs() < 1e-12);
        assert!(law.force(1.0) > 0.0);
        crate::potential::checks::check_law(&law, 0.8, true);
    }
}
