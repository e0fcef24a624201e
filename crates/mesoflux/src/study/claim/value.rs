//! The value of a series at a point, such as one estimate.

use super::{Data, Finding, series};
use crate::study::definition::Range;

/// y at x = `at`, or of the only point.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// The series.
    pub of: String,
    /// Which of its points; needed where there are several.
    pub at: Option<f64>,
}

impl Value {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let window = self.at.map(|at| Range { low: at, high: at });
        match series(data, &self.of)?.within(window)?[..] {
            [point] => Ok(Finding { value: point.y, standard_error: point.y_error, ..Finding::default() }),
            ref points => Err(format!("{} points of {} where one is wanted", points.len(), self.of)),
        }
    }
}
