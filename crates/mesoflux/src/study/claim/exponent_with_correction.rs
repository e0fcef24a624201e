//! The exponent of a power law whose corrections haven't died out.

use super::exponent::{errors, line};
use super::{Data, Finding, inflated, series};
use crate::report::value_with_error;
use crate::study::definition::Range;
use crate::study::fit::Fit;
use crate::study::series::{LogPoint, logarithms};

/// p of y = c x^p (1 + b x^q), with q given and p, b, c fitted: what a plain exponent tends to where the correction dies out.
///
/// Gauss and Newton's method on ln y; the error of p is the marginal one, b being unknown too. The note has the plain
/// exponent of the same window.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExponentWithCorrection {
    /// The series.
    pub of: String,
    /// q.
    pub correction: f64,
    /// Which x.
    pub window: Option<Range>,
}

/// Steps of Gauss and Newton at most; a handful do where b is determined at all.
const STEPS: usize = 100;

impl ExponentWithCorrection {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let points = logarithms(&series(data, &self.of)?.within(self.window)?)?;
        let raw = line(&points)?;
        let raw_error = raw.standard_error(1) * raw.excess().unwrap_or(1.0);
        let plain = format!("without the correction {}", value_with_error(raw.parameters[1], raw_error));
        let fit = self.fit(&points, raw.parameters[1]).map_err(|reason| format!("{reason}; {plain}"))?;
        let excess = fit.excess();
        let mut notes = vec![plain];
        notes.extend(excess.map(inflated));
        Ok(Finding {
            value: fit.parameters[1],
            standard_error: fit.standard_error(1) * excess.unwrap_or(1.0),
            violation: None,
            notes,
        })
    }

    /// The fit with its parameters ln c, p and b, where x is counted from the middle of the points.
    fn fit(&self, points: &[LogPoint], exponent: f64) -> Result<Fit, String> {
        let middle = points.iter().map(|point| point.x).sum::<f64>() / points.len() as f64;
        let correction = |point: &LogPoint| (self.correction * (point.x - middle)).exp();
        let mut parameters = vec![points.iter().map(|point| point.y).sum::<f64>() / points.len() as f64, exponent, 0.0];
        let curve = |a: &[f64], point: &LogPoint| {
            let factor = 1.0 + a[2] * correction(point);
            (factor > 0.0).then(|| a[0] + a[1] * (point.x - middle) + factor.ln())
        };
        for _ in 0..STEPS {
            let b = parameters[2];
            let share = |point: &LogPoint| correction(point) / (1.0 + b * correction(point));
            let slope = |point: &LogPoint| parameters[1] + self.correction * b * share(point);
            let errors = errors(points, slope);
            let residuals = points.iter().map(|point| curve(&parameters, point).map(|value| point.y - value));
            let residuals: Option<Vec<f64>> = residuals.collect();
            let rows: Vec<Vec<f64>> = points.iter().map(|point| vec![1.0, point.x - middle, share(point)]).collect();
            let fit = residuals.and_then(|residuals| Fit::new(&rows, &residuals, &errors));
            let mut fit = fit.ok_or_else(|| format!("{} points don't determine a correction", points.len()))?;
            // Only as far as the logarithm exists.
            let mut part = 1.0;
            let moved = |part: f64| -> Vec<f64> {
                parameters.iter().zip(&fit.parameters).map(|(old, step)| old + part * step).collect()
            };
            while points.iter().any(|point| curve(&moved(part), point).is_none()) {
                part *= 0.5;
            }
            let next = moved(part);
            let settled = part == 1.0
                && (0..3).all(|k| fit.parameters[k].abs() <= 1e-6 * fit.standard_error(k).max(f64::MIN_POSITIVE));
            parameters = next;
            if settled {
                fit.parameters = parameters;
                return Ok(fit);
            }
        }
        Err("the fit of the correction doesn't settle".to_owned())
    }
}
