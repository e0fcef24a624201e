//! Self-diffusion coefficient from the slope of the mean squared displacement, in a window chosen by the data.

use crate::estimate::{Estimate, student_quantile};
use crate::mean_squared_displacement::MeanSquaredDisplacement;
use serde::{Deserialize, Serialize};

/// Spatial dimensions d of msd = 2 d D t.
const DIMENSIONS: f64 = 3.0;
/// Fewer lags leave too few windows to choose from.
const FEWEST_LAGS: usize = 8;
/// Origins asked for, in units of the longest time difference.
const ORIGINS_PER_LAG: u64 = 4;
/// Largest number of windows tried, spaced geometrically.
const CANDIDATES: usize = 24;
/// Confidence with which the slopes of the two parts of a window must differ to refuse it.
const CONFIDENCE: f64 = 0.95;
/// A change of slope that is still seen in the last window is taken into the error up to this share of the slope.
const TOLERABLE_CURVATURE: f64 = 0.1;
/// The fit begins at this multiple of the first time from which the curve looks straight.
const MARGIN: usize = 2;

/// A diffusion coefficient and the window of time it was fitted in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DiffusionEstimate {
    /// D, in squared length over time.
    pub estimate: Estimate,
    /// First and last time difference of the fit; `None` if no linear window was found.
    pub window: Option<(f64, f64)>,
    /// Intercept of the fitted line, a squared length: negative after ballistic motion, positive after rattling in a cage.
    pub intercept: Estimate,
    /// Slope of the later part of the window less that of the earlier, over 2d: zero within its error.
    pub curvature: Estimate,
}

impl MeanSquaredDisplacement {
    /// The self-diffusion coefficient D from msd = 2 d D t + intercept, d = 3, by a least-squares line over a window of time.
    ///
    /// **Window.** It ends at the longest time difference. Its beginning is found from the curvature: a window is straight if the
    /// slopes of its earlier and later part (which meet at the geometric mean of its ends) agree within their joint error, a
    /// Student test at 95 % on the difference as one linear functional of the curve. Candidates run from the first lag to a quarter of
    /// the last. The fit begins at *twice* the smallest candidate that is straight together with all
    /// later ones: curvature too weak to be seen biases the slope, and twice the time squares an exponential remainder.
    ///
    /// If even the last candidate isn't straight but its slope changes by less than a tenth, as where a long-time tail decays
    /// slowly, the fit uses that window, the whole change of slope is added to the error in quadrature, and a warning says so.
    ///
    /// **Error.** From blocking the slope itself, so correlations of overlapping origins and between lags are
    /// in it; the choice of the window isn't: over series of 50 to 250 times the longest time difference, the z-scores of
    /// Langevin particles have a mean square of 1.1 to 1.5. Equal weights are used although, for Brownian motion, the
    /// minimum-variance weights use nothing but the first two lags: those have no protection against what curvature remains.
    ///
    /// **Cannot tell** (`None` with a warning) if there are fewer than 8 lags, fewer origins than 4 times the lags, or no straight
    /// window. Confined particles give a D that is zero within its error, with a warning.
    ///
    /// The system's finite size (hydrodynamic images) isn't corrected.
    pub fn diffusion_coefficient(&self) -> DiffusionEstimate {
        match self.window() {
            Ok((first, None)) => self.fit(first),
            Ok((first, Some(curvature))) => self.fit_curved(first, curvature),
            Err(warning) => DiffusionEstimate { estimate: Estimate::unknown(warning), ..DiffusionEstimate::default() },
        }
    }

