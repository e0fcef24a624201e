//! B: the impulse of the conservative forces.

use super::{Change, FluxChange, Letter, Stroke};
use crate::system::{SimulationError, System};
use crate::vector::add_scaled;

/// p += −t ∇U(q) (Wu & Shang, eqs 21, 26).
#[derive(Debug, Clone, Copy)]
pub struct Kick;

impl Letter for Kick {
    fn symbol(&self) -> char {
        'B'
    }

    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<Change, SimulationError> {
        system.update_forces();
        system.book_conservative(stroke.time);
        let multiplier = system.set_momenta(stroke.constraint.as_ref(), |system, k, mut momentum| {
            add_scaled(&mut momentum, stroke.time, system.forces()[k].vector());
            momentum
        });
        Ok(Change { flux: FluxChange::Determined, multiplier })
    }
}
