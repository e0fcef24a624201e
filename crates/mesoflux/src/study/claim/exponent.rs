//! The exponent of a power law.

use super::{Data, Finding, inflated, series};
use crate::study::definition::Range;
use crate::study::fit::{Curve, Fit, fit_exponential};
use crate::study::series::Point;

/// p of y = c x^p: the slope of ln y against ln x.
///
/// Where the points lie off the line by more than their errors allow (chance below 1 %), the error is larger by √(χ²/ν): the law
/// doesn't hold there, and the number depends on the window.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exponent {
    /// The series.
    pub of: String,
    /// Which x.
    pub window: Option<Range>,
}

impl Exponent {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let fit = line(&series(data, &self.of)?.within(self.window)?)?;
        let excess = fit.excess();
        Ok(Finding {
            value: fit.parameters[1],
            standard_error: fit.standard_error(1) * excess.unwrap_or(1.0),
            notes: excess.map(inflated).into_iter().collect(),
            ..Finding::default()
        })
    }
}

/// The parameters a and p of ln y = a + p (ln x − [`middle`]).
///
/// # Errors
/// Points that don't determine a line.
pub(super) fn line(points: &[Point]) -> Result<Fit, String> {
    let middle = middle(points);
    // A first idea from the points that have a logarithm, all alike.
    let positive: Vec<&Point> = points.iter().filter(|point| point.x > 0.0 && point.y > 0.0).collect();
    let rows: Vec<Vec<f64>> = positive.iter().map(|point| vec![1.0, point.x.ln() - middle]).collect();
    let logs: Vec<f64> = positive.iter().map(|point| point.y.ln()).collect();
    let start = Fit::new(&rows, &logs, &vec![1.0; logs.len()]);
    let start = start.ok_or_else(|| format!("{} positive points don't determine an exponent", positive.len()))?;
    fit_exponential(points, &start.parameters, |a, x| {
        Some(Curve { value: a[0] + a[1] * (x - middle), row: vec![1.0, x - middle], slope: a[1] })
    })
}

/// The mean of ln x.
pub(super) fn middle(points: &[Point]) -> f64 {
    points.iter().map(|point| point.x.ln()).sum::<f64>() / points.len() as f64
}
