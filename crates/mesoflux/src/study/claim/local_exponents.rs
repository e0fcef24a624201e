//! The slope between neighboring points, which tends to a limit.

use super::{Data, Finding, series};
use crate::report::value_with_error;
use crate::study::definition::Range;
use crate::study::series::logarithms;

/// Δ ln y/Δ ln x from each point to the next; the last one is compared with the limit, the note has them all.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalExponents {
    /// The series.
    pub of: String,
    /// Which x.
    pub window: Option<Range>,
}

impl LocalExponents {
    pub(super) fn measure(&self, data: &Data) -> Result<Finding, String> {
        let points = logarithms(&series(data, &self.of)?.within(self.window)?)?;
        let slope = |pair: &[crate::study::series::LogPoint]| {
            let (a, b) = (&pair[0], &pair[1]);
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let slope = dy / dx;
            let y_error = a.y_error.hypot(b.y_error);
            let x_error = slope * a.x_error.hypot(b.x_error);
            (slope, y_error.hypot(x_error) / dx)
        };
        let slopes: Vec<(f64, f64)> = points.windows(2).map(slope).collect();
        let &(value, standard_error) = slopes.last().ok_or("one point has no slope")?;
        let all: Vec<String> = slopes.iter().map(|&(slope, error)| value_with_error(slope, error)).collect();
        Ok(Finding { value, standard_error, violation: None, notes: vec![format!("from point to point {}", all.join(", "))] })
    }
}
