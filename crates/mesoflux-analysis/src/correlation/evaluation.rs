//! Linear functionals of a correlation function, with errors from the scatter of segments.

use super::sums::{LagSums, first_lag};
use super::{LAGS, MultipleTau};
use crate::segments::{Segment, Stretches};
use std::ops::Range;

/// Stretches of time whose means tell how far the overall mean is off.
const MEANS: u64 = 16;

/// The pooled correlation function and how each segment deviates from it.
pub(super) struct Evaluation {
    /// By level and lag.
    levels: Vec<Vec<Functional>>,
    stretches: Stretches,
    pairs: usize,
    pub(super) samples: u64,
}

/// A functional of the correlation function: its value, and what segments and pairs (segment-major) contribute to its deviation.
#[derive(Clone)]
pub(super) struct Functional {
    pub(super) value: f64,
    deviations: Vec<f64>,
}

/// The scatter of a functional.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scatter {
    pub(super) standard_error: f64,
    /// Independent samples behind it.
    pub(super) number: f64,
}

impl Functional {
    /// Adds `factor` times another functional.
    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        self.value += factor * other.value;
        for (own, theirs) in self.deviations.iter_mut().zip(&other.deviations) {
            *own += factor * theirs;
        }
    }
}

impl Evaluation {
    /// Of the correlator's pairs with these indices; 0 is all of them where they share one sum.
    pub(super) fn new(correlator: &MultipleTau, pairs: Range<usize>) -> Self {
        let segments: Vec<&Segment<LagSums>> = correlator.segments.iter().collect();
        let stretches = correlator.segments.stretches();
        let means = means(correlator, &segments, stretches.samples);
        let correction = mean_covariance(correlator, pairs.clone(), &segments, &means, &stretches);
        // Sums become those of deviations from the mean, or from zero in channels that keep it.
        let removed = means.iter().zip(&correlator.mean_removed);
        let offsets: Vec<f64> = removed.map(|(mean, removed)| if *removed { -mean } else { 0.0 }).collect();
        let depth = segments.iter().map(|segment| segment.sums.levels.len()).max().unwrap_or(0);
        let lags = |level| (0..LAGS - first_lag(level)).map(move |lag| (level, lag));
        let at = |(level, lag)| pooled(correlator, pairs.clone(), &segments, level, lag, &offsets, correction);
        let levels = (0..depth).map(|level| lags(level).map(at).collect()).collect();
        Self { levels, pairs: pairs.len(), samples: stretches.samples, stretches }
    }

    /// The functional that is zero.
    pub(super) fn zero(&self) -> Functional {
        Functional { value: 0.0, deviations: vec![0.0; self.stretches.len() * self.pairs] }
    }

    /// The functional `Σ_{t=0}^{end−1} w(t) C(t)`, lags t in samples.
    ///
    /// Without bias if w is linear between neighboring lags of the levels and zero at `end`: triangles of each level add up to w there, the
    /// first one of a level reaching down to the last lag of the level below.
    pub(super) fn window(&self, end: u64, weight: impl Fn(u64) -> f64) -> Functional {
        let mut functional = self.zero();
        let clipped = |lag: u64| if lag < end { weight(lag) } else { 0.0 };
        for (level, lags) in self.levels.iter().enumerate() {
            let first = first_lag(level);
            if (first as u64) << level >= end {
                break;
            }
            for (index, lag) in lags.iter().enumerate() {
                let number = (first + index) as u64;
                let mut height = clipped(number << level);
                if first + index == LAGS - 1 {
                    height -= 0.5 * clipped((number + 1) << level);
                }
                if height != 0.0 {
                    // A product of averages over B samples is a triangle of height 1/B.
                    functional.add(lag, height * (1u64 << level) as f64);
                }
            }
        }
        functional
    }

    /// All lags in samples with C(t), smeared above level 0, in order.
    pub(super) fn lags(&self) -> impl Iterator<Item = (u64, &Functional)> {
        let lag = |level: usize, index: usize| ((first_lag(level) + index) as u64) << level;
        self.levels.iter().enumerate().flat_map(move |(level, lags)| {
            lags.iter().enumerate().map(move |(index, functional)| (lag(level, index), functional))
        })
    }

