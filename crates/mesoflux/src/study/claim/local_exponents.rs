//! The slope between neighboring points, which tends to a limit.

use super::{Data, Finding, series};
use crate::report::value_with_error;
use crate::study::definition::Range;
use crate::study::series::Point;

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
        let points = series(data, &self.of)?.within(self.window)?;
        if let Some(point) = points.iter().find(|point| !(point.x > 0.0 && point.y > 0.0)) {
            return Err(format!("the point ({}, {}) has no logarithm", point.x, point.y));
        }
        let slope = |pair: &[Point]| {
            let (a, b) = (&pair[0], &pair[1]);
            let distance = (b.x / a.x).ln();
            let slope = (b.y / a.y).ln() / distance;
            let y_error = (a.y_error / a.y).hypot(b.y_error / b.y);
            let x_error = slope * (a.x_error / a.x).hypot(b.x_error / b.x);
            (slope, y_error.hypot(x_error) / distance)
        };
        let slopes: Vec<(f64, f64)> = points.windows(2).map(slope).collect();
        let &(value, standard_error) = slopes.last().ok_or("one point has no slope")?;
        let all: Vec<String> = slopes.iter().map(|&(slope, error)| value_with_error(slope, error)).collect();
        Ok(Finding {
            value,
            standard_error,
            notes: vec![format!("from point to point {}", all.join(", "))],
            ..Finding::default()
        })
    }
}
