//! A: free flight.

use super::{Change, FluxChange, Letter, Stroke};
use crate::system::{SimulationError, System};
use crate::vector::add_scaled;

/// q += t p/m (Wu & Shang, eqs 20, 25).
#[derive(Debug, Clone, Copy)]
pub struct Drift;

impl Letter for Drift {
    fn symbol(&self) -> char {
        'A'
    }

    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<Change, SimulationError> {
        system.book_flight(stroke.time);
        let particles = &mut system.particles;
        let (momentum, inverse_mass) = (&particles.momentum, &particles.inverse_mass);
        system.workers.for_each_chunk(&mut particles.position, |offset, positions| {
            for (k, position) in positions.iter_mut().enumerate() {
                add_scaled(position, stroke.time * inverse_mass[offset + k], momentum[offset + k]);
            }
        });
        system.positions_moved()?;
        Ok(Change { flux: FluxChange::Determined, multiplier: None })
    }
}
