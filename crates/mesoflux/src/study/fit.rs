//! Weighted least squares of a few parameters, with their covariance, and curves of the form y = exp η(ln x).

use super::series::Point;
use mesoflux_analysis::chi_squared_survival;

/// The least χ² = Σ ((value − Σ_k row_k a_k)/error)².
#[derive(Debug, Clone)]
pub struct Fit {
    /// The a_k.
    pub parameters: Vec<f64>,
    /// Their covariance if the errors are right.
    pub covariance: Vec<Vec<f64>>,
    /// χ² at its least.
    pub chi_squared: f64,
    /// Points less parameters.
    pub freedom: usize,
}

/// A fit is bad if chance alone would give a larger χ² less often than this.
const BAD: f64 = 0.01;

impl Fit {
    /// The fit through values with errors, a row of the parameters' factors for each; `None` if they don't determine the
    /// parameters.
    pub fn new(rows: &[Vec<f64>], values: &[f64], errors: &[f64]) -> Option<Self> {
        let count = rows.first()?.len();
        let freedom = rows.len().checked_sub(count)?;
        let sum = |term: &dyn Fn(usize) -> f64| -> f64 { (0..rows.len()).map(|i| term(i) / errors[i].powi(2)).sum() };
        let normal: Vec<Vec<f64>> =
            (0..count).map(|j| (0..count).map(|k| sum(&|i| rows[i][j] * rows[i][k])).collect()).collect();
        let covariance = inverse(&normal)?;
        let right: Vec<f64> = (0..count).map(|j| sum(&|i| rows[i][j] * values[i])).collect();
        let parameters: Vec<f64> = covariance.iter().map(|row| dot(row, &right)).collect();
        let chi_squared = sum(&|i| (values[i] - dot(&rows[i], &parameters)).powi(2));
        Some(Self { parameters, covariance, chi_squared, freedom })
    }

    /// The standard error of a parameter if the errors of the values are right.
    pub fn standard_error(&self, parameter: usize) -> f64 {
        self.covariance[parameter][parameter].sqrt()
    }

    /// √(χ²/ν) where the fit is bad: what errors must grow by so that the points lie on the curve.
    pub fn excess(&self) -> Option<f64> {
        excess(self.chi_squared, self.freedom)
    }
}

/// √(χ²/ν) where chance would give a larger χ² in less than one of a hundred cases.
pub fn excess(chi_squared: f64, freedom: usize) -> Option<f64> {
    let chance = chi_squared_survival(chi_squared, freedom as f64).ok()?;
    (chance < BAD).then(|| (chi_squared / freedom as f64).sqrt())
}

/// A curve at one point.
pub struct Curve {
    /// η.
    pub value: f64,
    /// Its derivatives by the parameters.
    pub row: Vec<f64>,
    /// Its derivative by ln x.
    pub slope: f64,
}

/// Steps of Gauss and Newton at most; a handful do where the points determine the parameters.
const STEPS: usize = 200;

