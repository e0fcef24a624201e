//! A series that only rises or only falls.

use super::exponent::{errors, line};
use super::{Data, Finding, series};
use crate::study::definition::Range;
use crate::study::series::logarithms;
use crate::study::verdict::LIMIT;

/// The trend: the slope of the weighted line through ln y against ln x. Expected `above = 0` for a rise, `below = 0` for a fall.
///
/// The slope is that of the fitted line whatever the curve's shape, so its error doesn't grow where a power law doesn't hold. The
/// claim fails, too, where a single step goes against the trend by more than 2.5 of its standard errors; steps that noise can
/// explain refute nothing.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Monotonic {
    /// The series.
    pub of: String,
    /// Which x.
    pub window: Option<Range>,
}

impl Monotonic {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let points = logarithms(&series(data, &self.of)?.within(self.window)?)?;
        let fit = line(&points)?;
        let slope = fit.parameters[1];
        let errors = errors(&points, |_| slope);
        let against = |k: usize| (points[k].y - points[k + 1].y) * slope.signum() / errors[k].hypot(errors[k + 1]);
        let worst = (0..points.len() - 1).map(|k| (k, against(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        let violation = worst.filter(|&(_, score)| score > LIMIT);
        let note = violation.map(|(k, score)| {
            let (from, to) = (points[k].x.exp(), points[k + 1].x.exp());
            format!("the step from {from:.4} to {to:.4} goes against the trend by {score:.1} standard errors")
        });
        Ok(Finding {
            value: slope,
            standard_error: fit.standard_error(1),
            violation: violation.map(|(_, score)| score),
            notes: note.into_iter().collect(),
        })
    }
}
