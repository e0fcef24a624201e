//! The pair loop: contacts found once a position, and the kernels that visit them.

mod conservative;
mod contacts;
mod dissipation;
mod factors;
mod fused;
mod groups;
mod measure;
mod scatter;
mod separations;
mod stress;
mod thermostat;
mod velocity_dependent_thermostat;

/// The name of the kernels' arithmetic. All sets of vector instructions give the same bits, so that there is one name for all.
pub const KERNEL: &str = "eight streams, 2";

pub use conservative::conservative_forces;
pub use contacts::Contacts;
pub(crate) use contacts::PairLaw;
pub use dissipation::PairNoise;
pub use fused::velocity_dependent_forces;
pub use measure::{PairSums, dissipative_flux, pair_sums};
pub use stress::{PairStress, pair_stress};
pub use thermostat::{Sweep, SweepSums, thermostat_sweep};
