//! A series that only rises or only falls.

use super::exponent::line;
use super::{Data, Finding, series};
use crate::study::definition::Range;
use crate::study::verdict::LIMIT;

/// The trend: the slope of the line through ln y against ln x. Expected `above = 0` for a rise, `below = 0` for a fall.
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
        let points = series(data, &self.of)?.within(self.window)?;
        let fit = line(&points)?;
        let slope = fit.parameters[1];
        let against = |k: usize| {
            let (from, to) = (&points[k], &points[k + 1]);
            let step = (to.y - from.y) * slope.signum();
            (k, -step / from.y_error.hypot(to.y_error))
        };
        let worst = (0..points.len() - 1).map(against).max_by(|a, b| a.1.total_cmp(&b.1));
        let violation = worst.filter(|&(_, score)| score > LIMIT);
        let note = violation.map(|(k, score)| {
            let (from, to) = (points[k].x, points[k + 1].x);
            format!("the step from {from} to {to} goes against the trend by {score:.1} standard errors")
        });
        Ok(Finding {
            value: slope,
            standard_error: fit.standard_error(1),
            violation: violation.map(|(_, score)| score),
            notes: note.into_iter().collect(),
            ..Finding::default()
        })
    }
}
