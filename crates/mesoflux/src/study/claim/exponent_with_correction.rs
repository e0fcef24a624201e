//! The exponent of a power law whose corrections haven't died out.

use super::exponent::{line, middle};
use super::{Data, Finding, inflated, series};
use crate::report::value_with_error;
use crate::study::definition::Range;
use crate::study::fit::{Curve, fit_exponential};

/// p of y = c x^p (1 + b x^q), with q given and p, b, c fitted: what a plain exponent tends to where the correction dies out.
///
/// The error of p is the marginal one, b being unknown too. The note has the plain exponent of the same window.
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

impl ExponentWithCorrection {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let points = series(data, &self.of)?.within(self.window)?;
        let raw = line(&points)?;
        let raw_error = raw.standard_error(1) * raw.excess().unwrap_or(1.0);
        let plain = format!("without the correction {}", value_with_error(raw.parameters[1], raw_error));
        let (middle, q) = (middle(&points), self.correction);
        let start = [raw.parameters[0], raw.parameters[1], 0.0];
        let fit = fit_exponential(&points, &start, |a, x| {
            let power = (q * (x - middle)).exp();
            let factor = 1.0 + a[2] * power;
            let share = power / factor;
            (factor > 0.0).then(|| Curve {
                value: a[0] + a[1] * (x - middle) + factor.ln(),
                row: vec![1.0, x - middle, share],
                slope: a[1] + q * a[2] * share,
            })
        });
        let fit = fit.map_err(|reason| format!("{reason}; {plain}"))?;
        let excess = fit.excess();
        let mut notes = vec![plain];
        notes.extend(excess.map(inflated));
        Ok(Finding {
            value: fit.parameters[1],
            standard_error: fit.standard_error(1) * excess.unwrap_or(1.0),
            notes,
            ..Finding::default()
        })
    }
}
