//! A series: named points (x, y) with their errors, and what is missing from it.

use super::definition::Range;

/// One point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Point {
    /// Where.
    pub x: f64,
    /// Its standard error; zero where x is exact.
    pub x_error: f64,
    /// What.
    pub y: f64,
    /// Its standard error; zero where y is exact.
    pub y_error: f64,
}

/// A point that isn't there.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// Where, if that is known.
    pub x: Option<f64>,
    /// Why.
    pub reason: String,
}

/// Points by growing x.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// The points.
    pub points: Vec<Point>,
    /// Those that the runs couldn't tell.
    pub missing: Vec<Missing>,
    /// What the runs warn of where they could tell.
    pub warnings: Vec<String>,
}

impl Series {
    /// A series of some points.
    pub fn new(mut points: Vec<Point>, missing: Vec<Missing>) -> Self {
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        Self { points, missing, warnings: Vec::new() }
    }

    /// The points in a window of x, or all of them.
    ///
    /// # Errors
    /// A point that is missing there: what the others say may not be what all would.
    pub fn within(&self, window: Option<Range>) -> Result<Vec<Point>, String> {
        let inside = |x: f64| window.is_none_or(|window| window.contains(x));
        let missing = self.missing.iter().find(|missing| missing.x.is_none_or(inside));
        match missing {
            Some(Missing { x: Some(x), reason }) => Err(format!("no point at {x}: {reason}")),
            Some(Missing { x: None, reason }) => Err(reason.clone()),
            None => Ok(self.points.iter().filter(|point| inside(point.x)).copied().collect()),
        }
    }

    /// The series as CSV.
    pub fn csv(&self) -> String {
        let row = |p: &Point| format!("{:.12e},{:.12e},{:.12e},{:.12e}\n", p.x, p.x_error, p.y, p.y_error);
        "x,x_error,y,y_error\n".to_owned() + &self.points.iter().map(row).collect::<String>()
    }
}
