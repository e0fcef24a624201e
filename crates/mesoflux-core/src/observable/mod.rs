//! Instantaneous quantities, read from a system without changing its trajectory.

mod stress;
mod thermodynamics;

pub use stress::{BookedStress, Stress};
pub use thermodynamics::{ObservableError, Thermodynamics, check_configurational_temperature, check_pressure};
