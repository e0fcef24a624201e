//! Histograms of correlated series: densities with errors that allow for the correlation.

use crate::error::{AnalysisError, require_length};
use crate::estimate::Estimate;
use crate::segments::{Segments, Stretches, Sums};
use serde::{Deserialize, Serialize};

/// Stretches of a run that errors come from.
const STRETCHES: u64 = 16;
/// Neighboring stretches whose counts are correlated by more than this are too short.
const CORRELATED: f64 = 0.5;

/// Streaming histogram over equal bins of a fixed range.
///
/// Values below and above the range are counted, and are in the normalization of the density.
///
/// **Error.** The scatter of the counts over 16 stretches of each run (Student's t with 15 degrees of freedom), which must be long compared
/// with the correlation time: if the counts of neighboring stretches are correlated, a warning that begins with "too short" says so.
///
/// **Memory** 128 (bins + 2) counts at most; time for one value O(1).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Histogram {
    low: f64,
    high: f64,
    bins: usize,
    segments: Segments<Counts>,
}

/// Values by bin: those below the range first, those above it last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Counts(Vec<u64>);

/// One bin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistogramBin {
    /// Lower end: part of the bin.
    pub low: f64,
    /// Upper end: part of the next bin.
    pub high: f64,
    /// Values in it.
    pub count: u64,
    /// Share of all values in the bin over its width.
    pub density: Estimate,
}

impl Sums for Counts {
    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(own, theirs)| *own += theirs);
    }
}

impl Histogram {
    /// An empty histogram of `bins` equal bins from `low` to `high`.
    ///
    /// # Errors
    /// If there are no bins, an end isn't finite, or the range is empty or too narrow for so many bins.
    pub fn new(low: f64, high: f64, bins: usize) -> Result<Self, AnalysisError> {
        if bins == 0 {
            return Err(AnalysisError::OutOfRange { name: "bins", value: 0.0, requirement: "at least 1" });
        }
        if !low.is_finite() {
            return Err(AnalysisError::OutOfRange { name: "low", value: low, requirement: "finite" });
        }
        let width = (high - low) / bins as f64;
        if !(width.is_finite() && low + width > low && high - width < high) {
            let requirement = "finite and above low by more than rounding of the ends";
            return Err(AnalysisError::OutOfRange { name: "high", value: high, requirement });
        }
        Ok(Self { low, high, bins, segments: Segments::new() })
    }

    /// Whether `state` can be what this histogram once was or will be: of the same kind, its parts fitting together.
    ///
    /// For states from files: using one that doesn't fit may panic.
    pub fn accepts(&self, state: &Self) -> bool {
        self.mismatch(state).is_none() && state.segments.are_consistent(|counts| counts.0.len() == self.bins + 2)
    }

    fn mismatch(&self, other: &Self) -> Option<(&'static str, f64, f64)> {
        let parameters = [
            ("bins", self.bins as f64, other.bins as f64),
            ("low", self.low, other.low),
            ("high", self.high, other.high),
        ];
        parameters.into_iter().find(|(_, own, theirs)| own != theirs)
    }

    /// Takes the next value.
    ///
    /// # Errors
    /// If it isn't a number; nothing is recorded then. Infinities are below or above the range.
    pub fn record(&mut self, value: f64) -> Result<(), AnalysisError> {
        if value.is_nan() {
            return Err(AnalysisError::OutOfRange { name: "value", value, requirement: "a number" });
        }
        let index = if value < self.low {
            0
        } else if value >= self.high {
            self.bins + 1
        } else {
            // Rounding may carry a value just below the upper end into the bin behind it.
            1 + (((value - self.low) / (self.high - self.low) * self.bins as f64) as usize).min(self.bins - 1)
        };
        self.segments.open(|| Counts(vec![0; self.bins + 2])).0[index] += 1;
        Ok(())
    }

    /// Pools a replica: an independent series of the same quantity.
    ///
    /// # Errors
    /// If the ranges or the numbers of bins differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), AnalysisError> {
        if let Some((name, left, right)) = self.mismatch(other) {
            return Err(AnalysisError::Mismatch { name, left, right });
        }
        self.segments.merge(&other.segments, |_| ());
        Ok(())
    }

    /// Values recorded, those outside of the range included.
    pub fn count(&self) -> u64 {
        self.segments.count()
    }

    /// Values below the range.
    pub fn underflow(&self) -> u64 {
        self.total(0)
    }

    /// Values above the range or at its upper end.
    pub fn overflow(&self) -> u64 {
        self.total(self.bins + 1)
    }

    /// All bins of the range in order.
    ///
    /// Errors of neighboring bins are correlated; use [`linear`](Self::linear) for what combines several.
    pub fn bins(&self) -> Vec<HistogramBin> {
        let width = (self.high - self.low) / self.bins as f64;
        let edge = |index: usize| self.low + width * index as f64;
        let bin = |index: usize| {
            let mut weights = vec![0.0; self.bins];
            weights[index] = 1.0 / width;
            let density = self.share(&weights);
            HistogramBin { low: edge(index), high: edge(index + 1), count: self.total(index + 1), density }
        };
        (0..self.bins).map(bin).collect()
    }

    /// The linear functional `Σ_b weights[b] · share(b)` of the shares of all values in the bins, such as a probability, with its error.
    ///
    /// # Errors
    /// If the number of weights isn't that of the bins.
    pub fn linear(&self, weights: &[f64]) -> Result<Estimate, AnalysisError> {
        require_length("weights", weights.len(), self.bins)?;
        Ok(self.share(weights))
    }

    fn total(&self, index: usize) -> u64 {
        self.segments.iter().map(|segment| segment.sums.0[index]).sum()
    }

    fn share(&self, weights: &[f64]) -> Estimate {
        let stretches = self.segments.stretches();
        if stretches.samples == 0 {
            return Estimate::unknown("too short: nothing was recorded");
        }
        let sum =
            |counts: &Counts| counts.0[1..].iter().zip(weights).map(|(count, weight)| *count as f64 * weight).sum();
        let sums: Vec<f64> = self.segments.iter().map(|segment| sum(&segment.sums)).collect();
        let samples = stretches.samples as f64;
        let value = sums.iter().sum::<f64>() / samples;
        let deviations = deviations(&stretches, &sums, value);
        let number = stretches.number(&stretches.of_length(stretches.samples / STRETCHES));
        let squares: f64 = deviations.iter().map(|deviation| deviation * deviation).sum();
        let neighbors: f64 = deviations.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let estimate = Estimate::new(value, (squares * number / (number - 1.0)).sqrt() / samples, number);
        if neighbors > CORRELATED * squares {
            return estimate
                .with_warning("too short: sixteenths of the series are correlated; the error is probably too small");
        }
        estimate
    }
}

/// By how much the sum over each stretch exceeds `value` for every sample.
fn deviations(stretches: &Stretches, sums: &[f64], value: f64) -> Vec<f64> {
    let mut start = 0;
    let deviation = |&(end, samples): &(usize, u64)| {
        let sum: f64 = sums[start..end].iter().sum();
        start = end;
        sum - value * samples as f64
    };
    stretches.of_length(stretches.samples / STRETCHES).iter().map(deviation).collect()
}
