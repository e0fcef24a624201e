//! Tests of whether data follow a distribution.

use crate::error::{AnalysisError, require_finite, require_length};
use serde::{Deserialize, Serialize};
use statrs::function::erf::{erf, erfc};
use statrs::function::gamma::checked_gamma_ur;

/// Bins are merged with their neighbors until at least this many counts are expected in each.
const FEWEST_EXPECTED: f64 = 5.0;

/// Chance that χ² with the given degrees of freedom exceeds `statistic`; 1 for a statistic of zero.
///
/// # Errors
/// If the degrees of freedom aren't positive or the statistic is negative or not finite.
pub fn chi_squared_survival(statistic: f64, degrees_of_freedom: f64) -> Result<f64, AnalysisError> {
    if !(degrees_of_freedom > 0.0 && degrees_of_freedom.is_finite()) {
        let value = degrees_of_freedom;
        return Err(AnalysisError::OutOfRange {
            name: "degrees of freedom",
            value,
            requirement: "positive and finite",
        });
    }
    if !(statistic >= 0.0 && statistic.is_finite()) {
        return Err(AnalysisError::OutOfRange {
            name: "chi squared",
            value: statistic,
            requirement: "at least 0, finite",
        });
    }
    if statistic == 0.0 {
        return Ok(1.0);
    }
    checked_gamma_ur(0.5 * degrees_of_freedom, 0.5 * statistic)
        .map_err(|_| AnalysisError::Underdetermined("the chi-squared distribution could not be evaluated"))
}

/// What Pearson's test finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChiSquared {
    /// χ².
    pub statistic: f64,
    /// Bins after merging, less the constraints.
    pub degrees_of_freedom: usize,
    /// The chance of a χ² at least as large.
    pub p_value: f64,
}

/// The chance of counts at least as far from the expected ones as those observed, by [`chi_squared_test`].
///
/// # Errors
/// Those of the test.
pub fn chi_squared_p_value(observed: &[f64], expected: &[f64], constraints: usize) -> Result<f64, AnalysisError> {
    Ok(chi_squared_test(observed, expected, constraints)?.p_value)
}

/// Pearson's test of counts against the expected ones.
///
/// χ² = Σ (observed − expected)²/expected over bins, with as many degrees of freedom as bins less `constraints`
/// (1 if the expected counts were scaled to the observed total, one more for each fitted parameter). Neighboring bins are merged
/// until at least 5 counts are expected in each. The counts must be independent: thin out correlated data first.
///
/// # Errors
/// If the lengths differ, a count is negative or not finite, nothing is expected, or no degree of freedom is left.
pub fn chi_squared_test(observed: &[f64], expected: &[f64], constraints: usize) -> Result<ChiSquared, AnalysisError> {
    require_length("expected counts", expected.len(), observed.len())?;
    for (name, counts) in [("observed counts", observed), ("expected counts", expected)] {
        require_finite(name, counts)?;
        if let Some(&value) = counts.iter().find(|&&count| count < 0.0) {
            return Err(AnalysisError::OutOfRange { name, value, requirement: "at least 0" });
        }
    }
    let bins = merge_sparse_bins(observed, expected);
    if bins.len() <= constraints {
        return Err(AnalysisError::Underdetermined("no degree of freedom is left after merging sparse bins"));
    }
    let statistic = bins.iter().map(|(observed, expected)| (observed - expected).powi(2) / expected).sum();
    let degrees_of_freedom = bins.len() - constraints;
    let p_value = chi_squared_survival(statistic, degrees_of_freedom as f64)?;
    Ok(ChiSquared { statistic, degrees_of_freedom, p_value })
}

/// Pairs of observed and expected counts with at least [`FEWEST_EXPECTED`] expected in each, if in all together.
fn merge_sparse_bins(observed: &[f64], expected: &[f64]) -> Vec<(f64, f64)> {
    let mut bins: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (observed, expected) in observed.iter().zip(expected) {
        open = (open.0 + observed, open.1 + expected);
        if open.1 >= FEWEST_EXPECTED {
            bins.push(open);
            open = (0.0, 0.0);
        }
    }
    // What is left over at the end joins the last complete bin.
    if let Some(last) = bins.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    bins
}

