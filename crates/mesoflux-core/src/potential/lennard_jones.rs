//! The Lennard-Jones potential, plain or made continuous at its cutoff.

use super::PairPotential;
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

/// φ(r) = 4ε[(σ/r)¹² − (σ/r)⁶] for r < r_c, nothing beyond, with what the truncation adds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LennardJones {
    /// ε: the depth of the well.
    pub epsilon: f64,
    /// σ: where the untruncated potential is zero.
    pub sigma: f64,
    /// r_c.
    pub cutoff: f64,
    /// What happens at the cutoff.
    #[serde(default)]
    pub truncation: Truncation,
}

/// How a potential u ends at its cutoff.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Truncation {
    /// u(r): energy and force jump.
    Plain,
    /// u(r) − u(r_c): the force jumps.
    Shifted,
    /// u(r) − u(r_c) − u'(r_c)(r − r_c): nothing jumps (Wu & Shang, eq. 73).
    #[default]
    ForceShifted,
}

impl LennardJones {
    /// u(r) of the untruncated potential.
    fn bare_energy(&self, r: f64) -> f64 {
        let s6 = (self.sigma / r).powi(6);
        4.0 * self.epsilon * (s6 * s6 - s6)
    }

    /// −u'(r) of the untruncated potential.
    #[inline(always)]
    fn bare_force<R: Real>(&self, r: R) -> R {
        let inverse = R::splat(1.0) / r;
        let s = R::splat(self.sigma) * inverse;
        let s2 = s * s;
        let s6 = s2 * s2 * s2;
        R::splat(24.0 * self.epsilon) * inverse * s6.mul_add(s6 + s6, -s6)
    }

    /// −u'(r_c) where the truncation takes it away, else zero.
    #[inline(always)]
    fn force_shift(&self) -> f64 {
        match self.truncation {
            Truncation::ForceShifted => self.bare_force(self.cutoff),
            Truncation::Plain | Truncation::Shifted => 0.0,
        }
    }
}

impl PairPotential for LennardJones {
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn energy(&self, r: f64) -> f64 {
        let shift = match self.truncation {
            Truncation::Plain => 0.0,
            Truncation::Shifted | Truncation::ForceShifted => self.bare_energy(self.cutoff),
        };
        self.bare_energy(r) - shift + self.force_shift() * (r - self.cutoff)
    }

    #[inline(always)]
    fn force<R: Real>(&self, r: R) -> R {
        self.bare_force(r) - R::splat(self.force_shift())
    }

    #[inline(always)]
    fn force_derivative(&self, r: f64) -> f64 {
        let s6 = (self.sigma / r).powi(6);
        -24.0 * self.epsilon * (26.0 * s6 * s6 - 7.0 * s6) / (r * r)
    }

    fn parameters(&self) -> Vec<(&'static str, f64, super::Requirement)> {
        use super::Requirement::{NotNegative, Positive};
        vec![("epsilon", self.epsilon, NotNegative), ("sigma", self.sigma, Positive), ("cutoff", self.cutoff, Positive)]
    }

    fn contact_distance(&self) -> f64 {
        if self.epsilon > 0.0 { self.sigma } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::checks::check_law;

    fn law(truncation: Truncation) -> LennardJones {
        LennardJones { epsilon: 1.5, sigma: 0.9, cutoff: 2.25, truncation }
    }

    #[test]
    fn zero_and_minimum_are_where_the_textbook_has_them() {
        let plain = law(Truncation::Plain);
        assert!(plain.energy(0.9).abs() < 1e-14);
        let minimum = 0.9 * 2f64.powf(1.0 / 6.0);
        assert!((plain.energy(minimum) + 1.5).abs() < 1e-14);
        assert!(plain.force(minimum).abs() < 1e-12);
    }

    #[test]
    fn truncations_remove_the_jumps_they_promise_to_remove() {
        let (plain, shifted, smooth) =
            (law(Truncation::Plain), law(Truncation::Shifted), law(Truncation::ForceShifted));
        assert!(plain.energy(2.25).abs() > 1e-3 && plain.force(2.25).abs() > 1e-3);
        assert!(shifted.energy(2.25).abs() < 1e-15 && shifted.force(2.25).abs() > 1e-3);
        assert!(smooth.energy(2.25).abs() < 1e-15 && smooth.force(2.25).abs() < 1e-15);
        check_law(&plain, 0.7, false);
        check_law(&shifted, 0.7, false);
        check_law(&smooth, 0.7, true);
    }
}
