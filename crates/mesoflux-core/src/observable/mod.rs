//! Instantaneous quantities, read from a system without changing its trajectory.

mod radial_distribution;
mod strain_rate;
mod stress;
mod stress_profile;
mod structure_factor;
mod thermodynamics;
mod transverse_current;

pub use radial_distribution::{RadialBins, pairs_of_species};
pub use strain_rate::{GradientSum, LocalGradients, Normalization, StrainRate, StrainRateError, VelocityGradient};
pub use stress::{BookedStress, Stress};
pub use stress_profile::StressProfile;
pub use structure_factor::{Shell, shells, structure_factors};
pub use thermodynamics::{ObservableError, Thermodynamics, check_configurational_temperature, check_pressure};
pub use transverse_current::{TRANSVERSE, TransverseCurrents};
