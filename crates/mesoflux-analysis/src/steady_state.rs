//! Where a relaxing series has become steady, and whether it has.

use crate::error::{AnalysisError, require_finite};
use crate::estimate::Estimate;

/// The fewest block means of which it can be said that they are steady.
const FEWEST: usize = 16;
/// Standard errors of the drift beyond which a series is not steady.
const ERRORS: f64 = 3.5;
/// Standard errors by which the mean of what is left out must be off.
const HEAD_ERRORS: f64 = 3.0;
/// The strongest correlation between neighbors that is reckoned with.
const MOST_CORRELATED: f64 = 0.9;

/// A series of block means split into what was before the steady state and the steady state.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyState {
    /// The first block that counts.
    pub start: usize,
    /// By how much the blocks that count still rise from the first to the last one: the least-squares line, its error from the
    /// scatter about the line with the correlation between neighbors.
    pub drift: Estimate,
}

impl SteadyState {
    /// Whether the drift can't be told from zero.
    pub fn is_reached(&self) -> bool {
        let drift = self.drift.value.zip(self.drift.standard_error);
        drift.is_some_and(|(rise, error)| rise.abs() <= ERRORS * error)
    }
}

/// Finds where block means `x_0 … x_{n−1}` of a relaxing quantity become steady.
///
/// **Start.** The d ≤ n/2 with the least squared standard error of the mean of what is left, taken as independent,
/// `Σ_{i ≥ d} (x_i − x̄_d)²/(n − d)²`: as long as a block at the beginning is off by more than it is worth, leaving it out pays (the
/// marginal standard error rule, K. P. White, Simulation 69, 323 (1997)). Correlated series lead this rule astray: nothing is left out
/// where the mean of what would be is within three standard errors of that of the rest.
///
/// **Whether it is reached.** A line is fitted to what is left. Its rise must be within 3.5 standard errors; as long as it isn't, one more
/// block is left out, up to half of all. Of series that are steady from the beginning, fewer than 1 % are said to drift and
/// 3 % are cut; with a correlation of 0.9 between neighbors, 5 % and 30 %.
///
/// Scatter and correlation, for both, are those about the line in what is left, as of a first-order autoregressive series.
///
/// # Errors
/// Fewer than 16 blocks, or one that isn't finite.
pub fn steady_state(means: &[f64]) -> Result<SteadyState, AnalysisError> {
    require_finite("means", means)?;
    if means.len() < FEWEST {
        let (value, requirement) = (means.len() as f64, "at least 16");
        return Err(AnalysisError::OutOfRange { name: "number of block means", value, requirement });
    }
    let mut state = SteadyState { start: worth_cutting(means), drift: Estimate::default() };
    state.drift = rise(&means[state.start..]);
    while !state.is_reached() && state.start < means.len() / 2 {
        state.start += 1;
        state.drift = rise(&means[state.start..]);
    }
    Ok(state)
}

/// Where to begin by the marginal standard error rule, if what lies before is off by more than its error.
fn worth_cutting(means: &[f64]) -> usize {
    let start = least_error(means);
    let (head, tail) = means.split_at(start);
    let rest = Line::through(tail);
    // However short, a stretch knows its mean as well as one block does.
    let share = |part: &[f64]| (rest.inefficiency / part.len().max(1) as f64).min(1.0);
    let error = (rest.variance * (share(head) + share(tail))).sqrt();
    if start == 0 || (mean(head) - mean(tail)).abs() < HEAD_ERRORS * error { 0 } else { start }
}

