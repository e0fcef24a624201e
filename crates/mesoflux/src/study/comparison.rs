//! Two series against each other: their ratio over all x where both are known.

use super::fit::excess;
use super::series::Point;

/// The ratio ρ of two series, a_i = ρ b_i but for noise, and the ratio at each x.
///
/// b_i is the denominator's point at the x of a_i, or interpolated in log–log between its neighbors; outside the
/// denominator's range there is no comparison. ρ is the most likely one: Σ m_i (a_i − ρ b_i)/σ_i² = 0, with
/// σ_i² = s_a² + ρ² s_b² and m_i = (ρ a_i/s_a² + b_i/s_b²)/(ρ²/s_a² + 1/s_b²), which doesn't know of the difference a_i − ρ b_i. So
/// points that are mostly noise, even negative ones, bias nothing, as they would in a mean of ratios.
///
/// Errors go by first order from every y and x of both series, each independent: ratios that share a point of the
/// denominator are correlated, and the error of ρ knows it.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Every ratio: x, its error, a_i/b_i and its error.
    pub points: Vec<Point>,
    /// ρ.
    pub ratio: f64,
    /// Its standard error, larger by √(χ²/ν) where the ratios scatter more than their errors allow.
    pub standard_error: f64,
    /// That factor, if it was needed.
    pub excess: Option<f64>,
    /// The largest |a_i − b_i| in units of its own error.
    pub largest_score: f64,
}

/// Numbers that agree to so many parts are the same x.
const SAME: f64 = 1e-9;

/// A point of the numerator beside the denominator at its x.
struct Pair<'a> {
    above: &'a Point,
    below: f64,
    /// The derivatives of `below` by the y and by the x of points of the denominator.
    shares: Vec<(usize, f64, f64)>,
    /// Its derivative by the x at which it is taken.
    slope: f64,
}

/// Rounds of the equation for ρ at most.
const ROUNDS: usize = 1000;

impl Comparison {
    /// The ratio of two series of points, each by growing x.
    ///
    /// # Errors
    /// Nothing in common, or points without errors.
    pub fn new(numerator: &[Point], denominator: &[Point]) -> Result<Self, String> {
        let mut pairs = Vec::new();
        for above in numerator {
            pairs.extend(pair(above, denominator)?);
        }
        if pairs.is_empty() {
            return Err("the two series have no x in common".to_owned());
        }
        // The variances of a_i, with what the error of x makes of b_i, and of b_i.
        let errors = |ratio: f64| -> Vec<(f64, f64)> {
            let one = |pair: &Pair| {
                let through_x = ratio * pair.slope * pair.above.x_error;
                let below = |&(j, y, x): &(usize, f64, f64)| {
                    (y * denominator[j].y_error).powi(2) + (x * denominator[j].x_error).powi(2)
                };
                (pair.above.y_error.powi(2) + through_x.powi(2), pair.shares.iter().map(below).sum())
            };
            pairs.iter().map(one).collect()
        };
        let scale = |values: f64| if values.is_finite() && values > 0.0 { values } else { 1.0 };
        let squares = |of: &dyn Fn(&Pair) -> f64| pairs.iter().map(|pair| of(pair).powi(2)).sum::<f64>();
        let mut ratio = scale((squares(&|pair| pair.above.y) / squares(&|pair| pair.below)).sqrt());
        // The shares that the differences a_i − ρ b_i have in the error of ρ.
        let mut weights = vec![0.0; pairs.len()];
        for _ in 0..ROUNDS {
            let (mut top, mut bottom) = (0.0, 0.0);
            for ((pair, (a, b)), weight) in pairs.iter().zip(errors(ratio)).zip(&mut weights) {
                let variance = a + ratio * ratio * b;
                if !(variance > 0.0) {
                    return Err(format!("the point ({}, {}) has no error", pair.above.x, pair.above.y));
                }
                // m_i with both sides multiplied by s_a² s_b², of which one may be zero.
                let middle = (ratio * pair.above.y * b + pair.below * a) / variance;
                *weight = middle / variance;
                top += *weight * pair.above.y;
                bottom += *weight * pair.below;
            }
            let next = top / bottom;
            if !next.is_finite() {
                return Err("nothing can be told of the denominator".to_owned());
            }
            let settled = (next - ratio).abs() <= 1e-12 * ratio.abs();
            ratio = next;
            weights.iter_mut().for_each(|weight| *weight /= bottom);
            if settled {
                break;
            }
        }
        let variances: Vec<f64> = errors(ratio).iter().map(|(a, b)| a + ratio * ratio * b).collect();
        let difference = |pair: &Pair, ratio: f64| pair.above.y - ratio * pair.below;
        let chi_squared =
            pairs.iter().zip(&variances).map(|(pair, variance)| difference(pair, ratio).powi(2) / variance);
        let excess = excess(chi_squared.sum(), pairs.len() - 1);
        let apart = pairs.iter().zip(errors(1.0)).map(|(pair, (a, b))| difference(pair, 1.0).abs() / (a + b).sqrt());
        Ok(Self {
            largest_score: apart.fold(0.0, f64::max),
            standard_error: variance(&pairs, denominator, ratio, &weights).sqrt() * excess.unwrap_or(1.0),
            points: pairs.iter().map(|pair| single(pair, denominator)).collect(),
            ratio,
            excess,
        })
    }
}

