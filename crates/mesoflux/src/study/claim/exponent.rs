//! The exponent of a power law.

use super::{Data, Finding, inflated, series};
use crate::study::definition::Range;
use crate::study::fit::Fit;
use crate::study::series::{LogPoint, logarithms};

/// p of y = c x^p: a weighted straight line through ln y against ln x.
///
/// The weights are 1/s² with s² = (s_y/y)² + (p s_x/x)². Where the points lie off the line by more than their errors allow
/// (chance below 1 %), the error is larger by √(χ²/ν): the law doesn't hold there, and the number depends on the window.
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
        let points = logarithms(&series(data, &self.of)?.within(self.window)?)?;
        let fit = line(&points)?;
        let excess = fit.excess();
        Ok(Finding {
            value: fit.parameters[1],
            standard_error: fit.standard_error(1) * excess.unwrap_or(1.0),
            violation: None,
            notes: excess.map(inflated).into_iter().collect(),
        })
    }
}

/// ln y = a + p (ln x − mean of ln x): the parameters a and p.
///
/// # Errors
/// Points that don't determine a line.
pub(super) fn line(points: &[LogPoint]) -> Result<Fit, String> {
    let middle = points.iter().map(|point| point.x).sum::<f64>() / points.len() as f64;
    let rows: Vec<Vec<f64>> = points.iter().map(|point| vec![1.0, point.x - middle]).collect();
    let values: Vec<f64> = points.iter().map(|point| point.y).collect();
    let few = || format!("{} points don't determine an exponent", points.len());
    // The errors of x count with a slope that the fit must find: at first without weights.
    let mut fit = Fit::new(&rows, &values, &vec![1.0; points.len()]).ok_or_else(few)?;
    for _ in 0..3 {
        fit = Fit::new(&rows, &values, &errors(points, |_| fit.parameters[1])).ok_or_else(few)?;
    }
    Ok(fit)
}

/// The errors of ln y, those of x included, for a curve of so much slope at each point.
pub(super) fn errors(points: &[LogPoint], slope: impl Fn(&LogPoint) -> f64) -> Vec<f64> {
    points.iter().map(|point| point.y_error.hypot(slope(point) * point.x_error)).collect()
}
