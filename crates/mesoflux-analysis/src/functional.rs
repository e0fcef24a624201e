//! Estimates from a blocking: linear functionals, ratios and smooth functions of the mean, with their errors.

use crate::blocking::Blocking;
use crate::error::{AnalysisError, require_finite, require_length};
use crate::estimate::Estimate;
use crate::level::ScalarMoments;
use crate::plateau::{self, Plateau};
use serde::{Deserialize, Serialize};

/// A ratio is refused if its denominator lies within this many standard errors of zero.
const REFUSED_DENOMINATOR: f64 = 3.0;
/// A ratio carries a warning if its denominator lies within this many standard errors of zero.
const DOUBTFUL_DENOMINATOR: f64 = 10.0;

/// One point of a blocking plot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockingLevel {
    /// Length of a block in samples.
    pub block_length: u64,
    /// Number of blocks, over all replicas.
    pub blocks: u64,
    /// Variance of the mean if blocks of this length are independent.
    pub variance_of_mean: f64,
    /// Its standard error, `variance_of_mean` √(2/(blocks − 1)).
    pub standard_error: f64,
}

impl Blocking {
    /// The mean of w·x and its standard error by the rule stated at [`Blocking`].
    pub fn linear(&self, weights: &[f64]) -> Estimate {
        let Some(mean) = self.mean() else {
            return Estimate::unknown("too short: nothing was recorded");
        };
        if let Err(error) = self.check_weights(weights) {
            return Estimate::unknown(error.to_string());
        }
        self.with_error_of(weights, mean.iter().zip(weights).map(|(mean, weight)| mean * weight).sum())
    }

    /// The mean of the first component.
    pub fn estimate(&self) -> Estimate {
        self.component(0)
    }

    /// The mean of one component.
    pub fn component(&self, index: usize) -> Estimate {
        self.unit(index).map_or_else(|warning| warning, |weights| self.linear(&weights))
    }

    /// The ratio `R = ⟨x_a⟩/⟨x_b⟩` of the means of two components, a the `numerator` and b the `denominator`.
    ///
    /// Delta method: the error is that of the mean of `(x_a − R x_b)/⟨x_b⟩`, correlations of the two included. The bias, of the
    /// order of `R (s_b/⟨x_b⟩)²`, isn't removed. A denominator within 3 standard errors of zero gives `None`; one
    /// within 10 gives a warning, as the ratio's distribution is then visibly skewed.
    pub fn ratio(&self, numerator: usize, denominator: usize) -> Estimate {
        let (above, below) = (self.component(numerator), self.component(denominator));
        let (Some(above_mean), Some(below_mean), Some(below_error)) = (above.value, below.value, below.standard_error)
        else {
            let mut warnings = above.warnings;
            warnings.extend(below.warnings);
            return Estimate { warnings, ..Estimate::default() };
        };
        let distance = below_mean.abs() / below_error;
        if below_mean == 0.0 || distance < REFUSED_DENOMINATOR {
            return Estimate::unknown(format!(
                "the denominator, {below_mean:e} ± {below_error:e}, is too close to zero"
            ));
        }
        let ratio = above_mean / below_mean;
        let mut weights = vec![0.0; self.components()];
        weights[numerator] += 1.0 / below_mean;
        weights[denominator] -= ratio / below_mean;
        let estimate = self.with_error_of(&weights, ratio);
        if distance < DOUBTFUL_DENOMINATOR {
            return estimate.with_warning(format!(
                "the denominator, {below_mean:e} ± {below_error:e}, is close to zero: the error is symmetric only roughly"
            ));
        }
        estimate
    }

    /// A smooth function f(⟨x⟩) of the mean vector, with its gradient.
    ///
    /// Delta method: the error is that of the mean of ∇f·x, the gradient being taken at the mean. Holds where f
    /// is close to linear over the error of the mean.
    pub fn function(&self, value: impl FnOnce(&[f64]) -> f64, gradient: impl FnOnce(&[f64]) -> Vec<f64>) -> Estimate {
        let Some(mean) = self.mean() else {
            return Estimate::unknown("too short: nothing was recorded");
        };
        let weights = gradient(&mean);
        match self.check_weights(&weights) {
            Ok(()) => self.with_error_of(&weights, value(&mean)),
            Err(error) => Estimate::unknown(format!("gradient: {error}")),
        }
    }

    /// The variance of the mean of w·x against the length of a block: for correlated series it rises to a plateau.
    ///
    /// # Errors
    /// If the weights' number is wrong or one isn't finite.
    pub fn variance_of_mean_by_level(&self, weights: &[f64]) -> Result<Vec<BlockingLevel>, AnalysisError> {
        self.check_weights(weights)?;
        let moments = self.project(weights);
        let levels = moments.iter().enumerate().filter(|(_, moments)| moments.blocks > 1).map(|(index, moments)| {
            let variance_of_mean = moments.variance_of_mean(index, self.count());
            BlockingLevel {
                block_length: 1 << index,
                blocks: moments.blocks,
                variance_of_mean,
                standard_error: variance_of_mean * (2.0 / (moments.blocks as f64 - 1.0)).sqrt(),
            }
        });
        Ok(levels.filter(|level| level.variance_of_mean.is_finite()).collect())
    }

