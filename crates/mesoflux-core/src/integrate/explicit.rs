//! The explicit scheme of Naseri, Salueña and Bonet Avalos, Phys. Chem. Chem. Phys. 27, 190 (2025), eqs 4–5.

use crate::friction::fluctuation_dissipation::Correction;
use crate::lanes::Row;
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
    velocity: Vec<Row>,
}

impl Explicit {
    /// The scheme for kT.
    pub fn new(temperature: f64, correction: Correction) -> Self {
        Self { temperature, correction, velocity: Vec::new() }
    }

    /// kT.
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is no longer finite.
    pub fn step(&mut self, system: &mut System, noise: NoiseKey, time_step: f64) -> Result<(), SimulationError> {
        let workers = system.workers;
        let draw = noise.draw(Purpose::Pair, system.step, 0);
        let noise = PairNoise { temperature: self.temperature, time_step, draw, correction: self.correction };
        let particles = &system.particles;
        self.velocity.resize(particles.count(), Row::default());
        workers.for_each_chunk(&mut self.velocity, |offset, velocities| {
            for (k, velocity) in velocities.iter_mut().enumerate() {
                *velocity = Row::new(particles.velocity(offset + k), 0.0);
            }
        });
        if system.booked.is_some() {
            let stress = system.pair_stress_of(Some(&self.velocity), Some(&noise));
            system.book_flight(time_step);
            if let Some(booked) = &mut system.booked {
                booked.conservative += time_step * stress.conservative;
                booked.dissipative += time_step * stress.dissipative;
                booked.random += time_step * stress.random;
            }
        }
        system.velocity_dependent_forces(&self.velocity, &noise);
        system.kick_and_fly(&self.velocity, time_step);
        system.positions_moved()
    }
}
