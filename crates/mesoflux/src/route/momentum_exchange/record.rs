//! What runs by momentum exchange leave: means over consecutive stretches of time, so that the way to the steady state can be cut off.

use crate::route::RouteError;
use mesoflux_analysis::{AnalysisError, Blocking};
use serde::{Deserialize, Serialize};

/// Stretches of one run at most; when there are as many, neighbors are joined.
const MOST: usize = 64;

/// The means of many numbers over consecutive stretches of equal length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Stretches {
    /// Samples in each.
    length: u64,
    means: Vec<Vec<f64>>,
    /// Of the stretch under way: samples and their sums.
    samples: u64,
    sums: Vec<f64>,
}

impl Stretches {
    fn new(numbers: usize) -> Self {
        Self { length: 1, means: Vec::new(), samples: 0, sums: vec![0.0; numbers] }
    }

    fn record(&mut self, sample: &[f64]) {
        self.sums.iter_mut().zip(sample).for_each(|(sum, number)| *sum += number);
        self.samples += 1;
        if self.samples == self.length {
            let scale = 1.0 / self.length as f64;
            self.means.push(self.sums.iter().map(|sum| sum * scale).collect());
            self.samples = 0;
            self.sums.fill(0.0);
        }
        if self.means.len() == MOST {
            self.join();
        }
    }

    /// Joins neighbors; a last one without a neighbor is left out.
    fn join(&mut self) {
        let both = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        self.means = self.means.chunks_exact(2).map(both).collect();
        self.length *= 2;
    }

    fn is_consistent(&self, numbers: usize) -> bool {
        let finite = |row: &Vec<f64>| row.len() == numbers && row.iter().all(|number| number.is_finite());
        self.length.is_power_of_two()
            && self.samples < self.length
            && self.means.len() < MOST
            && self.means.iter().chain([&self.sums]).all(finite)
    }
}

/// The record of a run by momentum exchange, or of several replicas.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExchangeRecord {
    /// Numbers in a sample.
    numbers: usize,
    /// Whether the integrator tells the heat.
    pub(super) tells_heat: bool,
    /// One for each replica.
    runs: Vec<Stretches>,
}

impl ExchangeRecord {
    /// An empty record of samples of so many numbers.
    pub(super) fn new(numbers: usize) -> Self {
        Self { numbers, tells_heat: true, runs: vec![Stretches::new(numbers)] }
    }

    /// Takes a sample of the only run.
    pub(super) fn record(&mut self, sample: &[f64]) -> Result<(), AnalysisError> {
        if let Some(index) = sample.iter().position(|number| !number.is_finite()) {
            return Err(AnalysisError::NotFinite { name: "sample", index, value: sample[index] });
        }
        self.runs[0].record(sample);
        Ok(())
    }

    /// Whether a state from a file can be one of this recorder.
    pub(super) fn accepts(&self, state: &Self) -> bool {
        state.numbers == self.numbers
            && state.runs.len() == self.runs.len()
            && state.runs.iter().all(|run| run.is_consistent(self.numbers))
    }

    /// Adds the record of another replica.
    ///
    /// # Errors
    /// A record of something else.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        if self.numbers != other.numbers {
            return Err(RouteError::WrongRecord);
        }
        self.tells_heat &= other.tells_heat;
        self.runs.extend(other.runs.iter().cloned());
        Ok(())
    }

    /// Replicas.
    pub(super) fn replicas(&self) -> usize {
        self.runs.len()
    }

    /// The stretches of all replicas with equal lengths: samples in each, and the means by replica and stretch.
    pub(super) fn aligned(&self) -> Aligned {
        let length = self.runs.iter().map(|run| run.length).max().unwrap_or(1);
        let mut runs = self.runs.clone();
        for run in &mut runs {
            while run.length < length {
                run.join();
            }
        }
        Aligned { length, runs: runs.into_iter().map(|run| run.means).collect() }
    }
}

/// The stretches of all replicas, of equal lengths.
pub(super) struct Aligned {
    /// Samples in each stretch.
    pub length: u64,
    /// By replica, stretch and number.
    runs: Vec<Vec<Vec<f64>>>,
}

impl Aligned {
    /// One number over time, averaged over the replicas, as far as all of them have come.
    pub fn course(&self, number: usize) -> Vec<f64> {
        let count = self.runs.iter().map(Vec::len).min().unwrap_or(0);
        let scale = 1.0 / self.runs.len() as f64;
        (0..count).map(|k| scale * self.runs.iter().map(|run| run[k][number]).sum::<f64>()).collect()
    }

    /// Some of the numbers as a series, from a stretch on, over all replicas.
    pub fn series(&self, start: usize, numbers: std::ops::Range<usize>) -> Result<Blocking, AnalysisError> {
        let mut pooled = Blocking::new(numbers.len())?;
        for run in &self.runs {
            let mut series = Blocking::new(numbers.len())?;
            run.iter().skip(start).try_for_each(|means| series.record(&means[numbers.clone()]))?;
            pooled.merge(&series)?;
        }
        Ok(pooled)
    }

    /// Stretches that count, over all replicas.
    pub fn count(&self, start: usize) -> usize {
        self.runs.iter().map(|run| run.len().saturating_sub(start)).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    fn recorded(samples: u64) -> ExchangeRecord {
        let mut record = ExchangeRecord::new(2);
        (0..samples).for_each(|k| record.record(&[k as f64, 1.0]).unwrap());
        record
    }

    #[test]
    fn stretches_are_bounded_in_number_and_their_means_are_right() {
        let aligned = recorded(1000).aligned();
        // 1000 = 62 × 16 + 8.
        assert_eq!((aligned.length, aligned.count(0)), (16, 62));
        let course = aligned.course(0);
        assert!(course.iter().enumerate().all(|(k, mean)| (mean - (16.0 * k as f64 + 7.5)).abs() < 1e-12));
    }

    #[test]
    fn replicas_of_unlike_lengths_are_joined_to_the_longer_stretches() {
        let mut record = recorded(1000);
        record.merge(&recorded(100)).unwrap();
        let aligned = record.aligned();
        assert_eq!((aligned.length, aligned.count(0), aligned.count(1)), (16, 62 + 6, 61 + 5));
        assert_eq!(aligned.course(0).len(), 6);
        assert_eq!(aligned.series(2, 0..1).unwrap().count(), 60 + 4);
        assert!(record.merge(&ExchangeRecord::new(3)).is_err());
    }

    #[test]
    fn states_that_do_not_fit_are_refused() {
        let fresh = ExchangeRecord::new(2);
        assert!(fresh.accepts(&recorded(77)) && !fresh.accepts(&ExchangeRecord::new(3)));
        let mut bad = recorded(77);
        bad.runs[0].means[3].pop();
        assert!(!fresh.accepts(&bad));
        let mut bad = recorded(77);
        bad.runs.push(Stretches::new(2));
        assert!(!fresh.accepts(&bad));
    }
}
