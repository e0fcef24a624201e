//! Sums of lagged products of block averages.

use super::{FIRST_LAG, LAGS};
use crate::segments::Sums;
use serde::{Deserialize, Serialize};

/// The latest block averages of one level: what the next block is multiplied with.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct DelayLine {
    /// Entry `channel * LAGS + k` is the block k blocks ago.
    values: Vec<f64>,
    /// Blocks held, at most [`LAGS`].
    held: usize,
    /// Whether the latest block waits for a partner to form a block of the next level.
    waiting: bool,
}

/// Sums over pairs of blocks (a later one, an earlier one k blocks before) at one level.
///
/// Entry `slot * lags + (k − first)`, a slot for each pair or one for all, with lags `first` to `LAGS − 1`: a higher level needs none
/// that lower ones resolve better.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LevelSums {
    /// Number of pairs of blocks by lag.
    pub(super) counts: Vec<u64>,
    /// Σ later · earlier.
    pub(super) products: Vec<f64>,
    /// Σ later.
    pub(super) later: Vec<f64>,
    /// Σ earlier.
    pub(super) earlier: Vec<f64>,
}

/// What a correlator sums. A product belongs to the segment in which its later block was completed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LagSums {
    /// Sum of the samples, by channel.
    pub(super) sum: Vec<f64>,
    pub(super) levels: Vec<LevelSums>,
}

/// First lag kept at a level.
pub(super) fn first_lag(level: usize) -> usize {
    if level == 0 { 0 } else { FIRST_LAG }
}

impl DelayLine {
    pub(super) fn new(channels: usize) -> Self {
        Self { values: vec![0.0; channels * LAGS], held: 0, waiting: false }
    }

    pub(super) fn is_consistent(&self, channels: usize) -> bool {
        self.values.len() == channels * LAGS && self.held <= LAGS
    }

    pub(super) fn push(&mut self, block: &[f64]) {
        for (values, new) in self.values.chunks_exact_mut(LAGS).zip(block) {
            values.copy_within(..LAGS - 1, 1);
            values[0] = *new;
        }
        self.held = LAGS.min(self.held + 1);
    }

    /// If the latest block completes a pair, leaves the pair's mean in `block`.
    pub(super) fn completes(&mut self, block: &mut [f64]) -> bool {
        self.waiting = !self.waiting;
        if self.waiting {
            return false;
        }
        for (values, mean) in self.values.chunks_exact(LAGS).zip(block) {
            *mean = 0.5 * (values[0] + values[1]);
        }
        true
    }
}

impl LevelSums {
    fn new(level: usize, slots: usize) -> Self {
        let lags = LAGS - first_lag(level);
        let zeros = vec![0.0; slots * lags];
        Self { counts: vec![0; lags], products: zeros.clone(), later: zeros.clone(), earlier: zeros }
    }

    fn is_consistent(&self, level: usize, slots: usize) -> bool {
        let lags = LAGS - first_lag(level);
        self.counts.len() == lags
            && [&self.products, &self.later, &self.earlier].iter().all(|sums| sums.len() == slots * lags)
    }

    /// Adds the products of the latest block with those before it; of more pairs than there are slots, into the only one.
    fn add_latest(&mut self, line: &DelayLine, pairs: &[[usize; 2]]) {
        let lags = self.counts.len();
        let first = LAGS - lags;
        let slots = self.products.len() / lags;
        let held = line.held.saturating_sub(first);
        self.counts[..held].iter_mut().for_each(|count| *count += 1);
        for (index, &[later, earlier]) in pairs.iter().enumerate() {
            let start = index % slots * lags;
            let latest = line.values[later * LAGS];
            let before = &line.values[earlier * LAGS + first..][..held];
            for (product, value) in self.products[start..start + held].iter_mut().zip(before) {
                *product += latest * value;
            }
            for (sum, value) in self.earlier[start..start + held].iter_mut().zip(before) {
                *sum += value;
            }
            self.later[start..start + held].iter_mut().for_each(|sum| *sum += latest);
        }
    }

    fn add(&mut self, other: &Self) {
        for (own, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *own += theirs;
        }
        for (own, theirs) in [
            (&mut self.products, &other.products),
            (&mut self.later, &other.later),
            (&mut self.earlier, &other.earlier),
        ] {
            own.iter_mut().zip(theirs).for_each(|(own, theirs)| *own += theirs);
        }
    }

    /// Sum of products of deviations from other origins, the blocks' values being larger by `later` and `earlier`, for one entry.
    pub(super) fn shifted_product(&self, slot: usize, lag: usize, later: f64, earlier: f64) -> f64 {
        let entry = slot * self.counts.len() + lag;
        self.products[entry]
            + later * self.earlier[entry]
            + earlier * self.later[entry]
            + self.counts[lag] as f64 * later * earlier
    }
}

impl LagSums {
    pub(super) fn new(channels: usize) -> Self {
        Self { sum: vec![0.0; channels], levels: Vec::new() }
    }

    pub(super) fn is_consistent(&self, channels: usize, slots: usize) -> bool {
        self.sum.len() == channels
            && self.levels.len() <= u64::BITS as usize
            && self.levels.iter().enumerate().all(|(index, level)| level.is_consistent(index, slots))
    }

    pub(super) fn add_sample(&mut self, sample: &[f64]) {
        self.sum.iter_mut().zip(sample).for_each(|(sum, value)| *sum += value);
    }

    pub(super) fn add_latest(&mut self, level: usize, line: &DelayLine, pairs: &[[usize; 2]], slots: usize) {
        while self.levels.len() <= level {
            self.levels.push(LevelSums::new(self.levels.len(), slots));
        }
        self.levels[level].add_latest(line, pairs);
    }

    /// Rewrites all sums over `samples` samples relative to an origin that lies below the present one by `offset` in each channel.
    pub(super) fn shift(&mut self, samples: u64, offset: &[f64], pairs: &[[usize; 2]]) {
        for (sum, offset) in self.sum.iter_mut().zip(offset) {
            *sum += samples as f64 * offset;
        }
        for level in &mut self.levels {
            for (pair, &[later, earlier]) in pairs.iter().enumerate() {
                for lag in 0..level.counts.len() {
                    let entry = pair * level.counts.len() + lag;
                    level.products[entry] = level.shifted_product(pair, lag, offset[later], offset[earlier]);
                    level.later[entry] += level.counts[lag] as f64 * offset[later];
                    level.earlier[entry] += level.counts[lag] as f64 * offset[earlier];
                }
            }
        }
    }
}

impl Sums for LagSums {
    fn add(&mut self, other: &Self) {
        self.sum.iter_mut().zip(&other.sum).for_each(|(own, theirs)| *own += theirs);
        for (own, theirs) in self.levels.iter_mut().zip(&other.levels) {
            own.add(theirs);
        }
        let known = self.levels.len();
        self.levels.extend(other.levels.iter().skip(known).cloned());
    }
}
