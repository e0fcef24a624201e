//! Auto- and cross-correlations: streaming and by FFT, their integrals with calibrated errors, Helfand slopes, correlation times.

mod cutoff;
mod evaluation;
mod full;
mod integral;
mod multiple_tau;
mod sums;
mod time;

pub use full::full_correlation;
pub use integral::{CorrelationPoint, Integral, IntegralOptions, Quadrature};
pub use multiple_tau::MultipleTau;
pub use time::AutocorrelationTime;

/// Lags a level, in its blocks.
const LAGS: usize = 16;
/// Lags of this number of blocks or more are kept above level 0: shorter ones are resolved by the level below.
const FIRST_LAG: usize = LAGS / 2;