/// The parameters a of y = exp η(ln x; a) with the least χ² = Σ (y − exp η)²/s², where s² = s_y² + (exp η · η' · s_x/x)².
///
/// A fit of ln y against ln x, but for points that are mostly noise: those would pull a fit of logarithms upward, where they have one
/// at all, because a point that lies too high looks more precise than it is. `curve` gives η at a ln x, or nothing where the
/// parameters allow none.
///
/// # Errors
/// Points that don't determine the parameters.
pub fn fit_exponential(
    points: &[Point],
    start: &[f64],
    curve: impl Fn(&[f64], f64) -> Option<Curve>,
) -> Result<Fit, String> {
    if let Some(point) = points.iter().find(|p| !(p.x > 0.0 && (p.y_error > 0.0 || p.x_error > 0.0))) {
        return Err(format!("the point ({}, {}) has no logarithm or no error", point.x, point.y));
    }
    let undetermined = || format!("{} points don't determine {} parameters", points.len(), start.len());
    let at = |a: &[f64]| points.iter().map(|point| curve(a, point.x.ln())).collect::<Option<Vec<Curve>>>();
    let mut parameters = start.to_vec();
    for _ in 0..STEPS {
        let curves = at(&parameters).ok_or_else(undetermined)?;
        let residuals = points.iter().zip(&curves).map(|(point, curve)| point.y * (-curve.value).exp() - 1.0);
        let errors = points
            .iter()
            .zip(&curves)
            .map(|(point, curve)| (point.y_error * (-curve.value).exp()).hypot(curve.slope * point.x_error / point.x));
        let rows: Vec<Vec<f64>> = curves.iter().map(|curve| curve.row.clone()).collect();
        let (residuals, errors): (Vec<f64>, Vec<f64>) = (residuals.collect(), errors.collect());
        let mut fit = Fit::new(&rows, &residuals, &errors).ok_or_else(undetermined)?;
        // No further than a factor of e at once at any point, and only where there is a curve.
        let largest = rows.iter().map(|row| dot(row, &fit.parameters).abs()).fold(0.0, f64::max);
        let mut part = 1.0 / largest.max(1.0);
        let moved = |part: f64| -> Vec<f64> {
            parameters.iter().zip(&fit.parameters).map(|(old, step)| old + part * step).collect()
        };
        while at(&moved(part)).is_none() && part > f64::EPSILON {
            part *= 0.5;
        }
        let next = moved(part);
        let small = |k: usize| fit.parameters[k].abs() <= 1e-6 * fit.standard_error(k) + 1e-12 * (1.0 + next[k].abs());
        let settled = part == 1.0 && (0..next.len()).all(small);
        parameters = next;
        if settled {
            fit.parameters = parameters;
            return Ok(fit);
        }
    }
    Err(format!("the fit of {} parameters to {} points doesn't settle", start.len(), points.len()))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The inverse of a symmetric positive-definite matrix by Gauss and Jordan, scaled to a unit diagonal; `None` unless it is definite to
/// working precision.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / matrix[i][i].sqrt()).collect();
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| matrix[i][j] * scale[i] * scale[j]).chain((0..n).map(|j| unit(i, j))).collect())
        .collect();
    for i in 0..n {
        let pivot = rows[i][i];
        if !(pivot > 1e-12) {
            return None;
        }
        rows[i].iter_mut().for_each(|entry| *entry /= pivot);
        let reference = rows[i].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(j, _)| *j != i) {
            let factor = row[i];
            row.iter_mut().zip(&reference).for_each(|(entry, own)| *entry -= factor * own);
        }
    }
    Some((0..n).map(|i| (0..n).map(|j| rows[i][n + j] * scale[i] * scale[j]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_done_by_hand() {
        // y = a + b x through (0, 1), (1, 2), (2, 4) with errors 1, 1, 2: weights 1, 1, 1/4.
        let rows = [0.0, 1.0, 2.0].map(|x| vec![1.0, x]);
        let fit = Fit::new(&rows, &[1.0, 2.0, 4.0], &[1.0, 1.0, 2.0]).unwrap();
        // S = 9/4, Sx = 3/2, Sxx = 2, Sy = 4, Sxy = 4; determinant 9/4.
        let (a, b) = ((2.0 * 4.0 - 1.5 * 4.0) / 2.25, (2.25 * 4.0 - 1.5 * 4.0) / 2.25);
        assert!((fit.parameters[0] - a).abs() < 1e-12 && (fit.parameters[1] - b).abs() < 1e-12);
        assert!((fit.standard_error(1) - 1.0).abs() < 1e-12);
        assert!((fit.standard_error(0) - (2.0f64 / 2.25).sqrt()).abs() < 1e-12);
        assert_eq!(fit.freedom, 1);
    }

    #[test]
    fn what_the_points_do_not_determine_is_refused() {
        assert!(Fit::new(&[vec![1.0, 2.0], vec![1.0, 2.0]], &[1.0, 1.0], &[1.0, 1.0]).is_none());
        assert!(Fit::new(&[vec![1.0, 2.0]], &[1.0], &[1.0]).is_none());
    }

    #[test]
    fn only_a_bad_fit_has_an_excess() {
        // For ν = 4 the chance to exceed 13.28 is 0.01.
        assert_eq!(excess(13.2, 4), None);
        assert!((excess(16.0, 4).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(excess(0.0, 0), None);
    }
}
