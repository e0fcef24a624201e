//! Whether two series are the same.

use super::ratio::compare;
use super::{Data, Finding};
use crate::study::definition::Range;

/// The relative difference a/b − 1, over all x where both are known; expected 0.
///
/// The mean can hide differences that cancel: the note has the largest difference of a single point in units of its error, and
/// where the points scatter more than their errors allow, the error of the mean is larger by that.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Agreement {
    /// The two series.
    pub between: [String; 2],
    /// Which x.
    pub window: Option<Range>,
}

impl Agreement {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let [a, b] = &self.between;
        let (comparison, mut finding) = compare(data, a, b, self.window)?;
        finding.value -= 1.0;
        if comparison.points.len() > 1 {
            let note = format!(
                "{} points, the largest |z| of one is {:.1}",
                comparison.points.len(),
                comparison.largest_score
            );
            finding.notes.insert(0, note);
        }
        Ok(finding)
    }
}
