//! A transport coefficient from several points of a response curve, with a check that the response is linear.

use crate::distribution::chi_squared_survival;
use crate::error::AnalysisError;
use crate::estimate::Estimate;
use crate::odd_polynomial::OddFit;
use serde::{Deserialize, Serialize};

/// A fit whose χ² is exceeded by chance with a smaller probability is refused.
const ACCEPTABLE: f64 = 0.05;
/// Confidence with which a coefficient must differ from zero to count as present.
const SIGNIFICANT: f64 = 0.95;

/// One measured point of a response curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponsePoint {
    /// What was imposed, known exactly: the magnitude of the forcing, or (Norton) the flux.
    pub x: f64,
    /// What was measured: the flux, or (Norton) the mean multiplier.
    pub y: f64,
    /// Standard error of `y`.
    pub standard_error: f64,
    /// Independent samples behind the error, as in [`Estimate`].
    pub effective_samples: f64,
}

impl ResponsePoint {
    /// A point from the estimate of its response; `None` where that has no value or error.
    pub fn new(x: f64, response: &Estimate) -> Option<Self> {
        Some(Self {
            x,
            y: response.value?,
            standard_error: response.standard_error?,
            effective_samples: response.effective_samples,
        })
    }
}

/// How many odd powers to fit.
///
/// Letting the data choose has a price: a cubic term too small to be seen still shifts the slope of a straight line, by up to
/// several of its own standard errors. [`Guarded`](Self::Guarded) pays for honest errors with larger ones: for 4 to 8 evenly spaced
/// points on a line by a factor of 1.7 where their errors grow as x, of 3 where they are all the same (2 % of the response
/// at the largest x, 2000 repetitions; mean square of the pulls 0.88 to 0.97).
///
/// Averaging the orders 1 to 3 with Akaike's weights exp(−χ²/2 − order), the scatter from order to order in the error, is no cheaper
/// (1.6 to 1.8 and 3.0 to 3.3) and less well calibrated (0.38 to 0.66 on a line, 1.22 for a law of fifth order), so it
/// isn't offered: who knows nothing of the cubic term must pay for not seeing it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderChoice {
    /// The lowest order with an acceptable χ² (p > 0.05) above which the next coefficient isn't significant (95 %).
    ///
    /// Right, but for the chance of choosing wrongly, where the law is exactly of that order and the top coefficient is seen clearly:
    /// pulls of a clearly cubic law have a mean square of 1.3.
    Lowest,
    /// One order more than [`Lowest`](Self::Lowest), where the points determine it: the slope's error then includes what a
    /// nonlinearity too small to be seen could do: pulls have a mean square of 0.9 to 1.0 in all cases tried.
    #[default]
    Guarded,
    /// This number of odd powers (1: a straight line through the origin).
    Fixed(usize),
}

/// The fitted odd polynomial y = αx + βx³ + … and the coefficient drawn from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseCurve {
    /// The transport coefficient at vanishing x: α, or 1/α from [`fit_inverse_response`].
    pub coefficient: Estimate,
    /// Coefficients of x, x³, x⁵, … of the fitted polynomial.
    pub polynomial: Vec<f64>,
    /// Sum over points of ((y − fit)/standard error)².
    pub chi_squared: f64,
    /// Points less coefficients.
    pub degrees_of_freedom: usize,
    /// Chance of a larger χ²; `None` without degrees of freedom.
    pub p_value: Option<f64>,
    /// β `x_max²`/α, the share of the cubic term at the largest x, from a fit of at least two powers.
    pub nonlinearity: Estimate,
    /// Whether the response is linear: one power fits and the nonlinearity is zero within its error. `None`: can't tell.
    pub linear: Option<bool>,
}

impl ResponseCurve {
    /// Number of odd powers fitted.
    pub fn order(&self) -> usize {
        self.polynomial.len()
    }
}

