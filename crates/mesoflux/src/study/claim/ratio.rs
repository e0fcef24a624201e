//! One series over another.

use super::{Data, Finding, inflated, series};
use crate::study::comparison::Comparison;
use crate::study::definition::Range;

/// The ratio of two series over all x where both are known.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ratio {
    /// The series above.
    pub numerator: String,
    /// The series below.
    pub denominator: String,
    /// Which x.
    pub window: Option<Range>,
}

impl Ratio {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let (comparison, mut finding) = compare(data, &self.numerator, &self.denominator, self.window)?;
        let ratios = comparison.points.iter().map(|point| point.y);
        if comparison.points.len() > 1 {
            let lowest = ratios.clone().fold(f64::INFINITY, f64::min);
            let highest = ratios.fold(f64::NEG_INFINITY, f64::max);
            let note = format!("{} points, from {lowest:.3} to {highest:.3}", comparison.points.len());
            finding.notes.insert(0, note);
        }
        Ok(finding)
    }
}

/// The comparison of two series, a/b with its error.
pub(super) fn compare(data: &Data, a: &str, b: &str, window: Option<Range>) -> Result<(Comparison, Finding), String> {
    // The window is for the numerator; the denominator may be interpolated from beyond it.
    let below = series(data, b)?.within(None)?;
    let comparison = Comparison::new(&series(data, a)?.within(window)?, &below)?;
    let notes = comparison.excess.map(inflated).into_iter().collect();
    let finding =
        Finding { value: comparison.ratio, standard_error: comparison.standard_error, notes, ..Finding::default() };
    Ok((comparison, finding))
}
