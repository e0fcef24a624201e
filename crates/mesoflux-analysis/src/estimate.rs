//! An estimate: a value, its standard error, how many independent samples stand behind it, and warnings.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A measured number, or the statement that it can't be told from the data.
///
/// `value` and `standard_error` are finite or `None`, never NaN; where one is `None`, `warnings` says why.
/// Both carry the unit of the quantity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimated value.
    pub value: Option<f64>,
    /// One standard deviation of the sampling distribution of `value`.
    pub standard_error: Option<f64>,
    /// Independent samples behind `standard_error`: one more than its degrees of freedom.
    ///
    /// For a series this is the number of blocks at the level that [`Blocking`](crate::Blocking) chose. Blocks are
    /// longer than the correlation time, so it is smaller than the ratio of the variance of the series to
    /// the squared standard error, and it is what tells how well the standard error itself is known:
    /// to a relative precision of about 1/√(2 (`effective_samples` − 1)).
    pub effective_samples: f64,
    /// What a reader of the number must know.
    pub warnings: Vec<String>,
}

impl Estimate {
    /// A value with its standard error; a number that isn't finite is replaced by `None` and a warning.
    pub fn new(value: f64, standard_error: f64, effective_samples: f64) -> Self {
        let effective_samples = if effective_samples.is_finite() { effective_samples.max(0.0) } else { 0.0 };
        let mut estimate =
            Self { value: Some(value), standard_error: Some(standard_error), effective_samples, warnings: Vec::new() };
        estimate.drop_what_is_not_finite();
        estimate
    }

    /// Nothing can be told, for the reason given.
    pub fn unknown(warning: impl Into<String>) -> Self {
        Self { warnings: vec![warning.into()], ..Self::default() }
    }

    /// The same estimate with one more warning.
    #[must_use]
    pub fn with_warning(mut self, warning: impl Into<String>) -> Self {
        self.warnings.push(warning.into());
        self
    }

