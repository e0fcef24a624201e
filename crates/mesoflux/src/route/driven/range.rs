//! Up to which strength a response is linear.

use super::Way;
use crate::route::Outcome;
use mesoflux_analysis::{ResponseCurve, ResponsePoint};

/// Standard errors beyond which a point counts as off the straight line.
const ERRORS: f64 = 2.0;
/// How far a point must be off at least, as a share of the linear response, to be worth a word.
const SHARE: f64 = 0.01;

/// Which strengths lie outside of the linear regime.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearRange {
    /// Where the answer is off the straight line with the slope at zero.
    beyond: Vec<f64>,
    /// The largest strength up to which no point is, its sign left out.
    largest: Option<f64>,
}

/// Finds the points that are off the straight line with the curve's slope at zero: by more than two standard errors (those of point
/// and line, taken as independent) and more than 1 %. None is, where the curve as a whole is not found to bend.
pub(super) fn linear_range(points: &[ResponsePoint], curve: &ResponseCurve) -> LinearRange {
    let slope = (curve.coefficient.value, curve.coefficient.standard_error);
    let is_beyond = |point: &ResponsePoint| {
        let (Some(slope), Some(error), Some(false)) = (slope.0, slope.1, curve.linear) else { return false };
        let line = slope * point.x;
        let tolerance = ERRORS * point.standard_error.hypot(error * point.x);
        (point.y - line).abs() > tolerance.max(SHARE * line.abs())
    };
    let mut sorted: Vec<&ResponsePoint> = points.iter().collect();
    sorted.sort_by(|a, b| a.x.abs().total_cmp(&b.x.abs()));
    let beyond: Vec<f64> = sorted.iter().filter(|point| is_beyond(point)).map(|point| point.x).collect();
    let first = beyond.first().map_or(f64::INFINITY, |x| x.abs());
    let largest = sorted.iter().map(|point| point.x.abs()).take_while(|&x| x < first).last();
    LinearRange { beyond, largest }
}

impl LinearRange {
    /// Adds a warning where a strength lies beyond, and the condition how far the linear regime reaches.
    pub(super) fn report<W: Way>(&self, outcome: &mut Outcome) {
        let (imposed, answer) = (W::IMPOSED.name, W::ANSWER.name);
        if let Some(largest) = self.largest {
            outcome.conditions.insert(format!("largest_linear_{imposed}"), largest.into());
        }
        if self.beyond.is_empty() {
            return;
        }
        let beyond = self.beyond.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        let reach = match self.largest {
            Some(largest) => format!("linear within its error up to {largest}"),
            None => "at none of the strengths linear within its error".to_owned(),
        };
        outcome.estimate.warnings.push(format!(
            "{imposed} = {beyond} lies outside of the linear regime: there the {answer} is off the straight line by more than two \
             standard errors and 1 %; it is {reach}"
        ));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use mesoflux_analysis::{OrderChoice, fit_response};

    fn range(cubic: f64) -> LinearRange {
        let at = |x: f64| ResponsePoint {
            x,
            y: x + cubic * x.powi(3),
            standard_error: 0.005 * x.abs(),
            effective_samples: 1e3,
        };
        let points = [4.0, -1.0, 2.0, 0.5, 3.0].map(at);
        linear_range(&points, &fit_response(&points, OrderChoice::Fixed(2)).unwrap())
    }

    #[test]
    fn strengths_beyond_the_linear_regime_are_named() {
        // x³/100: 1 % off at 1, 4 % at 2. The error of the line is about that of a point, so 2 % is seen.
        let found = range(0.01);
        assert_eq!((found.beyond, found.largest), (vec![2.0, 3.0, 4.0], Some(1.0)));
        let found = range(0.0);
        assert_eq!((found.beyond, found.largest), (vec![], Some(4.0)));
    }
}
