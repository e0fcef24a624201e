//! The pair loop: contacts found once a position, and the kernels that visit them.

mod conservative;
mod contacts;
mod fused;
mod measure;
mod scatter;
mod thermostat;

pub use conservative::conservative_forces;
pub use contacts::Contacts;
pub use fused::{PairNoise, velocity_dependent_forces};
pub use measure::{PairSums, dissipative_flux, pair_sums};
pub use thermostat::{Sweep, ornstein_uhlenbeck_sweep};
