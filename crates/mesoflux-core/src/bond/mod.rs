//! Bonds: by which law, and in `topology` who is bonded to whom.
//!
//! A bond is a pair that stays a pair: it needs no list and no cutoff. Bonded particles feel the pair laws like all others,
//! unless the topology excludes them.

mod topology;

pub(crate) use topology::Broken;
pub use topology::{Bond, ExclusionRange, Topology, TopologyError};

use crate::potential::fene::Fene;
use crate::potential::harmonic::Harmonic;
use crate::potential::{PairPotential, Potential, Requirement};
use serde::{Deserialize, Serialize};

/// Any of the known laws of bonds, by its name in the input file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BondLaw {
    /// A harmonic spring.
    Harmonic(Harmonic),
    /// A finitely extensible spring.
    Fene(Fene),
}

/// Evaluates `$body` with the concrete law.
macro_rules! with_law {
    ($bond:expr, $law:ident => $body:expr) => {
        match $bond {
            BondLaw::Harmonic($law) => $body,
            BondLaw::Fene($law) => $body,
        }
    };
}

impl BondLaw {
    /// The length that a bond can't reach; infinite where there is none.
    pub fn longest(&self) -> f64 {
        with_law!(self, law => law.cutoff())
    }

    /// u(r).
    pub fn energy(&self, r: f64) -> f64 {
        with_law!(self, law => law.energy(r))
    }

    /// f(r) = −u'(r).
    #[inline]
    pub fn force(&self, r: f64) -> f64 {
        with_law!(self, law => law.force(r))
    }

    /// f'(r).
    pub fn force_derivative(&self, r: f64) -> f64 {
        with_law!(self, law => law.force_derivative(r))
    }

    /// Name, value and requirement of every number that a user gives.
    pub fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        with_law!(self, law => law.parameters())
    }

    /// The most likely length at kT of a bond between particles that also feel `pair`: the largest of r² exp(−u(r)/kT).
    pub fn most_likely_length(&self, pair: Option<&Potential>, temperature: f64) -> f64 {
        let cost = |r: f64| {
            let pair = pair.map_or(0.0, |law| law.energy(r));
            (self.energy(r) + pair) / temperature - 2.0 * r.ln()
        };
        // Out to where no bond gets, or to where a spring is stretched by thirty kT.
        let mut end = 1e-6;
        while end < self.longest() && (self.force(end) >= 0.0 || self.energy(end) < 30.0 * temperature) {
            end *= 2.0;
        }
        let end = end.min(self.longest());
        let lengths = (1..10_000).map(|k| end * f64::from(k) / 10_000.0);
        lengths.min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::wca::Wca;

    #[test]
    fn the_most_likely_length_is_that_of_the_law_and_of_kremer_and_grest() {
        // r (r − l) = 2 kT/k.
        let spring = BondLaw::Harmonic(Harmonic { stiffness: 100.0, length: 1.0 });
        let expected = 0.5 * (1.0 + (1.0f64 + 8.0 / 100.0).sqrt());
        assert!((spring.most_likely_length(None, 1.0) - expected).abs() < 1e-3);
        // (r/R)² = 1/(1 + k R²/(2 kT)).
        let fene = BondLaw::Fene(Fene { stiffness: 30.0, longest: 1.5 });
        let expected = 1.5 / (1.0f64 + 33.75).sqrt();
        assert!((fene.most_likely_length(None, 1.0) - expected).abs() < 1e-3);
        let wca = Potential::Wca(Wca { epsilon: 1.0, sigma: 1.0 });
        assert!((fene.most_likely_length(Some(&wca), 1.0) - 0.97).abs() < 0.01);
    }
}
