//! What stands first in the state of every run: enough to tell what it is and to start another run from it.

use crate::checkpoint::StateReader;
use mesoflux_core::pair::KERNEL;
use serde::Serialize;

/// The version of the layout of a state.
const LAYOUT: u32 = 4;

/// Read before the rest, its fields in this order. What follows it is the simulation's snapshot, then the recorders.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Head {
    layout: u32,
    /// The set of kernels that computed it: another one may go on to other bits.
    pub kernel: String,
    /// How many steps the run has done.
    pub steps: u64,
    /// The names of the species.
    pub species: Vec<String>,
    /// The names of the kinds of bonds.
    pub bonds: Vec<String>,
}

impl Head {
    /// The head of a state of this version of the program.
    pub fn new(steps: u64, species: Vec<String>, bonds: Vec<String>) -> Self {
        Self { layout: LAYOUT, kernel: KERNEL.to_owned(), steps, species, bonds }
    }

    /// Reads the head of a state, which stands first in it.
    ///
    /// # Errors
    /// A state of another version of the program, or none.
    pub fn read(state: &mut StateReader) -> Result<Self, String> {
        let unreadable = |error| format!("has a head that can't be read: {error}");
        let layout = state.next_value().map_err(unreadable)?;
        if layout != LAYOUT {
            return Err(format!("has the layout {layout}: must have {LAYOUT}, that of this version of the program"));
        }
        let (kernel, steps, species, bonds) = state.next_value().map_err(unreadable)?;
        Ok(Self { layout, kernel, steps, species, bonds })
    }
}