    /// Scatter of a functional over stretches of at least `length` samples, taken as independent.
    ///
    /// With deviations d that sum to zero and n samples each, the variance is Σ d²/(1 − Σn²/(Σn)²).
    pub(super) fn scatter(&self, functional: &Functional, length: u64) -> Scatter {
        let pairs = self.pairs;
        let groups = self.stretches.of_length(length);
        let mut start = 0;
        let mut squares = 0.0;
        for &(end, _) in &groups {
            for pair in 0..pairs {
                let contributions = functional.deviations[start * pairs..end * pairs].iter().skip(pair).step_by(pairs);
                squares += contributions.sum::<f64>().powi(2);
            }
            start = end;
        }
        let number = pairs as f64 * self.stretches.number(&groups);
        Scatter { standard_error: (squares * number / (number - 1.0)).sqrt(), number }
    }

    /// Number of independent stretches of at least `length` samples, equivalent pairs counted.
    pub(super) fn stretches(&self, length: u64) -> f64 {
        self.pairs as f64 * self.stretches.number(&self.stretches.of_length(length))
    }
}

/// The correlation at one lag over all segments and pairs, of sums rewritten by `offsets`, plus `correction`.
fn pooled(
    correlator: &MultipleTau,
    pairs: Range<usize>,
    segments: &[&Segment<LagSums>],
    level: usize,
    lag: usize,
    offsets: &[f64],
    correction: f64,
) -> Functional {
    let sums = || segments.iter().map(|segment| segment.sums.levels.get(level));
    let shared = if correlator.pooled { correlator.pairs.len() as f64 } else { 1.0 };
    let counts: Vec<f64> = sums().map(|sums| sums.map_or(0.0, |sums| sums.counts[lag] as f64 * shared)).collect();
    let mut deviations = Vec::with_capacity(segments.len() * pairs.len());
    for sums in sums() {
        deviations.extend(pairs.clone().map(|pair| {
            let [later, earlier] = correlator.pairs[pair];
            sums.map_or(0.0, |sums| sums.shifted_product(pair, lag, offsets[later], offsets[earlier]))
        }));
    }
    let number = (counts.iter().sum::<f64>() * pairs.len() as f64).max(1.0);
    let value = deviations.iter().sum::<f64>() / number;
    for (deviations, count) in deviations.chunks_exact_mut(pairs.len()).zip(&counts) {
        deviations.iter_mut().for_each(|product| *product = (*product - value * count) / number);
    }
    Functional { value: value + correction, deviations }
}

/// Mean of each channel, relative to the correlator's origin.
fn means(correlator: &MultipleTau, segments: &[&Segment<LagSums>], samples: u64) -> Vec<f64> {
    let mut means = vec![0.0; correlator.mean_removed.len()];
    for segment in segments {
        means.iter_mut().zip(&segment.sums.sum).for_each(|(mean, sum)| *mean += sum / samples as f64);
    }
    means
}

/// Covariance of the means of a pair's channels, averaged over pairs: by as much is a correlation of deviations from them too small.
///
/// From the scatter of the means of stretches; zero for pairs that keep both means.
fn mean_covariance(
    correlator: &MultipleTau,
    pairs: Range<usize>,
    segments: &[&Segment<LagSums>],
    means: &[f64],
    stretches: &Stretches,
) -> f64 {
    let groups = stretches.of_length(stretches.samples / MEANS);
    let number = stretches.number(&groups);
    if number <= 1.0 {
        return 0.0;
    }
    let deviation = |segments: &[&Segment<LagSums>], channel: usize| -> f64 {
        segments.iter().map(|segment| segment.sums.sum[channel] - segment.samples as f64 * means[channel]).sum()
    };
    let mut total = 0.0;
    for &[later, earlier] in &correlator.pairs[pairs.clone()] {
        if correlator.mean_removed[later] || correlator.mean_removed[earlier] {
            let mut start = 0;
            for &(end, _) in &groups {
                total += deviation(&segments[start..end], later) * deviation(&segments[start..end], earlier);
                start = end;
            }
        }
    }
    let scale = (stretches.samples as f64).powi(2) * pairs.len() as f64;
    total / scale * number / (number - 1.0)
}