/// The denominator at the x of a point, if that is in its range.
fn pair<'a>(above: &'a Point, denominator: &[Point]) -> Result<Option<Pair<'a>>, String> {
    let x = above.x;
    if let Some(j) = denominator.iter().position(|point| (point.x - x).abs() <= SAME * x.abs()) {
        return Ok(Some(Pair { above, below: denominator[j].y, shares: vec![(j, 1.0, 0.0)], slope: 0.0 }));
    }
    let Some(j) = denominator.windows(2).position(|pair| pair[0].x < x && x < pair[1].x) else {
        return Ok(None);
    };
    let (a, b) = (&denominator[j], &denominator[j + 1]);
    if let Some(point) = [a, b].into_iter().find(|point| !(point.x > 0.0 && point.y > 0.0)) {
        return Err(format!("the point ({}, {}) has no logarithm to interpolate at {x}", point.x, point.y));
    }
    let distance = (b.x / a.x).ln();
    let share = (x / a.x).ln() / distance;
    let exponent = (b.y / a.y).ln() / distance;
    let below = a.y * (x / a.x).powf(exponent);
    // A point that lies too far to the right by δ makes the line there too low by the slope times δ.
    let one = |j: usize, point: &Point, share: f64| (j, share * below / point.y, -share * exponent * below / point.x);
    let shares = vec![one(j, a, 1.0 - share), one(j + 1, b, share)];
    Ok(Some(Pair { above, below, shares, slope: exponent * below / x }))
}

/// The variance of Σ v_i (a_i − ρ b_i).
fn variance(pairs: &[Pair], denominator: &[Point], ratio: f64, v: &[f64]) -> f64 {
    let mut total = 0.0;
    let mut shares = vec![(0.0, 0.0); denominator.len()];
    for (pair, v) in pairs.iter().zip(v) {
        total += (v * pair.above.y_error).powi(2) + (v * ratio * pair.slope * pair.above.x_error).powi(2);
        for &(j, y, x) in &pair.shares {
            shares[j].0 += v * ratio * y;
            shares[j].1 += v * ratio * x;
        }
    }
    let of_one = |((y, x), point): (&(f64, f64), &Point)| (y * point.y_error).powi(2) + (x * point.x_error).powi(2);
    total + shares.iter().zip(denominator).map(of_one).sum::<f64>()
}

/// One ratio with its error.
fn single(pair: &Pair, denominator: &[Point]) -> Point {
    let ratio = pair.above.y / pair.below;
    let spread = variance(std::slice::from_ref(pair), denominator, ratio, &[1.0]).sqrt();
    Point { x: pair.above.x, x_error: pair.above.x_error, y: ratio, y_error: spread / pair.below.abs() }
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
        assert!((found.ratio - 2.0).abs() < 1e-12);
        assert!((found.standard_error - 0.1 / 2f64.sqrt()).abs() < 1e-12, "{}", found.standard_error);
        assert!((found.points[0].y_error - 0.1).abs() < 1e-12);
        assert!((found.largest_score - 3.0 / (0.18f64.hypot(0.12))).abs() < 1e-9);
    }

    #[test]
    fn a_power_law_is_interpolated_exactly_and_shared_points_are_not_counted_twice() {
        let law = |x: f64| 3.0 * x.powf(-1.5);
        let below = [point(1.0, law(1.0), 0.04), point(4.0, law(4.0), 0.04)];
        let above = [2.0, 2.5].map(|x| point(x, 0.5 * law(x), 1e-9));
        let found = Comparison::new(&above, &below).unwrap();
        assert!((found.ratio - 0.5).abs() < 1e-9);
        // Both ratios hang on the same two points: together they are no better than the one at the very middle.
        assert!(found.standard_error > 0.5 * 0.04 / 2f64.sqrt() - 1e-6, "{}", found.standard_error);
    }

    #[test]
    fn an_error_in_x_counts_with_the_slope() {
        let below = [point(1.0, 1.0, 1e-9), point(4.0, 16.0, 1e-9)];
        let above = [Point { x: 2.0, x_error: 0.02, y: 4.0, y_error: 0.0 }];
        let found = Comparison::new(&above, &below).unwrap();
        assert!((found.standard_error - 2.0 * 0.01).abs() < 1e-8, "{}", found.standard_error);
        let below = [point(1.0, 1.0, 1e-9), Point { x_error: 0.04, ..point(4.0, 16.0, 1e-9) }];
        let above = [point(2.0, 4.0, 1e-9)];
        let found = Comparison::new(&above, &below).unwrap();
        assert!((found.standard_error - 0.5 * 2.0 * 0.01).abs() < 1e-8, "{}", found.standard_error);
    }
}
