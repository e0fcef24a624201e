//! Mean squared displacement of particles against time, with honest errors for any linear functional of it.

use crate::blocking::Blocking;
use crate::error::{AnalysisError, require_finite, require_length};
use crate::estimate::Estimate;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Streaming mean squared displacement, every configuration being an origin of time.
///
/// Once `lags` earlier configurations are held, each new one (number n) gives one vector
///
/// `v_k = (1/N) Σ_i |x_i(n) − x_i(n − k)|²`,  k = 1 … `lags`,
///
/// which goes to a [`Blocking`] with one component a lag. Overlapping origins make the vectors correlated in time and
/// between lags; blocking the whole vector accounts for both. Memory: `lags` configurations and O(lags² log n) numbers;
/// time for one record: O(lags · N + lags²).
///
/// Lengths and times are in the caller's units.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MeanSquaredDisplacement {
    particles: usize,
    lags: usize,
    spacing: f64,
    drift_removed: bool,
    /// The latest `lags` configurations, the newest at the front: entry k − 1 is k records old.
    history: VecDeque<Vec<[f64; 3]>>,
    pub(crate) displacements: Blocking,
}

impl MeanSquaredDisplacement {
    /// An empty accumulator for `particles` particles, recorded every `spacing` units of time, with `lags` time differences.
    ///
    /// # Errors
    /// If there are no particles or lags, or if the spacing isn't positive and finite.
    pub fn new(particles: usize, lags: usize, spacing: f64) -> Result<Self, AnalysisError> {
        if particles == 0 {
            return Err(AnalysisError::OutOfRange { name: "particles", value: 0.0, requirement: "at least 1" });
        }
        if lags == 0 {
            return Err(AnalysisError::OutOfRange { name: "lags", value: 0.0, requirement: "at least 1" });
        }
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(AnalysisError::OutOfRange {
                name: "spacing",
                value: spacing,
                requirement: "positive and finite",
            });
        }
        // Displacements of overlapping origins are correlated over `lags` records even for independent steps.
        let displacements = Blocking::new(lags)?.with_minimum_block_length(2 * lags as u64);
        Ok(Self { particles, lags, spacing, drift_removed: false, history: VecDeque::new(), displacements })
    }

    /// Measures displacements relative to the centroid of the particles.
    ///
    /// For N independent particles this reduces the mean squared displacement by the factor 1 − 1/N, which isn't
    /// corrected: where momentum is conserved the centroid (of equal masses) moves with constant velocity and nothing is lost.
    ///
    /// # Errors
    /// If there is only one particle, or if something was recorded already.
    pub fn remove_drift(mut self) -> Result<Self, AnalysisError> {
        if self.particles < 2 {
            let value = self.particles as f64;
            return Err(AnalysisError::OutOfRange {
                name: "particles",
                value,
                requirement: "at least 2 to remove a drift",
            });
        }
        if !self.history.is_empty() || self.displacements.count() > 0 {
            return Err(AnalysisError::Underdetermined("removing the drift must be decided before the first record"));
        }
        self.drift_removed = true;
        Ok(self)
    }

    /// Whether `state` can be what this accumulator once was or will be: of the same kind, its parts fitting together.
    ///
    /// For states from files: using one that doesn't fit may panic.
    pub fn accepts(&self, state: &Self) -> bool {
        state.particles == self.particles
            && state.lags == self.lags
            && state.spacing == self.spacing
            && state.drift_removed == self.drift_removed
            && state.history.len() <= self.lags
            && state.history.iter().all(|configuration| configuration.len() == self.particles)
            && self.displacements.accepts(&state.displacements)
    }

    /// Number of time differences.
    pub fn lags(&self) -> usize {
        self.lags
    }

    /// Time between records.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of vectors averaged over, over all replicas: records less the first `lags` of each.
    pub fn origins(&self) -> u64 {
        self.displacements.count()
    }

    /// Takes the next configuration: unwrapped positions, always in the same order of particles.
    ///
    /// # Errors
    /// If the number of particles differs or a coordinate isn't finite; nothing is recorded then.
    pub fn record(&mut self, positions: &[[f64; 3]]) -> Result<(), AnalysisError> {
        require_length("positions", positions.len(), self.particles)?;
        require_finite("positions (three a particle)", positions.as_flattened())?;
        let mut configuration = positions.to_vec();
        if self.drift_removed {
            subtract_centroid(&mut configuration);
        }
        if self.history.len() == self.lags {
            let displacements: Vec<f64> =
                self.history.iter().map(|earlier| mean_squared_distance(&configuration, earlier)).collect();
            self.displacements.record(&displacements)?;
            self.history.pop_back();
        }
        self.history.push_front(configuration);
        Ok(())
    }

    /// Pools a replica. The configurations it holds are left out: no displacement spans the seam.
    ///
    /// # Errors
    /// If lags, spacing or the removal of drift differ. The numbers of particles must be equal, too: otherwise the vectors
    /// wouldn't have one variance.
    pub fn merge(&mut self, other: &Self) -> Result<(), AnalysisError> {
        for (name, left, right) in [
            ("particles", self.particles as f64, other.particles as f64),
            ("lags", self.lags as f64, other.lags as f64),
            ("spacing", self.spacing, other.spacing),
            ("drift removed (1: yes)", f64::from(self.drift_removed), f64::from(other.drift_removed)),
        ] {
            if left != right {
                return Err(AnalysisError::Mismatch { name, left, right });
            }
        }
        self.displacements.merge(&other.displacements)
    }

    /// Lets go of the earlier configurations, which take nearly all of the memory: what was measured stays, and whatever is
    /// recorded next begins anew, as after a seam.
    pub fn forget_configurations(&mut self) {
        self.history = VecDeque::new();
    }

    /// Pairs of time difference and mean squared displacement.
    ///
    /// The errors of different times are strongly correlated; use [`linear`](Self::linear) for what combines several.
    pub fn curve(&self) -> Vec<(f64, Estimate)> {
        (0..self.lags).map(|index| (self.time(index + 1), self.displacements.component(index))).collect()
    }

    /// The linear functional `Σ_k weights[k − 1] · msd(k · spacing)` of the curve, such as a slope, with its error.
    pub fn linear(&self, weights: &[f64]) -> Estimate {
        self.displacements.linear(weights)
    }

    /// Time difference of lag k.
    pub(crate) fn time(&self, lag: usize) -> f64 {
        lag as f64 * self.spacing
    }
}

