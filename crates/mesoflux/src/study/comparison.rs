//! Two series against each other: their ratio at equal x, with the error of its mean.

use super::fit::excess;
use super::series::{LogPoint, Point, logarithms};

/// The ratio of two series where both are known.
///
/// ρ_i = ln y_i − Σ_j w_ij ln y'_j at the x_i of the numerator, w the weights of the linear interpolation of the denominator's
/// logarithms (one weight of 1 where it has a point at x_i). Outside the denominator's range there is no comparison.
/// Errors go by first order from every y and x of both series, each independent: neighboring ratios that share a point of
/// the denominator are correlated, and the error of the mean knows it.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Every ratio: x, its error, exp ρ_i and its error.
    pub points: Vec<Point>,
    /// The weighted mean of ρ_i.
    pub mean: f64,
    /// Its standard error, larger by √(χ²/ν) where the ratios scatter more than their errors allow.
    pub standard_error: f64,
    /// That factor, if it was needed.
    pub excess: Option<f64>,
    /// The largest |ρ_i| in units of its own error.
    pub largest_score: f64,
}

/// Numbers that agree to so many parts are the same x.
const SAME: f64 = 1e-9;

/// What one ratio takes from the denominator: which points with which weights, and the slope there.
struct Interpolation {
    weights: Vec<(usize, f64)>,
    slope: f64,
}

impl Comparison {
    /// The ratio of two series of points, each by growing x.
    ///
    /// # Errors
    /// Points without logarithm or error, or none in common.
    pub fn new(numerator: &[Point], denominator: &[Point]) -> Result<Self, String> {
        let (above, below) = (logarithms(numerator)?, logarithms(denominator)?);
        let pairs: Vec<(&LogPoint, Interpolation)> =
            above.iter().filter_map(|point| Some((point, interpolation(&below, point.x)?))).collect();
        if pairs.is_empty() {
            return Err("the two series have no x in common".to_owned());
        }
        let logs: Vec<f64> = pairs
            .iter()
            .map(|(point, at)| point.y - at.weights.iter().map(|&(j, w)| w * below[j].y).sum::<f64>())
            .collect();
        let single = |k: usize| {
            let only: Vec<f64> = (0..pairs.len()).map(|i| f64::from(u8::from(i == k))).collect();
            variance(&pairs, &below, &only)
        };
        let variances: Vec<f64> = (0..pairs.len()).map(single).collect();
        let total: f64 = variances.iter().map(|variance| 1.0 / variance).sum();
        let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / variance / total).collect();
        let mean: f64 = weights.iter().zip(&logs).map(|(weight, log)| weight * log).sum();
        let chi_squared = logs.iter().zip(&variances).map(|(log, variance)| (log - mean).powi(2) / variance).sum();
        let excess = excess(chi_squared, logs.len() - 1);
        let standard_error = variance(&pairs, &below, &weights).sqrt() * excess.unwrap_or(1.0);
        let scores = logs.iter().zip(&variances).map(|(log, variance)| log.abs() / variance.sqrt());
        let points = pairs.iter().zip(&logs).zip(&variances).map(|(((point, _), log), variance)| Point {
            x: point.x.exp(),
            x_error: point.x.exp() * point.x_error,
            y: log.exp(),
            y_error: log.exp() * variance.sqrt(),
        });
        Ok(Self {
            points: points.collect(),
            mean,
            standard_error,
            excess,
            largest_score: scores.fold(0.0, f64::max),
        })
    }
}

/// The denominator at a ln x, if that is in its range.
fn interpolation(below: &[LogPoint], x: f64) -> Option<Interpolation> {
    if let Some(same) = below.iter().position(|point| (point.x - x).abs() <= SAME) {
        return Some(Interpolation { weights: vec![(same, 1.0)], slope: 0.0 });
    }
    let j = below.windows(2).position(|pair| pair[0].x < x && x < pair[1].x)?;
    let (a, b) = (&below[j], &below[j + 1]);
    let share = (x - a.x) / (b.x - a.x);
    Some(Interpolation { weights: vec![(j, 1.0 - share), (j + 1, share)], slope: (b.y - a.y) / (b.x - a.x) })
}

/// The variance of Σ v_i ρ_i.
fn variance(pairs: &[(&LogPoint, Interpolation)], below: &[LogPoint], v: &[f64]) -> f64 {
    let mut total = 0.0;
    // What the sum takes from the y and the x of each point of the denominator.
    let mut shares = vec![(0.0, 0.0); below.len()];
    for ((point, at), v) in pairs.iter().zip(v) {
        total += (v * point.y_error).powi(2) + (v * at.slope * point.x_error).powi(2);
        for &(j, w) in &at.weights {
            shares[j].0 += v * w;
            shares[j].1 += v * w * at.slope;
        }
    }
    let of_one = |((y, x), point): (&(f64, f64), &LogPoint)| (y * point.y_error).powi(2) + (x * point.x_error).powi(2);
    total + shares.iter().zip(below).map(of_one).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, relative: f64) -> Point {
        Point { x, x_error: 0.0, y, y_error: y * relative }
    }

    #[test]
    fn equal_places_are_compared_as_they_are() {
        let above = [point(1.0, 2.0, 0.03), point(2.0, 6.0, 0.03), point(9.0, 1.0, 0.03)];
        let below = [point(1.0, 1.0, 0.04), point(2.0, 3.0, 0.04)];
        let found = Comparison::new(&above, &below).unwrap();
        assert_eq!(found.points.len(), 2, "there is nothing below at 9");
        assert!((found.mean.exp() - 2.0).abs() < 1e-12);
        assert!((found.standard_error - 0.05 / 2f64.sqrt()).abs() < 1e-12);
        assert!((found.points[0].y_error - 0.1).abs() < 1e-12);
        assert!((found.largest_score - 2f64.ln() / 0.05).abs() < 1e-9);
    }

    #[test]
    fn a_power_law_is_interpolated_exactly_and_shared_points_are_not_counted_twice() {
        let law = |x: f64| 3.0 * x.powf(-1.5);
        let below = [point(1.0, law(1.0), 0.04), point(4.0, law(4.0), 0.04)];
        let above = [2.0, 2.5].map(|x| point(x, 0.5 * law(x), 0.0));
        let above = above.map(|p| Point { x_error: 0.0, y_error: p.y * 1e-9, ..p });
        let found = Comparison::new(&above, &below).unwrap();
        assert!((found.mean - 0.5f64.ln()).abs() < 1e-9);
        // Both ratios hang on the same two points: the mean is hardly better than each of them, 0.04/√2 at the very middle.
        assert!(found.standard_error > 0.04 / 2f64.sqrt() - 1e-9, "{}", found.standard_error);
    }

    #[test]
    fn an_error_in_x_counts_with_the_slope() {
        let below = [point(1.0, 1.0, 1e-9), point(4.0, 16.0, 1e-9)];
        let above = [Point { x: 2.0, x_error: 0.02, y: 4.0, y_error: 0.0 }];
        let found = Comparison::new(&above, &below).unwrap();
        assert!((found.standard_error - 2.0 * 0.01).abs() < 1e-8, "{}", found.standard_error);
    }
}
