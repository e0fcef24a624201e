//! B: the impulse of the conservative forces.

use super::{FluxChange, Letter, Stroke};
use crate::system::{SimulationError, System};
use crate::vector::add_scaled;

/// p += −t ∇U(q) (Wu & Shang, eqs 21, 26).
#[derive(Debug, Clone, Copy)]
pub struct Kick;

impl Letter for Kick {
    fn symbol(&self) -> char {
        'B'
    }

    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<FluxChange, SimulationError> {
        system.update_forces();
        let workers = system.workers;
        let mut momenta = std::mem::take(&mut system.particles.momentum);
        let force = system.forces();
        workers.for_each_chunk(&mut momenta, |offset, momenta| {
            for (k, momentum) in momenta.iter_mut().enumerate() {
                add_scaled(momentum, stroke.time, force[offset + k].vector());
            }
        });
        system.particles.momentum = momenta;
        Ok(FluxChange::Determined)
    }
}