fn subtract_centroid(configuration: &mut [[f64; 3]]) {
    for axis in 0..3 {
        let centroid = configuration.iter().map(|x| x[axis]).sum::<f64>() / configuration.len() as f64;
        for x in configuration.iter_mut() {
            x[axis] -= centroid;
        }
    }
}

fn mean_squared_distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two particles moving apart along x with unit speed, the pair drifting along y.
    fn separating(drift: f64, records: usize) -> Vec<[[f64; 3]; 2]> {
        (0..records).map(|n| n as f64).map(|t| [[t, drift * t, 0.0], [-t, drift * t, 0.0]]).collect()
    }

    #[test]
    fn uniform_motion_by_hand() {
        let mut plain = MeanSquaredDisplacement::new(2, 3, 0.5).unwrap();
        let mut relative = plain.clone().remove_drift().unwrap();
        for positions in separating(2.0, 10) {
            plain.record(&positions).unwrap();
            relative.record(&positions).unwrap();
        }
        assert_eq!(plain.origins(), 7);
        for (index, ((time, plain), (_, relative))) in plain.curve().iter().zip(relative.curve()).enumerate() {
            let lag = (index + 1) as f64;
            assert_eq!((*time, plain.value, relative.value), (0.5 * lag, Some(5.0 * lag * lag), Some(lag * lag)));
        }
    }

    #[test]
    fn forgotten_configurations_leave_the_curve() {
        let mut displacement = MeanSquaredDisplacement::new(2, 3, 0.5).unwrap();
        let records = separating(2.0, 10);
        records.iter().for_each(|positions| displacement.record(positions).unwrap());
        let curve = displacement.curve();
        displacement.forget_configurations();
        assert_eq!((displacement.curve(), displacement.origins()), (curve, 7));
        records[..5].iter().for_each(|positions| displacement.record(positions).unwrap());
        assert_eq!(displacement.origins(), 9, "three records pass before there are displacements again");
    }

    #[test]
    fn merging_ignores_the_seam() {
        let mut first = MeanSquaredDisplacement::new(2, 3, 1.0).unwrap();
        let mut second = first.clone();
        for (index, positions) in separating(0.0, 10).iter().enumerate() {
            first.record(positions).unwrap();
            if index < 8 {
                second.record(positions).unwrap();
            }
        }
        first.merge(&second).unwrap();
        assert_eq!((first.origins(), first.curve()[2].1.value), (12, Some(9.0)));
    }

    #[test]
    fn a_state_of_another_kind_or_with_missing_parts_is_not_accepted() {
        let new = |particles, lags, spacing| MeanSquaredDisplacement::new(particles, lags, spacing).unwrap();
        let mut good = new(2, 3, 1.0);
        good.record(&[[0.0; 3]; 2]).unwrap();
        assert!(new(2, 3, 1.0).accepts(&good));
        for other in [new(3, 3, 1.0), new(2, 4, 1.0), new(2, 3, 2.0), new(2, 3, 1.0).remove_drift().unwrap()] {
            assert!(!other.accepts(&good));
        }
        let mut bad = good.clone();
        bad.history[0].pop();
        assert!(!good.accepts(&bad));
    }

    #[test]
    fn bad_input_is_refused() {
        assert!(MeanSquaredDisplacement::new(0, 3, 1.0).is_err());
        assert!(MeanSquaredDisplacement::new(2, 0, 1.0).is_err());
        assert!(MeanSquaredDisplacement::new(2, 3, f64::NAN).is_err());
        assert!(MeanSquaredDisplacement::new(1, 3, 1.0).unwrap().remove_drift().is_err());
        let mut recorder = MeanSquaredDisplacement::new(2, 3, 1.0).unwrap();
        assert!(recorder.record(&[[0.0; 3]; 3]).is_err());
        assert!(recorder.record(&[[0.0, f64::INFINITY, 0.0]; 2]).is_err());
        assert!(recorder.merge(&MeanSquaredDisplacement::new(2, 3, 2.0).unwrap()).is_err());
        assert!(recorder.merge(&recorder.clone().remove_drift().unwrap()).is_err());
        assert_eq!(recorder.curve()[0].1.value, None);
    }
}
