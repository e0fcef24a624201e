//! Groot and Warren's modified velocity Verlet, J. Chem. Phys. 107, 4423 (1997), eq. 17.

use crate::noise::{NoiseKey, Purpose};
use crate::pair::{PairNoise, velocity_dependent_forces};
use crate::state::{Column, Particles};
use crate::system::{SimulationError, System};
use crate::vector::{Vector, ZERO, add_scaled};
use serde::{Deserialize, Serialize};

/// q += Δt v + ½Δt² f/m; ṽ = v + λΔt f/m; f' = f(q', ṽ); v' = v + ½Δt (f + f')/m.
///
/// The force holds conservative, dissipative and random parts. Its temperature is wrong at order Δt and better:
/// about 1.4 % at Δt = 0.02 for Groot and Warren's fluid with λ = ½.
#[derive(Debug, Clone)]
pub struct VelocityVerlet {
    temperature: f64,
    lambda: f64,
    /// The force of the last step, and momenta halfway; they follow the particles through every reordering.
    columns: Option<Columns>,
    velocity: Vec<Vector>,
}

/// Where the scheme keeps its numbers between steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Columns {
    force: Column,
    predicted: Column,
}

impl Columns {
    /// Whether the particles have both of them.
    pub(crate) fn are_in(self, particles: &Particles) -> bool {
        self.force != self.predicted && particles.has_column(self.force) && particles.has_column(self.predicted)
    }
}

impl VelocityVerlet {
    /// The scheme for kT and λ.
    pub fn new(temperature: f64, lambda: f64) -> Self {
        Self { temperature, lambda, columns: None, velocity: Vec::new() }
    }

    /// The columns in use, once the first step is done.
    pub fn columns(&self) -> Option<Columns> {
        self.columns
    }

    /// Goes on with columns that came with a restored state.
    pub fn resume(&mut self, columns: Option<Columns>) {
        self.columns = columns;
    }

    /// One step.
    ///
    /// # Errors
    /// A state that is no longer finite.
    pub fn step(&mut self, system: &mut System, noise: NoiseKey, time_step: f64) -> Result<(), SimulationError> {
        let columns = match self.columns {
            Some(columns) => columns,
            None => self.start(system, noise, time_step),
        };
        let particles = &mut system.particles;
        for k in 0..particles.count() {
            let force = particles.column(columns.force)[k];
            let mut predicted = particles.momentum[k];
            add_scaled(&mut predicted, self.lambda * time_step, force);
            particles.column_mut(columns.predicted)[k] = predicted;
            add_scaled(&mut particles.momentum[k], 0.5 * time_step, force);
            let (w, p) = (particles.inverse_mass[k], particles.momentum[k]);
            add_scaled(&mut particles.position[k], time_step * w, p);
        }
        system.positions_moved()?;
        self.evaluate(system, noise, time_step, columns, system.step + 1);
        let particles = &mut system.particles;
        for k in 0..particles.count() {
            let force = particles.column(columns.force)[k];
            add_scaled(&mut particles.momentum[k], 0.5 * time_step, force);
        }
        Ok(())
    }

    fn start(&mut self, system: &mut System, noise: NoiseKey, time_step: f64) -> Columns {
        let columns =
            Columns { force: system.particles.register_column(), predicted: system.particles.register_column() };
        self.columns = Some(columns);
        let momentum = system.particles.momentum.clone();
        system.particles.column_mut(columns.predicted).clone_from(&momentum);
        self.evaluate(system, noise, time_step, columns, system.step);
        columns
    }

    /// The force at the present positions and predicted velocities, with the noise of the step at whose end it stands.
    fn evaluate(&mut self, system: &mut System, noise: NoiseKey, time_step: f64, columns: Columns, step: u64) {
        let workers = system.workers;
        let noise = PairNoise { temperature: self.temperature, time_step, draw: noise.draw(Purpose::Pair, step, 0) };
        let (list, interactions, particles) = system.with_contacts();
        self.velocity.resize(particles.count(), ZERO);
        for (k, velocity) in self.velocity.iter_mut().enumerate() {
            *velocity = particles.column(columns.predicted)[k].map(|p| p * particles.inverse_mass[k]);
        }
        let mut force = std::mem::take(particles.column_mut(columns.force));
        velocity_dependent_forces(list, interactions, particles, &self.velocity, &noise, &mut force, workers);
        system.add_bond_forces(&mut force);
        *system.particles.column_mut(columns.force) = force;
    }
}