/// Kolmogorov and Smirnov's test: the chance of a largest distance between the sample's distribution function and `cdf` at
/// least as large as found, for independent samples and a `cdf` without fitted parameters.
///
/// Asymptotic distribution at (√n + 0.12 + 0.11/√n) D (M. A. Stephens, J. R. Stat. Soc. B 32, 115 (1970)), good to a few
/// per cent of itself or better from n = 5 on.
///
/// # Errors
/// If the sample is empty, not sorted or not finite, or if `cdf` leaves the range from 0 to 1.
pub fn kolmogorov_smirnov_p_value(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> Result<f64, AnalysisError> {
    if sorted.is_empty() {
        return Err(AnalysisError::Underdetermined("the sample is empty"));
    }
    require_finite("sample", sorted)?;
    if !sorted.is_sorted() {
        return Err(AnalysisError::Underdetermined("the sample is not sorted in ascending order"));
    }
    let count = sorted.len() as f64;
    let mut distance: f64 = 0.0;
    for (index, &value) in sorted.iter().enumerate() {
        let probability = cdf(value);
        if !(0.0..=1.0).contains(&probability) {
            let requirement = "between 0 and 1";
            return Err(AnalysisError::OutOfRange { name: "distribution function", value: probability, requirement });
        }
        // The sample's distribution function jumps here: both sides count.
        distance = distance.max(probability - index as f64 / count).max((index as f64 + 1.0) / count - probability);
    }
    Ok(kolmogorov_survival((count.sqrt() + 0.12 + 0.11 / count.sqrt()) * distance))
}

/// Chance that Kolmogorov's statistic exceeds x: 2 Σ_{j ≥ 1} (−1)^(j−1) exp(−2 j² x²), by the form that converges fast.
fn kolmogorov_survival(x: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let survival = if x < 0.1 {
        1.0
    } else if x < 1.0 {
        // Jacobi's transformation of the sum: √(2π)/x Σ exp(−(2j − 1)² π²/(8 x²)) is the distribution function.
        let term = |j: i32| (-(f64::from(2 * j - 1) * PI / x).powi(2) / 8.0).exp();
        1.0 - TAU.sqrt() / x * (1..=4).map(term).sum::<f64>()
    } else {
        let term = |j: i32| f64::from(1 - 2 * ((j - 1) % 2)) * (-2.0 * (f64::from(j) * x).powi(2)).exp();
        2.0 * (1..=6).map(term).sum::<f64>()
    };
    survival.clamp(0.0, 1.0)
}

/// Distribution function of the standard normal distribution.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z / std::f64::consts::SQRT_2)
}

/// Distribution function of the speed of a particle whose three velocity components have the given variance (kT/m).
///
/// Maxwell: erf(v/√(2 s)) − √(2/(π s)) v exp(−v²/(2 s)), s the variance; 0 for v ≤ 0. The variance must be positive.
pub fn maxwell_speed_cdf(speed: f64, variance: f64) -> f64 {
    if speed <= 0.0 {
        return 0.0;
    }
    let x = speed / (2.0 * variance).sqrt();
    (erf(x) - 2.0 / std::f64::consts::PI.sqrt() * x * (-x * x).exp()).clamp(0.0, 1.0)
}

/// How a set of z-scores compares with independent draws from the standard normal distribution.
///
/// All p-values are chances, under that hypothesis, of something at least as far off as found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StandardNormalSummary {
    /// Number of scores.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their mean square: the variance about zero.
    pub variance: f64,
    /// Largest magnitude.
    pub largest: f64,
    /// Of the mean (two-sided, normal).
    pub mean_p_value: f64,
    /// Of the mean square (two-sided, χ² with `count` degrees of freedom).
    pub variance_p_value: f64,
    /// Of the largest magnitude: 1 − P(|z| < largest)^count.
    pub largest_p_value: f64,
    /// Of the shape (Kolmogorov–Smirnov).
    pub shape_p_value: f64,
}

