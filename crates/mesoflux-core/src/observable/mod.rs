//! Instantaneous quantities, read from a system without changing its trajectory.

mod thermodynamics;

pub use thermodynamics::{ObservableError, Thermodynamics, check_configurational_temperature, check_pressure};