fn rise(means: &[f64]) -> Estimate {
    Line::through(means).rise()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Where to begin for the least marginal standard error, at most in the middle.
fn least_error(means: &[f64]) -> usize {
    let mut best = (f64::INFINITY, 0);
    let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
    // From the end on, so that every block is taken up once (Welford).
    for (start, &value) in means.iter().enumerate().rev() {
        count += 1.0;
        let difference = value - mean;
        mean += difference / count;
        squares += difference * (value - mean);
        let error = squares / (count * count);
        if start <= means.len() / 2 && error <= best.0 {
            best = (error, start);
        }
    }
    best.1
}

/// The least-squares line through a series.
struct Line {
    slope: f64,
    /// Variance of the slope.
    slope_variance: f64,
    /// Blocks.
    count: f64,
    /// Variance about the line.
    variance: f64,
    /// (1 + φ)/(1 − φ): blocks to one that is independent.
    inefficiency: f64,
}

impl Line {
    fn through(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let (middle, mean) = (0.5 * (count - 1.0), mean(values));
        let place = |k: usize| k as f64 - middle;
        let spread: f64 = (0..values.len()).map(|k| place(k).powi(2)).sum();
        let slope = values.iter().enumerate().map(|(k, value)| place(k) * value).sum::<f64>() / spread;
        let residuals: Vec<f64> = values.iter().enumerate().map(|(k, value)| value - mean - slope * place(k)).collect();
        let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
        let lagged: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
        // What the line has taken away biases the correlation by about −4/n.
        let correlation =
            if squares > 0.0 { (lagged / squares + 4.0 / count).clamp(0.0, MOST_CORRELATED) } else { 0.0 };
        let inefficiency = (1.0 + correlation) / (1.0 - correlation);
        let variance = squares / (count - 2.0);
        Self { slope, slope_variance: variance / spread * inefficiency, count, variance, inefficiency }
    }

    /// From the first block to the last one.
    fn rise(&self) -> Estimate {
        let length = self.count - 1.0;
        Estimate::new(self.slope * length, self.slope_variance.sqrt() * length, length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steady series with a correlation of neighbors and variance one, from a generator of their own.
    fn series(seed: u64, count: usize, correlation: f64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        };
        let mut value = 0.0;
        let mut next = || {
            let normal = (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
            value = correlation * value + (1.0 - correlation * correlation).sqrt() * normal;
            value
        };
        (0..30 + count).map(|_| next()).skip(30).collect()
    }

    #[test]
    fn a_steady_series_is_left_whole_and_seldom_suspected() {
        for (correlation, most, least) in [(0.0, 0.01, 0.97), (0.5, 0.015, 0.9), (0.9, 0.05, 0.7)] {
            for count in [32, 63] {
                let found: Vec<SteadyState> =
                    (0..2000).map(|seed| steady_state(&series(seed, count, correlation)).unwrap()).collect();
                let suspected = found.iter().filter(|state| !state.is_reached()).count() as f64 / 2000.0;
                let whole = found.iter().filter(|state| state.start == 0).count() as f64 / 2000.0;
                assert!(suspected < most, "correlation {correlation}, {count} blocks: {suspected} suspected");
                assert!(whole > least, "correlation {correlation}, {count} blocks: {whole} whole");
            }
        }
    }

    #[test]
    fn a_relaxation_is_cut_off() {
        // Ten times e^(−t/4): 1.3 times the noise after 8 blocks, a tenth after 18.
        for seed in 0..50 {
            let noise = series(seed, 60, 0.2);
            let relaxing = noise.iter().enumerate().map(|(t, x)| 5.0 + x - 10.0 * (-0.25 * t as f64).exp());
            let found = steady_state(&relaxing.collect::<Vec<_>>()).unwrap();
            assert!((4..=30).contains(&found.start) && found.is_reached(), "{found:?}");
        }
    }

    #[test]
    fn what_still_relaxes_is_not_steady() {
        for seed in 0..50 {
            let noise = series(seed, 60, 0.2);
            let relaxing = noise.iter().enumerate().map(|(t, x)| 0.1 * x - 10.0 * (-(t as f64) / 40.0).exp());
            let found = steady_state(&relaxing.collect::<Vec<_>>()).unwrap();
            assert!(!found.is_reached() && found.start == 30 && found.drift.value.unwrap() > 1.0, "{found:?}");
        }
        // A line without any noise.
        let line: Vec<f64> = (0..20).map(f64::from).collect();
        let found = steady_state(&line).unwrap();
        assert!((found.drift.value.unwrap() - 9.0).abs() < 1e-12 && !found.is_reached(), "{found:?}");
    }

    #[test]
    fn too_few_blocks_are_refused() {
        assert!(steady_state(&[1.0; 15]).is_err());
        assert!(steady_state(&[f64::NAN; 20]).is_err());
        assert_eq!(steady_state(&[1.0; 16]).unwrap().start, 0);
    }
}
