//! The explicit scheme of Naseri, Salueña and Bonet Avalos, Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 4–5.

use crate::friction::fluctuation_dissipation::Correction;
use crate::noise::{NoiseKey, Purpose};
use crate::pair::PairNoise;
use crate::system::{SimulationError, System};

/// q' = q + Δt p/m; p' = p + Δt (F^C + F^D) + δp^R, all at the state before the step.
///
/// Of first order: an ideal fluid's temperature is kT/(1 − ½aΔt), a the rate at which friction alone makes a velocity decay. It is
/// here to reproduce what was published; the letter O has no such error.
#[derive(Debug, Clone)]
pub struct Explicit {
    temperature: f64,
    correction: Correction,
}

impl Explicit {
    /// The scheme for kT.
    pub fn new(temperature: f64, correction: Correction) -> Self {
        Self { temperature, correction }
    }

    /// kT.
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is no longer finite.
    pub fn step(&self, system: &mut System, noise: NoiseKey, time_step: f64) -> Result<(), SimulationError> {
        let draw = noise.draw(Purpose::Pair, system.step, 0);
        let noise = PairNoise { temperature: self.temperature, time_step, draw, correction: self.correction };
        system.with_velocities(|system, velocity| {
            if system.booked.is_some() {
                let stress = system.pair_stress_of(Some(velocity), Some(&noise));
                system.book_flight(time_step);
                if let Some(booked) = &mut system.booked {
                    booked.conservative += time_step * stress.conservative;
                    booked.dissipative += time_step * stress.dissipative;
                    booked.random += time_step * stress.random;
                }
            }
            system.velocity_dependent_forces(velocity, &noise);
            system.kick_and_fly(velocity, time_step);
        });
        system.positions_moved()
    }
}