/// Fits `y = αx + βx³ + …` through points by weighted least squares; the coefficient is α, the error its
/// marginal over the other coefficients.
///
/// A χ² that no order makes acceptable multiplies the error by √(χ²/degrees of freedom), with a warning. One
/// point alone gives α = y/x and the warning that linearity can't be checked. `effective_samples` follows from those of the
/// points by Welch and Satterthwaite's formula.
///
/// # Errors
/// If there are no points, all have x = 0, a number isn't finite, an error isn't positive, or the points don't determine a
/// [`OrderChoice::Fixed`] order.
pub fn fit_response(points: &[ResponsePoint], choice: OrderChoice) -> Result<ResponseCurve, AnalysisError> {
    check(points)?;
    // Magnitudes of x of order one keep the normal equations well conditioned.
    let scale = points.iter().map(|point| point.x.abs()).fold(0.0, f64::max);
    let fits: Vec<OddFit> = (1..=points.len()).map_while(|order| OddFit::new(points, scale, order)).collect();
    let Some(highest) = fits.len().checked_sub(1) else {
        return Err(AnalysisError::Underdetermined("response points: none has a nonzero x"));
    };
    let settled = |&index: &usize| {
        is_acceptable(&fits[index]) && fits.get(index + 1).is_none_or(|next| !next.is_present(index + 1, SIGNIFICANT))
    };
    let lowest = (0..=highest).find(settled).unwrap_or(highest);
    let chosen = match choice {
        OrderChoice::Lowest => lowest,
        OrderChoice::Guarded => (lowest + 1).min(highest),
        OrderChoice::Fixed(order) if order >= 1 && order <= fits.len() => order - 1,
        OrderChoice::Fixed(order) => {
            let requirement = "at least 1 and at most the number of points with different nonzero |x|";
            return Err(AnalysisError::OutOfRange { name: "order", value: order as f64, requirement });
        }
    };
    let fit = &fits[chosen];
    let mut coefficient = fit.coefficient(0).scaled(1.0 / scale);
    if !is_acceptable(fit) {
        let stretch = (fit.chi_squared / fit.degrees_of_freedom as f64).sqrt().max(1.0);
        coefficient.standard_error = coefficient.standard_error.map(|error| error * stretch);
        coefficient = coefficient.with_warning(format!(
            "an odd polynomial of {} terms doesn't fit: chi squared {:.3e} with {} degrees of freedom; error times {stretch:.2}",
            chosen + 1,
            fit.chi_squared,
            fit.degrees_of_freedom
        ));
    }
    let nonlinearity = match fits.get(chosen.max(1)) {
        Some(cubic) => cubic.nonlinearity(),
        None => Estimate::unknown("linearity can't be checked: fewer than two different nonzero magnitudes of x"),
    };
    let cubic_is_seen = fits.get(chosen.max(1)).map(|cubic| cubic.is_present(1, SIGNIFICANT));
    let linear = cubic_is_seen.map(|seen| !seen && is_acceptable(&fits[0]));
    if linear.is_none() {
        coefficient.warnings.extend(nonlinearity.warnings.iter().cloned());
    }
    let polynomial = fit.coefficients.iter().enumerate().map(|(k, c)| c / scale.powi(2 * k as i32 + 1)).collect();
    let p_value = p_value(fit);
    let (chi_squared, degrees_of_freedom) = (fit.chi_squared, fit.degrees_of_freedom);
    Ok(ResponseCurve { coefficient, polynomial, chi_squared, degrees_of_freedom, p_value, nonlinearity, linear })
}

/// The inverse direction (Norton): the flux r is fixed, the multiplier λ measured, and `λ = a r + b r³ + …` fitted.
///
/// The transport coefficient is α = 1/a with standard error α² `σ_a` (delta method; Wu and Shang, eq. 92). `None` with a warning
/// if a lies within three of its standard errors of zero; a warning if within ten, as 1/a is then visibly skewed.
///
/// # Errors
/// As [`fit_response`].
pub fn fit_inverse_response(points: &[ResponsePoint], choice: OrderChoice) -> Result<ResponseCurve, AnalysisError> {
    let mut curve = fit_response(points, choice)?;
    curve.coefficient = curve.coefficient.inverse();
    Ok(curve)
}

fn p_value(fit: &OddFit) -> Option<f64> {
    chi_squared_survival(fit.chi_squared, fit.degrees_of_freedom as f64).ok()
}

/// A fit without degrees of freedom can't be refused.
fn is_acceptable(fit: &OddFit) -> bool {
    p_value(fit).is_none_or(|p| p > ACCEPTABLE)
}

fn check(points: &[ResponsePoint]) -> Result<(), AnalysisError> {
    if points.is_empty() {
        return Err(AnalysisError::Underdetermined("response points: there are none"));
    }
    for (index, point) in points.iter().enumerate() {
        for (name, value) in [("x", point.x), ("y", point.y), ("standard_error", point.standard_error)] {
            if !value.is_finite() {
                return Err(AnalysisError::NotFinite { name, index, value });
            }
        }
        if point.effective_samples.is_nan() || point.effective_samples <= 1.0 {
            let value = point.effective_samples;
            return Err(AnalysisError::OutOfRange { name: "effective_samples", value, requirement: "above 1" });
        }
        if point.standard_error <= 0.0 {
            let value = point.standard_error;
            return Err(AnalysisError::OutOfRange { name: "standard_error", value, requirement: "positive" });
        }
    }
    Ok(())
}
