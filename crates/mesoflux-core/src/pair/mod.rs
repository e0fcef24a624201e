//! The pair loop: contacts found once a position, and the kernels that visit them.

mod conservative;
mod contacts;
mod fused;
mod instruction_set;
mod measure;
mod scatter;
mod thermostat;

/// The name of the set of kernels. All sets give the same bits where they are named alike.
pub const KERNEL: &str = "portable";

pub use conservative::conservative_forces;
pub use contacts::Contacts;
pub use fused::{PairNoise, velocity_dependent_forces};
pub use instruction_set::InstructionSet;
pub(crate) use instruction_set::Kernel;
pub use measure::{PairSums, dissipative_flux, pair_sums};
pub use thermostat::{Sweep, ornstein_uhlenbeck_sweep};
