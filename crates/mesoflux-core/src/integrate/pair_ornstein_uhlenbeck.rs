//! O: the pair thermostat, exact pair by pair.

use super::{Change, FluxChange, Letter, Stroke};
use crate::lanes::Row;
use crate::noise::Purpose;
use crate::pair::{Sweep, dissipative_flux};
use crate::system::{SimulationError, System};

/// Every pair's relative velocity along its line of centers follows its Ornstein–Uhlenbeck process over the time t, one pair
/// after the other (Wu & Shang, eqs 22, 27–29).
///
/// Each update leaves the Maxwell distribution invariant whatever the time step, and so does the sweep in any order.
#[derive(Debug, Clone, Copy)]
pub struct PairOrnsteinUhlenbeck {
    /// kT.
    pub temperature: f64,
}

impl Letter for PairOrnsteinUhlenbeck {
    fn symbol(&self) -> char {
        'O'
    }

    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<Change, SimulationError> {
        let sweep = Sweep {
            temperature: self.temperature,
            time: stroke.time,
            noise: stroke.noise.draw(Purpose::Pair, system.step, stroke.place),
            acceptance: stroke.noise.draw(Purpose::Acceptance, system.step, stroke.place),
            backward: stroke.backward,
            response: stroke.response,
            book_stress: system.booked.is_some(),
        };
        let (expected, multiplier) = system.sweep(&sweep, stroke.constraint.as_ref());
        Ok(Change { flux: FluxChange::Expected(expected), multiplier })
    }

    fn dissipative_flux(&self, system: &mut System, response: &[Row]) -> f64 {
        let workers = system.workers;
        let (list, interactions, particles) = system.with_contacts();
        dissipative_flux(list, interactions, particles, response, self.temperature, workers)
    }
}