/// Compares z-scores with the standard normal distribution.
///
/// # Errors
/// If there are none or one isn't finite.
pub fn standard_normal_summary(scores: &[f64]) -> Result<StandardNormalSummary, AnalysisError> {
    let mut sorted = scores.to_vec();
    sorted.sort_by(f64::total_cmp);
    let shape_p_value = kolmogorov_smirnov_p_value(&sorted, normal_cdf)?;
    let number = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / number;
    let squares: f64 = scores.iter().map(|z| z * z).sum();
    let largest = scores.iter().fold(0.0f64, |largest, z| largest.max(z.abs()));
    let above = chi_squared_survival(squares, number)?;
    let tail = 2.0 * normal_cdf(-largest);
    Ok(StandardNormalSummary {
        count: scores.len(),
        mean,
        variance: squares / number,
        largest,
        mean_p_value: 2.0 * normal_cdf(-mean.abs() * number.sqrt()),
        variance_p_value: 2.0 * above.min(1.0 - above),
        // 1 − (1 − tail)^n without loss of digits for a small tail.
        largest_p_value: -(number * (-tail).ln_1p()).exp_m1(),
        shape_p_value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_values() {
        assert!((normal_cdf(1.959_964) - 0.975).abs() < 1e-7);
        assert!((chi_squared_survival(18.307, 10.0).unwrap() - 0.05).abs() < 1e-5);
        // Kolmogorov's critical values: 1.3581 at 5 %, 1.6276 at 1 %, median 0.82757.
        for (x, p) in [(1.3581, 0.05), (1.6276, 0.01), (0.82757, 0.5)] {
            assert!((kolmogorov_survival(x) - p).abs() < 1e-4, "{x}");
        }
        // The two forms of the sum meet.
        assert!((kolmogorov_survival(1.0 - 1e-12) - kolmogorov_survival(1.0)).abs() < 1e-10);
    }

    #[test]
    fn maxwell_cdf_is_the_integral_of_the_density() {
        let (variance, step) = (0.7, 1e-3);
        let density = |v: f64| {
            (2.0 / std::f64::consts::PI).sqrt() * v * v * (-v * v / (2.0 * variance)).exp() / f64::powf(variance, 1.5)
        };
        let integral: f64 = (0..1500).map(|i| density((f64::from(i) + 0.5) * step) * step).sum();
        assert!((maxwell_speed_cdf(1.5, variance) - integral).abs() < 1e-6);
        assert_eq!((maxwell_speed_cdf(-1.0, variance), maxwell_speed_cdf(1e9, variance)), (0.0, 1.0));
    }

    #[test]
    fn sparse_bins_are_merged() {
        let bins = merge_sparse_bins(&[1.0, 2.0, 3.0, 9.0, 1.0], &[2.0, 2.0, 2.0, 8.0, 1.0]);
        assert_eq!(bins, [(6.0, 6.0), (10.0, 9.0)]);
        // Mendel's peas: 315, 101, 108, 32 against 9:3:3:1 give χ² = 0.470 with 3 degrees of freedom, p = 0.925.
        let expected = [312.75, 104.25, 104.25, 34.75];
        let p = chi_squared_p_value(&[315.0, 101.0, 108.0, 32.0], &expected, 1).unwrap();
        assert!((p - 0.9254).abs() < 1e-4, "{p}");
    }

    #[test]
    fn bad_input_is_refused() {
        assert!(chi_squared_p_value(&[1.0], &[1.0, 2.0], 0).is_err());
        assert!(chi_squared_p_value(&[-1.0, 9.0], &[8.0, 8.0], 0).is_err());
        assert!(chi_squared_p_value(&[9.0], &[9.0], 1).is_err());
        assert!(chi_squared_survival(1.0, 0.0).is_err());
        assert!(kolmogorov_smirnov_p_value(&[], normal_cdf).is_err());
        assert!(kolmogorov_smirnov_p_value(&[1.0, 0.0], normal_cdf).is_err());
        assert!(kolmogorov_smirnov_p_value(&[1.0], |_| f64::NAN).is_err());
        assert!(standard_normal_summary(&[]).is_err());
        assert!(standard_normal_summary(&[f64::NAN]).is_err());
    }
}
