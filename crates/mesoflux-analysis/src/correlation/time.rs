//! Integrated autocorrelation times and asymptotic variances, by correlation and by blocking.

use super::MultipleTau;
use super::cutoff::choose;
use super::integral::{Quadrature, taper};
use crate::blocking::Blocking;
use crate::error::AnalysisError;
use crate::estimate::Estimate;
use serde::{Deserialize, Serialize};

/// How long an observable remembers, and what that does to the error of its mean. Each with its own standard error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AutocorrelationTime {
    /// Integrated autocorrelation time `τ = ∫₀^∞ C(t)/C(0) dt = spacing (½ + Σ_{k ≥ 1} C_k/C_0)`.
    pub time: Estimate,
    /// Statistical inefficiency 2τ/spacing: samples for one independent sample.
    pub statistical_inefficiency: Estimate,
    /// Asymptotic variance `σ² = 2 ∫₀^∞ C(t) dt`: the variance of a mean over a long time t is σ²/t.
    pub asymptotic_variance: Estimate,
}

impl MultipleTau {
    /// Integrated autocorrelation time and asymptotic variance from the integral of the autocorrelation.
    ///
    /// Cutoff, error and refusal are those of [`integral`](Self::integral); the error of τ is that of the ratio, by the delta method.
    /// For observables with a mean other than zero, [`remove_mean`](Self::remove_mean).
    pub fn autocorrelation_time(&self) -> AutocorrelationTime {
        if self.pairs.iter().any(|[later, earlier]| later != earlier) {
            return AutocorrelationTime::unknown("an autocorrelation time needs pairs of equal channels");
        }
        let evaluation = self.evaluation();
        let window = |end: u64| evaluation.window(end, |lag| taper(lag, end) * Quadrature::Summed.weight(lag));
        let choice = match choose(&evaluation, (1, u64::MAX), window) {
            Ok(choice) => choice,
            Err(reason) => return AutocorrelationTime::unknown(&reason),
        };
        let variance = evaluation.window(1, |_| 1.0);
        if variance.value <= 0.0 {
            return AutocorrelationTime::unknown("the series is constant");
        }
        let time = choice.functional.value / variance.value;
        let asymptotic = Estimate::new(choice.functional.value, choice.standard_error(&evaluation), choice.number);
        let mut ratio = choice;
        ratio.functional.add(&variance, -time);
        let error = ratio.standard_error(&evaluation) / variance.value;
        let time = Estimate::new(time, error, ratio.number);
        AutocorrelationTime {
            time: time.scaled(self.spacing),
            statistical_inefficiency: time.scaled(2.0),
            asymptotic_variance: asymptotic.scaled(2.0 * self.spacing),
        }
    }
}

impl Blocking {
    /// Integrated autocorrelation time and asymptotic variance of w·x from the variance of blocks, for samples `spacing` apart in time.
    ///
    /// `σ² = spacing · n · variance of the mean` at the level that the blocking chose, with the relative standard error √(2/(blocks − 1)) of
    /// a χ² distribution; τ is σ² over twice the variance of the series.
    ///
    /// # Errors
    /// If the weights' number is wrong, one isn't finite, or the spacing isn't positive and finite.
    pub fn autocorrelation_time(&self, weights: &[f64], spacing: f64) -> Result<AutocorrelationTime, AnalysisError> {
        if !(spacing > 0.0 && spacing.is_finite()) {
            let requirement = "positive and finite";
            return Err(AnalysisError::OutOfRange { name: "spacing", value: spacing, requirement });
        }
        let levels = self.variance_of_mean_by_level(weights)?;
        let time = self.correlation_time(weights);
        // What the variance of the mean would be without correlation, times the number of samples.
        let variance = levels.first().map_or(f64::NAN, |level| level.variance_of_mean * self.count() as f64);
        Ok(AutocorrelationTime {
            statistical_inefficiency: time.scaled(2.0),
            asymptotic_variance: time.scaled(2.0 * spacing * variance),
            time: time.scaled(spacing),
        })
    }
}

impl AutocorrelationTime {
    fn unknown(reason: &str) -> Self {
        let unknown = || Estimate::unknown(reason);
        Self { time: unknown(), statistical_inefficiency: unknown(), asymptotic_variance: unknown() }
    }
}