    /// First lag of the window, and the change of D over it where it is seen and small; or why there is no window.
    fn window(&self) -> Result<(usize, Option<f64>), String> {
        if self.lags() < FEWEST_LAGS {
            return Err(format!("cannot tell: {} lags are too few for a window, at least {FEWEST_LAGS}", self.lags()));
        }
        let needed = ORIGINS_PER_LAG * self.lags() as u64;
        if self.origins() < needed {
            return Err(format!("cannot tell: {} origins of time are too few, at least {needed}", self.origins()));
        }
        // After the margin the fit still spans a factor of two in time.
        let last = self.lags() / (2 * MARGIN);
        let straight = |&first: &usize| is_zero_within_error(&self.linear(&self.curvature_weights(first)));
        if let Some(first) = candidates(last).into_iter().rev().take_while(straight).last() {
            return Ok((MARGIN * first, None));
        }
        let slope = self.linear(&self.line_weights(MARGIN * last, self.lags()).0).value;
        let change = self.linear(&self.curvature_weights(last)).value;
        match (slope, change) {
            (Some(slope), Some(change)) if change.abs() < TOLERABLE_CURVATURE * slope.abs() => {
                Ok((MARGIN * last, Some(change * 0.5 / DIMENSIONS)))
            }
            _ => Err(format!(
                "cannot tell: the curve isn't straight from {} on; record longer time differences",
                self.time(last)
            )),
        }
    }

    /// The fit in a window in which D is seen to change a little; the change becomes part of the error.
    fn fit_curved(&self, first: usize, change: f64) -> DiffusionEstimate {
        let mut fit = self.fit(first);
        fit.estimate.standard_error = fit.estimate.standard_error.map(|error| error.hypot(change));
        fit.estimate = fit.estimate.with_warning(format!(
            "the curve isn't quite straight: D still changes by {change:.2e}, which is in the error; record longer time differences"
        ));
        fit
    }

    fn fit(&self, first: usize) -> DiffusionEstimate {
        let (slope, intercept) = self.line_weights(first, self.lags());
        let mut estimate = self.linear(&slope).scaled(0.5 / DIMENSIONS);
        if estimate.interval(0.95).is_some_and(|(low, _)| low <= 0.0) {
            estimate = estimate.with_warning("not above zero within its error: the particles may be confined");
        }
        DiffusionEstimate {
            estimate,
            window: Some((self.time(first), self.time(self.lags()))),
            intercept: self.linear(&intercept),
            curvature: self.linear(&self.curvature_weights(first)).scaled(0.5 / DIMENSIONS),
        }
    }

    /// Weights that give the slope of the later part of the window less that of the earlier.
    ///
    /// The parts meet at the geometric mean: what is left of ballistic motion bends the beginning, where the errors are small.
    fn curvature_weights(&self, first: usize) -> Vec<f64> {
        let middle = ((first * self.lags()) as f64).sqrt().round() as usize;
        let (early, late) = (self.line_weights(first, middle).0, self.line_weights(middle, self.lags()).0);
        late.iter().zip(&early).map(|(late, early)| late - early).collect()
    }

    /// Weights that give slope and intercept of the least-squares line through the lags `first` to `last`.
    fn line_weights(&self, first: usize, last: usize) -> (Vec<f64>, Vec<f64>) {
        let points = (last - first + 1) as f64;
        let mean_time = 0.5 * (self.time(first) + self.time(last));
        let spread: f64 = (first..=last).map(|lag| (self.time(lag) - mean_time).powi(2)).sum();
        let mut slope = vec![0.0; self.lags()];
        let mut intercept = vec![0.0; self.lags()];
        for lag in first..=last {
            slope[lag - 1] = (self.time(lag) - mean_time) / spread;
            intercept[lag - 1] = 1.0 / points - mean_time * slope[lag - 1];
        }
        (slope, intercept)
    }
}

/// At most [`CANDIDATES`] first lags from 1 to `last`, spaced geometrically, ascending.
fn candidates(last: usize) -> Vec<usize> {
    let exponent = |index: usize| index as f64 / (CANDIDATES - 1) as f64;
    let mut lags: Vec<usize> =
        (0..CANDIDATES).map(|index| (last as f64).powf(exponent(index)).round() as usize).collect();
    lags.dedup();
    lags
}

fn is_zero_within_error(estimate: &Estimate) -> bool {
    let threshold = student_quantile(estimate.effective_samples - 1.0, CONFIDENCE);
    match (estimate.value, estimate.standard_error, threshold) {
        (Some(value), Some(error), Some(threshold)) => value.abs() <= threshold * error,
        _ => false,
    }
}
