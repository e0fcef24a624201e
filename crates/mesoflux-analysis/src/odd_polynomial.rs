//! Weighted least squares with odd powers.

use crate::estimate::{Estimate, student_quantile};
use crate::fit::Cholesky;
use crate::response_curve::ResponsePoint;

/// Degrees of freedom beyond which Student's distribution is the normal one for every purpose.
const MANY_DEGREES: f64 = 1e6;

/// y = `Σ_k c_k u^(2k+1)` with u = x/scale, fitted with weights 1/s².
pub(crate) struct OddFit {
    /// `c_k`.
    pub(crate) coefficients: Vec<f64>,
    /// Row k holds the weights `w_i` with `c_k = Σ_i w_i y_i`.
    rows: Vec<Vec<f64>>,
    /// Variance and degrees of freedom of each point.
    variances: Vec<(f64, f64)>,
    pub(crate) chi_squared: f64,
    pub(crate) degrees_of_freedom: usize,
}

impl OddFit {
    /// Fits `order` odd powers; `None` if the points don't determine them.
    pub(crate) fn new(points: &[ResponsePoint], scale: f64, order: usize) -> Option<Self> {
        let degrees_of_freedom = points.len().checked_sub(order)?;
        let power = |point: &ResponsePoint, k: usize| (point.x / scale).powi(2 * k as i32 + 1);
        let weight = |point: &ResponsePoint| point.standard_error.powi(-2);
        let normal_entry =
            |j: usize, k: usize| points.iter().map(|point| weight(point) * power(point, j) * power(point, k)).sum();
        let normal: Vec<Vec<f64>> = (0..order).map(|j| (0..order).map(|k| normal_entry(j, k)).collect()).collect();
        let factor = Cholesky::new(&normal)?;
        let row = |k: usize| -> Vec<f64> {
            let unit: Vec<f64> = (0..order).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
            let inverse = factor.solve(&unit);
            let at = |point| weight(point) * (0..order).map(|j| inverse[j] * power(point, j)).sum::<f64>();
            points.iter().map(at).collect()
        };
        let rows: Vec<Vec<f64>> = (0..order).map(row).collect();
        let coefficients: Vec<f64> =
            rows.iter().map(|row| row.iter().zip(points).map(|(weight, point)| weight * point.y).sum()).collect();
        let residual =
            |point: &ResponsePoint| point.y - (0..order).map(|k| coefficients[k] * power(point, k)).sum::<f64>();
        let chi_squared: f64 = points.iter().map(|point| weight(point) * residual(point).powi(2)).sum();
        let variances =
            points.iter().map(|point| (point.standard_error.powi(2), point.effective_samples - 1.0)).collect();
        let finite = chi_squared.is_finite() && coefficients.iter().all(|coefficient| coefficient.is_finite());
        finite.then_some(Self { coefficients, rows, variances, chi_squared, degrees_of_freedom })
    }

    /// Coefficient k.
    pub(crate) fn coefficient(&self, k: usize) -> Estimate {
        self.linear(self.coefficients[k], &self.rows[k])
    }

    /// `c_1/c_0`, by the delta method: the share of the cubic term at x = scale.
    pub(crate) fn nonlinearity(&self) -> Estimate {
        let ratio = self.coefficients[1] / self.coefficients[0];
        let weights: Vec<f64> = self.rows[1]
            .iter()
            .zip(&self.rows[0])
            .map(|(one, zero)| (one - ratio * zero) / self.coefficients[0])
            .collect();
        self.linear(ratio, &weights)
    }

    /// Whether coefficient k differs from zero at the given confidence.
    pub(crate) fn is_present(&self, k: usize, confidence: f64) -> bool {
        let estimate = self.coefficient(k);
        let threshold = student_quantile(estimate.effective_samples - 1.0, confidence);
        estimate.z_score_against(0.0, 0.0).zip(threshold).is_some_and(|(z, threshold)| z.abs() > threshold)
    }

    /// `value` with the error of `Σ_i w_i y_i`, its degrees of freedom by Welch and Satterthwaite:
    /// `ν = (Σ w_i² s_i²)²/Σ (w_i² s_i²)²/ν_i`.
    fn linear(&self, value: f64, weights: &[f64]) -> Estimate {
        let parts = weights
            .iter()
            .zip(&self.variances)
            .map(|(weight, (variance, degrees))| (weight * weight * variance, degrees));
        let (variance, over_degrees) =
            parts.fold((0.0, 0.0), |(sum, over), (part, degrees)| (sum + part, over + part * part / degrees));
        let degrees = (variance * variance / over_degrees).min(MANY_DEGREES);
        Estimate::new(value, variance.sqrt(), 1.0 + degrees)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(law: impl Fn(f64) -> f64) -> Vec<ResponsePoint> {
        let at = |x: f64| ResponsePoint { x, y: law(x), standard_error: 0.1 * x, effective_samples: 11.0 };
        [0.5, 1.0, 2.0].map(at).to_vec()
    }

    #[test]
    fn an_exact_law_is_recovered() {
        let fit = OddFit::new(&points(|x| 3.0 * x - 0.5 * x.powi(3)), 2.0, 2).unwrap();
        // c_0 = α·scale, c_1 = β·scale³.
        assert!((fit.coefficients[0] - 6.0).abs() < 1e-12 && (fit.coefficients[1] + 4.0).abs() < 1e-12);
        assert!(fit.chi_squared < 1e-20);
        assert!((fit.nonlinearity().value.unwrap() + 2.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn errors_and_degrees_of_freedom_of_a_line_by_hand() {
        // y/x has error 0.1 at each of three points: their mean has 0.1/√3, and 3 × 10 degrees of freedom.
        let slope = OddFit::new(&points(|x| 3.0 * x), 2.0, 1).unwrap().coefficient(0).scaled(0.5);
        assert!((slope.value.unwrap() - 3.0).abs() < 1e-12);
        assert!((slope.standard_error.unwrap() - 0.1 / 3f64.sqrt()).abs() < 1e-12);
        assert!((slope.effective_samples - 31.0).abs() < 1e-9);
    }

    #[test]
    fn what_the_points_do_not_determine_is_refused() {
        let mut same = points(|x| x);
        for point in &mut same {
            point.x = 1.0;
        }
        assert!(OddFit::new(&same, 1.0, 2).is_none());
        assert!(OddFit::new(&same, 1.0, 4).is_none());
    }
}
