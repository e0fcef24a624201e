//! The correlation function of whole series at all lags, by fast Fourier transform.

use crate::error::{AnalysisError, require_finite, require_length};
use realfft::RealFftPlanner;

/// `C(k) = 1/(n − k) Σ_{t=0}^{n−k−1} later[t + k] · earlier[t]` for lags k = 0 … `lags` − 1 in samples, n the length of both series.
///
/// The order is that of [`MultipleTau`](super::MultipleTau): the first series at the later time. Each lag is divided by its own number of
/// products, so the estimate is unbiased; no mean is subtracted. The series are padded with zeros, so that no product wraps
/// around. Time O(n log n).
///
/// # Errors
/// If the series' lengths differ, an entry isn't finite, or there are more lags than entries.
pub fn full_correlation(later: &[f64], earlier: &[f64], lags: usize) -> Result<Vec<f64>, AnalysisError> {
    require_length("earlier series", earlier.len(), later.len())?;
    require_finite("later series", later)?;
    require_finite("earlier series", earlier)?;
    if lags > later.len() {
        let requirement = "at most the number of entries";
        return Err(AnalysisError::OutOfRange { name: "lags", value: lags as f64, requirement });
    }
    if lags == 0 {
        return Ok(Vec::new());
    }
    // Long enough that lag −(n − 1) doesn't meet lag `lags` − 1.
    let length = (later.len() + lags).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let failed = |_| AnalysisError::Underdetermined("the Fourier transform could not be taken");
    let spectrum = |series: &[f64]| {
        let mut padded = series.to_vec();
        padded.resize(length, 0.0);
        let mut spectrum = forward.make_output_vec();
        forward.process(&mut padded, &mut spectrum).map_err(failed)?;
        Ok(spectrum)
    };
    let mut product = spectrum(later)?;
    for (later, earlier) in product.iter_mut().zip(spectrum(earlier)?) {
        *later *= earlier.conj();
    }
    let mut sums = inverse.make_output_vec();
    inverse.process(&mut product, &mut sums).map_err(failed)?;
    let products = |lag: usize| (later.len() - lag) as f64;
    Ok(sums[..lags].iter().enumerate().map(|(lag, sum)| sum / length as f64 / products(lag)).collect())
}
