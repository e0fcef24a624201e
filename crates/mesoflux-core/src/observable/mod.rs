//! Instantaneous quantities, read from a system without changing its trajectory.

mod stress;
mod stress_profile;
mod thermodynamics;
mod transverse_current;

pub use stress::{BookedStress, Stress};
pub use stress_profile::StressProfile;
pub use thermodynamics::{ObservableError, Thermodynamics, check_configurational_temperature, check_pressure};
pub use transverse_current::{TRANSVERSE, TransverseCurrents};
