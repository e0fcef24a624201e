//! Coefficients of a polynomial fitted to points, as linear functionals of the points' values.

use crate::error::{AnalysisError, require_finite, require_length};
use crate::fit::Cholesky;

/// For the weighted least-squares fit y = a₀ + a₁ x + a₂ x² + … through points: the rows c with `a_j = Σ c_j[i] y_i`, one for each of
/// `coefficients` of them.
///
/// The weights are fixed beforehand, up to a common factor. Chosen badly they cost precision; they never bias, as weights would
/// that follow from the data. With the rows any coefficient of a joint series has its honest error
/// ([`Blocking::function`](crate::Blocking::function)).
///
/// # Errors
/// If the lengths differ, a number isn't finite, a weight isn't positive, or the points don't determine so many coefficients.
pub fn polynomial_functionals(x: &[f64], weights: &[f64], coefficients: usize) -> Result<Vec<Vec<f64>>, AnalysisError> {
    require_length("weights", weights.len(), x.len())?;
    require_finite("x", x)?;
    require_finite("weights", weights)?;
    if let Some(&value) = weights.iter().find(|&&weight| weight <= 0.0) {
        return Err(AnalysisError::OutOfRange { name: "weight", value, requirement: "positive" });
    }
    // Values of x of order one keep the normal equations well conditioned.
    let scale = x.iter().fold(f64::MIN_POSITIVE, |scale: f64, x| scale.max(x.abs()));
    let power = |i: usize, j: usize| (x[i] / scale).powi(j as i32);
    let points = || 0..x.len();
    let entry = |j: usize, k: usize| points().map(|i| weights[i] * power(i, j) * power(i, k)).sum();
    let matrix: Vec<Vec<f64>> = (0..coefficients).map(|j| (0..coefficients).map(|k| entry(j, k)).collect()).collect();
    let factor = Cholesky::new(&matrix)
        .filter(|_| coefficients <= x.len())
        .ok_or(AnalysisError::Underdetermined("the points don't determine so many coefficients"))?;
    let columns: Vec<Vec<f64>> = points()
        .map(|i| factor.solve(&(0..coefficients).map(|j| weights[i] * power(i, j)).collect::<Vec<_>>()))
        .collect();
    Ok((0..coefficients).map(|j| columns.iter().map(|column| column[j] / scale.powi(j as i32)).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_the_order_is_found_whatever_the_weights() {
        let x = [40.0, 80.0, 120.0, 160.0];
        let y = x.map(|x| 16.0 - 0.3 * x + 0.002 * x * x);
        for weights in [[1.0; 4], [3.0, 12.0, 12.0, 0.1]] {
            let rows = polynomial_functionals(&x, &weights, 3).unwrap();
            for (row, expected) in rows.iter().zip([16.0, -0.3, 0.002]) {
                let found: f64 = row.iter().zip(y).map(|(c, y)| c * y).sum();
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn a_line_through_three_points_done_by_hand() {
        // Weights 1, 1, 2 at x = 0, 1, 2: means x̄ = 5/4, slope Σ w (x − x̄) y / Σ w (x − x̄)², 11/4 below.
        let rows = polynomial_functionals(&[0.0, 1.0, 2.0], &[1.0, 1.0, 2.0], 2).unwrap();
        let slope = [-1.25 / 2.75, -0.25 / 2.75, 1.5 / 2.75];
        for i in 0..3 {
            assert!((rows[1][i] - slope[i]).abs() < 1e-12);
            assert!((rows[0][i] - ([0.25, 0.25, 0.5][i] - 1.25 * slope[i])).abs() < 1e-12);
        }
    }

    #[test]
    fn bad_input_is_refused() {
        assert!(polynomial_functionals(&[1.0, 2.0], &[1.0], 1).is_err());
        assert!(polynomial_functionals(&[1.0, f64::NAN], &[1.0, 1.0], 1).is_err());
        assert!(polynomial_functionals(&[1.0, 2.0], &[1.0, 0.0], 1).is_err());
        assert!(polynomial_functionals(&[1.0, 2.0], &[1.0, 1.0], 3).is_err());
        assert!(polynomial_functionals(&[1.0, 1.0], &[1.0, 1.0], 2).is_err());
    }
}