    /// Integrated autocorrelation time `½ + Σ_{t ≥ 1} ρ(t)` of w·x, in units of the sampling interval.
    ///
    /// Half the ratio of the variance of the mean on the plateau to that of independent samples: ½ for white noise,
    /// ½(1 + φ)/(1 − φ) for a first-order autoregressive series, about τ for ρ = exp(−t/τ), τ ≫ 1. The relative
    /// standard error is √(2/(n − 1)), n being the number of blocks on the plateau.
    pub fn correlation_time(&self, weights: &[f64]) -> Estimate {
        if let Err(error) = self.check_weights(weights) {
            return Estimate::unknown(error.to_string());
        }
        let moments = self.project(weights);
        let (level, warning) = match self.plateau(&moments) {
            Ok(found) => found,
            Err(unknown) => return unknown,
        };
        let naive = moments[0].variance_of_mean(0, self.count());
        if naive <= 0.0 {
            return Estimate::unknown("the series is constant");
        }
        let blocks = moments[level].blocks as f64;
        let time = 0.5 * moments[level].variance_of_mean(level, self.count()) / naive;
        let mut estimate = Estimate::new(time, time * (2.0 / (blocks - 1.0)).sqrt(), blocks);
        estimate.warnings.extend(warning);
        estimate
    }

    /// `value` with the standard error of the mean of w·x.
    fn with_error_of(&self, weights: &[f64], value: f64) -> Estimate {
        let moments = self.project(weights);
        match self.plateau(&moments) {
            Ok((level, warning)) => {
                let error = moments[level].variance_of_mean(level, self.count()).sqrt();
                let mut estimate = Estimate::new(value, error, moments[level].blocks as f64);
                estimate.warnings.extend(warning);
                estimate
            }
            Err(unknown) => Estimate { value: value.is_finite().then_some(value), ..unknown },
        }
    }

    /// The level to use and the warning that goes with it, or the statement that there is no error to be had.
    fn plateau(&self, moments: &[ScalarMoments]) -> Result<(usize, Option<String>), Estimate> {
        match plateau::find(moments, self.count(), self.minimum_block_length) {
            Plateau::Found(level) => Ok((level, None)),
            Plateau::TooShort(level) => Ok((
                level,
                Some(format!(
                    "too short: {} samples are correlated over all block lengths that can be tested; \
                     the error is probably too small",
                    self.count()
                )),
            )),
            Plateau::NoData => Err(Estimate::unknown(format!("too short: {} samples have no error", self.count()))),
        }
    }

    fn project(&self, weights: &[f64]) -> Vec<ScalarMoments> {
        self.levels.iter().map(|level| level.project(weights)).collect()
    }

    fn check_weights(&self, weights: &[f64]) -> Result<(), AnalysisError> {
        require_length("weights", weights.len(), self.components())?;
        require_finite("weights", weights)
    }

    fn unit(&self, index: usize) -> Result<Vec<f64>, Estimate> {
        let mut weights = vec![0.0; self.components()];
        match weights.get_mut(index) {
            Some(weight) => {
                *weight = 1.0;
                Ok(weights)
            }
            None => Err(Estimate::unknown(format!("component {index}: there are only {}", self.components()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_told_is_none_with_a_reason() {
        let mut blocking = Blocking::new(2).unwrap();
        assert_eq!(blocking.estimate().value, None);
        blocking.record(&[1.0, 0.0]).unwrap();
        assert_eq!((blocking.estimate().value, blocking.estimate().standard_error), (Some(1.0), None));
        blocking.record(&[2.0, 0.0]).unwrap();
        assert!(blocking.estimate().warnings[0].starts_with("too short"));
        for estimate in [
            blocking.linear(&[1.0]),
            blocking.linear(&[1.0, f64::INFINITY]),
            blocking.component(2),
            blocking.ratio(0, 1),
            blocking.ratio(5, 0),
            blocking.function(|mean| mean[0], |_| vec![1.0]),
            blocking.correlation_time(&[0.0, 1.0]),
        ] {
            assert_eq!((estimate.value, estimate.standard_error), (None, None));
            assert!(!estimate.warnings.is_empty());
        }
    }

    #[test]
    fn squares_that_overflow_give_no_number() {
        let mut blocking = Blocking::new(1).unwrap();
        for value in [1e300, -1e300].iter().cycle().take(100) {
            blocking.record(&[*value]).unwrap();
        }
        let estimate = blocking.estimate();
        assert_eq!(estimate.standard_error, None);
        assert!(!estimate.warnings.is_empty());
    }

    #[test]
    fn a_constant_series_has_no_error() {
        let mut blocking = Blocking::new(1).unwrap();
        (0..100).for_each(|_| blocking.record(&[0.1]).unwrap());
        assert_eq!((blocking.estimate().value, blocking.estimate().standard_error), (Some(0.1), Some(0.0)));
    }
}