    /// The estimate of `factor` times the quantity, `factor` being known exactly.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = Self {
            value: self.value.map(|value| value * factor),
            standard_error: self.standard_error.map(|error| error * factor.abs()),
            effective_samples: self.effective_samples,
            warnings: self.warnings.clone(),
        };
        scaled.drop_what_is_not_finite();
        scaled
    }

    /// The estimate of one over the quantity, its error s/x² (delta method).
    ///
    /// `None` with a warning if x lies within three of its standard errors of zero; a warning if within ten, as 1/x is then visibly
    /// skewed.
    #[must_use]
    pub fn inverse(self) -> Self {
        match (self.value, self.standard_error) {
            (Some(x), Some(error)) if x.abs() > 3.0 * error => {
                let mut inverse = Self::new(1.0 / x, error / (x * x), self.effective_samples);
                inverse.warnings.splice(0..0, self.warnings);
                if x.abs() < 10.0 * error {
                    inverse = inverse.with_warning("the slope is close to zero: the error is symmetric only roughly");
                }
                inverse
            }
            _ => Self { warnings: self.warnings, ..Self::default() }
                .with_warning("the slope lies within three standard errors of zero: its inverse can't be told"),
        }
    }

    /// Standard error over the magnitude of the value; `None` if either is unknown or the value is zero.
    pub fn relative_error(&self) -> Option<f64> {
        finite(self.standard_error? / self.value?.abs())
    }

    /// The confidence interval of the given level, such as 0.95.
    ///
    /// value ± t · standard error, with t the quantile of Student's distribution with `effective_samples` − 1
    /// degrees of freedom. `None` if value or error is unknown, if there are no degrees of freedom, or if the level isn't
    /// between 0 and 1.
    pub fn interval(&self, level: f64) -> Option<(f64, f64)> {
        let (value, error) = (self.value?, self.standard_error?);
        let half_width = student_quantile(self.effective_samples - 1.0, level)? * error;
        Some((finite(value - half_width)?, finite(value + half_width)?))
    }

    /// The difference of two independent estimates over their combined standard error, `(a − b)/√(s_a² + s_b²)`.
    ///
    /// Estimates from one run are correlated, and this overstates or understates their disagreement: for them, take the
    /// difference as one linear functional of a joint series ([`Blocking::linear`](crate::Blocking::linear)).
    pub fn z_score(&self, other: &Self) -> Option<f64> {
        self.z_score_against(other.value?, other.standard_error?)
    }

    /// As [`z_score`](Self::z_score), against a published number and its standard error (zero for an exact one).
    pub fn z_score_against(&self, value: f64, standard_error: f64) -> Option<f64> {
        finite((self.value? - value) / self.standard_error?.hypot(standard_error))
    }

    fn drop_what_is_not_finite(&mut self) {
        if self.value.is_some_and(|value| !value.is_finite()) {
            self.value = None;
            self.warnings.push("the value is not a finite number".into());
        }
        if self.standard_error.is_some_and(|error| !error.is_finite() || error < 0.0) {
            self.standard_error = None;
            self.warnings.push("the standard error is not a finite number".into());
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The t with P(|T| < t) = `level` for Student's distribution; `None` without degrees of freedom.
pub(crate) fn student_quantile(degrees_of_freedom: f64, level: f64) -> Option<f64> {
    if !(level > 0.0 && level < 1.0 && degrees_of_freedom > 0.0) {
        return None;
    }
    let distribution = StudentsT::new(0.0, 1.0, degrees_of_freedom).ok()?;
    finite(distribution.inverse_cdf(0.5 + 0.5 * level))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_uses_student_quantiles() {
        // Textbook table: t(0.975; 4) = 2.776, t(0.975; 30) = 2.042, t(0.95; 10) = 1.812.
        for (degrees, level, quantile) in [(4.0, 0.95, 2.776), (30.0, 0.95, 2.042), (10.0, 0.9, 1.812)] {
            let (low, high) = Estimate::new(1.0, 2.0, degrees + 1.0).interval(level).unwrap();
            assert!((high - 1.0 - 2.0 * quantile).abs() < 2e-3, "{high}");
            assert!((low + high - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_interval_needs_degrees_of_freedom_and_a_level() {
        assert_eq!(Estimate::new(1.0, 2.0, 1.0).interval(0.95), None);
        assert_eq!(Estimate::new(1.0, 2.0, 9.0).interval(1.0), None);
        assert_eq!(Estimate::new(1.0, 2.0, 9.0).interval(f64::NAN), None);
        assert_eq!(Estimate::unknown("no data").interval(0.95), None);
    }

    #[test]
    fn what_is_not_finite_becomes_none_and_a_warning() {
        let estimate = Estimate::new(f64::NAN, f64::INFINITY, f64::NAN);
        assert_eq!((estimate.value, estimate.standard_error, estimate.effective_samples), (None, None, 0.0));
        assert_eq!(estimate.warnings.len(), 2);
        assert_eq!(Estimate::new(1.0, 1.0, 2.0).scaled(f64::INFINITY).value, None);
    }

    #[test]
    fn scaling_and_scores() {
        let estimate = Estimate::new(2.0, 0.3, 10.0);
        let scaled = estimate.scaled(-2.0);
        assert_eq!((scaled.value, scaled.standard_error), (Some(-4.0), Some(0.6)));
        assert!((estimate.relative_error().unwrap() - 0.15).abs() < 1e-15);
        assert!((estimate.z_score(&Estimate::new(1.0, 0.4, 10.0)).unwrap() - 2.0).abs() < 1e-12);
        assert!((estimate.z_score_against(2.6, 0.0).unwrap() + 2.0).abs() < 1e-12);
        assert_eq!(Estimate::new(0.0, 0.0, 10.0).z_score_against(0.0, 0.0), None);
        assert_eq!(Estimate::new(0.0, 1.0, 10.0).relative_error(), None);
    }
}
