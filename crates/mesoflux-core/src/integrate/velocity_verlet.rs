//! Groot and Warren's modified velocity Verlet, J. Chem. Phys. 107, 4423 (1997), eq. 17.

use crate::friction::fluctuation_dissipation::Correction;
use crate::lanes::Row;
use crate::noise::{NoiseKey, Purpose};
use crate::pair::{PairNoise, PairStress};
use crate::state::Column;
use crate::system::{SimulationError, System};
use crate::vector::add_scaled;

/// q += Δt v + ½Δt² f/m; ṽ = v + λΔt f/m; f' = f(q', ṽ); v' = v + ½Δt (f + f')/m.
///
/// The force holds conservative, dissipative and random parts. Its temperature is wrong at order Δt and better:
/// about 1.4 % at Δt = 0.02 for Groot and Warren's fluid with λ = ½.
#[derive(Debug, Clone)]
pub struct VelocityVerlet {
    temperature: f64,
    lambda: f64,
    correction: Correction,
    /// The force of the last step, which follows the particles through every reordering.
    force: Option<Column>,
    /// The stress of that force, where it is booked.
    stress: Option<PairStress>,
    velocity: Vec<Row>,
}

impl VelocityVerlet {
    /// The scheme for kT and λ.
    pub fn new(temperature: f64, lambda: f64, correction: Correction) -> Self {
        Self { temperature, lambda, correction, force: None, stress: None, velocity: Vec::new() }
    }

    /// kT.
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// Where the scheme keeps its forces, once the first step is done.
    pub fn force_column(&self) -> Option<Column> {
        self.force
    }

    /// The stress of these forces, if the last step booked it.
    pub fn force_stress(&self) -> Option<PairStress> {
        self.stress
    }

    /// Goes on with a column, and its stress, that came with a restored state.
    pub fn resume(&mut self, force: Option<Column>, stress: Option<PairStress>) {
        (self.force, self.stress) = (force, stress);
    }

    /// One step.
    ///
    /// It is a kick by ½Δt f, a free flight and a kick by ½Δt f': each kick books the stress of its force, the flight that of the
    /// momenta between them. Where the stress of f isn't known, because nothing was booked when f was worked out, the step
    /// books nothing.
    ///
    /// # Errors
    /// A state that is no longer finite.
    pub fn step(&mut self, system: &mut System, noise: NoiseKey, time_step: f64) -> Result<(), SimulationError> {
        let workers = system.workers;
        let column = match self.force {
            Some(column) => column,
            None => self.start(system, noise, time_step),
        };
        let stress_known = self.stress.is_some();
        let particles = &mut system.particles;
        let force = std::mem::take(particles.column_mut(column));
        let (half, inverse_mass) = (0.5 * time_step, &particles.inverse_mass);
        workers.for_each_chunk_of_two(
            &mut particles.position,
            &mut particles.momentum,
            |offset, positions, momenta| {
                let columns = force[offset..].iter().zip(&inverse_mass[offset..]);
                for ((position, momentum), (&force, &inverse_mass)) in positions.iter_mut().zip(momenta).zip(columns) {
                    add_scaled(momentum, half, force);
                    add_scaled(position, time_step * inverse_mass, *momentum);
                }
            },
        );
        *particles.column_mut(column) = force;
        self.book_kick(system, half);
        system.book_flight(time_step);
        system.positions_moved()?;
        self.evaluate(system, noise, time_step, column, (self.lambda - 0.5) * time_step, system.step + 1);
        let particles = &mut system.particles;
        let force = &particles.columns[column.index()];
        workers.for_each_chunk(&mut particles.momentum, |offset, momenta| {
            for (momentum, &force) in momenta.iter_mut().zip(&force[offset..]) {
                add_scaled(momentum, half, force);
            }
        });
        self.book_kick(system, half);
        if !stress_known {
            system.booked = None;
        }
        Ok(())
    }

    /// Books the flux of the force over a time, where fluxes are booked.
    fn book_kick(&self, system: &mut System, time: f64) {
        if let (Some(booked), Some(stress)) = (&mut system.booked, self.stress) {
            booked.conservative += time * stress.conservative;
            booked.dissipative += time * stress.dissipative;
            booked.random += time * stress.random;
        }
    }

    fn start(&mut self, system: &mut System, noise: NoiseKey, time_step: f64) -> Column {
        let column = system.particles.register_column();
        self.force = Some(column);
        self.evaluate(system, noise, time_step, column, 0.0, system.step);
        column
    }

    /// The force at the present positions and the velocities (p + t f)/m, with the noise of the step at whose end it stands.
    fn evaluate(&mut self, system: &mut System, noise: NoiseKey, time_step: f64, column: Column, t: f64, step: u64) {
        let workers = system.workers;
        let draw = noise.draw(Purpose::Pair, step, 0);
        let noise = PairNoise { temperature: self.temperature, time_step, draw, correction: self.correction };
        let (particles, force) = (&system.particles, system.particles.column(column));
        self.velocity.resize(particles.count(), Row::default());
        workers.for_each_chunk(&mut self.velocity, |offset, velocities| {
            for (k, velocity) in velocities.iter_mut().enumerate() {
                let mut predicted = particles.momentum[offset + k];
                add_scaled(&mut predicted, t, force[offset + k]);
                *velocity = Row::new(predicted.map(|p| p * particles.inverse_mass[offset + k]), 0.0);
            }
        });
        let mut force = std::mem::take(system.particles.column_mut(column));
        let rows = system.velocity_dependent_forces(&self.velocity, &noise);
        workers.for_each_chunk(&mut force, |offset, forces| {
            for (force, row) in forces.iter_mut().zip(&rows[offset..]) {
                *force = row.vector();
            }
        });
        *system.particles.column_mut(column) = force;
        self.stress = system.booked.is_some().then(|| system.pair_stress_of(Some(&self.velocity), Some(&noise)));
    }
}
