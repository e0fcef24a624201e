//! Boundaries of the simulated region: what a particle's images are, in position and in velocity.

mod periodic;

pub use periodic::{BoxError, PeriodicBox};
