//! Statistics of correlated series on plain arrays; knows nothing of the engine.
//!
//! Every result is an [`Estimate`]: a value, its standard error, the independent samples behind it, and warnings. It is never NaN:
//! where the data can't tell, the value is `None` and a warning says why. Accumulators take one sample at a time, merge
//! replicas, are serializable at any moment, and hold a bounded amount of memory.
//!
//! - [`Blocking`]: mean, ratios and functions of correlated series;
//! - [`MeanSquaredDisplacement`]: the curve and the diffusion coefficient;
//! - [`MultipleTau`], [`full_correlation`]: auto- and cross-correlations, their Green–Kubo integrals, Helfand slopes, correlation times;
//! - histograms ([`Histogram`]) of correlated series;
//! - [`fit_response`], [`fit_inverse_response`]: a transport coefficient from several points of a response curve;
//! - [`steady_state()`]: where a relaxing series has become steady;
//! - [`polynomial_functionals`]: extrapolations as functionals of a series;
//! - [`chi_squared_p_value`] and others: tests of distributions.
//!
//! ```
//! use mesoflux_analysis::{AnalysisError, Blocking};
//!
//! // A series in which every value remembers the previous one.
//! let mut pressure = Blocking::new(1)?;
//! let (mut value, mut random) = (0.0, 0.5);
//! for _ in 0..10_000 {
//!     random = 3.99 * random * (1.0 - random); // chaotic enough for an example
//!     value = 0.9 * value + 0.1 * random;
//!     pressure.record(&[value])?;
//! }
//! let estimate = pressure.estimate();
//! if let (Some(value), Some(error)) = (estimate.value, estimate.standard_error) {
//!     println!("pressure = {value:.4} ± {error:.4}");
//! }
//! assert!(estimate.interval(0.95).is_some());
//! # Ok::<(), AnalysisError>(())
//! ```

mod blocking;
mod correlation;
mod diffusion;
mod distribution;
mod error;
mod estimate;
mod fit;
mod functional;
mod histogram;
mod level;
mod mean_squared_displacement;
mod odd_polynomial;
mod plateau;
mod polynomial;
mod response_curve;
mod segments;
mod steady_state;

pub use blocking::Blocking;
pub use correlation::{
    AutocorrelationTime, CorrelationPoint, Integral, IntegralOptions, MultipleTau, Quadrature, full_correlation,
};
pub use diffusion::DiffusionEstimate;
pub use distribution::{
    ChiSquared, StandardNormalSummary, chi_squared_p_value, chi_squared_survival, chi_squared_test,
    kolmogorov_smirnov_p_value, maxwell_speed_cdf, normal_cdf, standard_normal_summary,
};
pub use error::AnalysisError;
pub use estimate::Estimate;
pub use functional::BlockingLevel;
pub use histogram::{Histogram, HistogramBin};
pub use mean_squared_displacement::MeanSquaredDisplacement;
pub use polynomial::polynomial_functionals;
pub use response_curve::{OrderChoice, ResponseCurve, ResponsePoint, fit_inverse_response, fit_response};
pub use steady_state::{SteadyState, steady_state};
