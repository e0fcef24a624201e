//! What the physics tests share: fluids, simulations, replicas on all cores, and how a statistical test is judged.
#![allow(dead_code, unused_imports, reason = "each test file uses its own part")]

pub mod naive;
mod scores;

pub use scores::{check_scores, probit, seeds};

use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::Driving;
use mesoflux_core::forcing::{Axis, ExpressionSource, ForcingChoice, ForcingKind, Wave};
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::friction::{Friction, linear::Linear};
use mesoflux_core::integrate::{Integrator, Langevin, Schedule, SweepOrder, Thermostat, VelocityVerlet};
use mesoflux_core::interactions::{Interactions, PairTable};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::lennard_jones::{LennardJones, Truncation};
use mesoflux_core::potential::soft::Soft;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{Start, deal_species, draw_momenta, positions};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO};
use rayon::prelude::*;

/// A fluid in a cubic box at kT = 1 with one potential and one friction for all pairs.
#[derive(Debug, Clone)]
pub struct Fluid {
    pub potential: Option<Potential>,
    pub friction: Linear,
    /// What the letter O stands for.
    pub thermostat: Thermostat,
    pub density: f64,
    /// Particles and mass of each species.
    pub species: Vec<(usize, f64)>,
    pub skin: f64,
}

/// The friction γ(1 − r/r_c)².
pub fn friction(coefficient: f64, cutoff: f64) -> Linear {
    Linear { coefficient, cutoff, exponent: 2.0 }
}

impl Fluid {
    /// Groot and Warren's: ρ = 3, a = 25, γ = 4.5, r_c = 1.
    pub fn groot_warren(count: usize) -> Self {
        Self {
            potential: Some(Potential::Soft(Soft { repulsion: 25.0, cutoff: 1.0 })),
            friction: friction(4.5, 1.0),
            thermostat: Thermostat::PairOrnsteinUhlenbeck,
            density: 3.0,
            species: vec![(count, 1.0)],
            skin: 0.3,
        }
    }

    /// No potential at all.
    pub fn ideal(count: usize, coefficient: f64) -> Self {
        Self { potential: None, friction: friction(coefficient, 1.0), ..Self::groot_warren(count) }
    }

    /// Wu and Shang's Lennard-Jones liquid: ρ = 0.85, r_c = 2.5, γ = 4.5.
    pub fn lennard_jones(count: usize) -> Self {
        Self {
            potential: Some(lennard_jones(2.5, Truncation::ForceShifted)),
            friction: friction(4.5, 2.5),
            density: 0.85,
            ..Self::groot_warren(count)
        }
    }

    /// The same fluid with several species that differ in mass alone.
    pub fn with_species(mut self, species: &[(usize, f64)]) -> Self {
        self.species = species.to_vec();
        self
    }

    /// The same fluid with the Langevin thermostat of a drag γ; the friction of its pairs then does nothing.
    pub fn with_langevin(mut self, friction: f64) -> Self {
        self.thermostat = Thermostat::Langevin(Langevin { friction });
        self
    }

    pub fn count(&self) -> usize {
        self.species.iter().map(|&(count, _)| count).sum()
    }

    /// On a cubic lattice, with Maxwell's momenta at `temperature`.
    pub fn system(&self, temperature: f64, noise: NoiseKey) -> System {
        let side = (self.count() as f64 / self.density).cbrt();
        let region = PeriodicBox::new([side; 3]).unwrap();
        let counts: Vec<usize> = self.species.iter().map(|&(count, _)| count).collect();
        let masses: Vec<f64> = self.species.iter().map(|&(_, mass)| mass).collect();
        let sites = positions(Start::CubicLattice, self.count(), &region, noise);
        let mut particles = Particles::at_rest(sites, deal_species(&counts, noise), &masses);
        draw_momenta(&mut particles, temperature, noise);
        let friction = Friction::Linear(self.friction);
        let interactions = interactions(&masses, |_, _| self.potential.clone(), |_, _| Some(friction.clone()));
        System::new(particles, region, interactions, self.skin, Workers::One).unwrap()
    }

    /// Runs a word at kT = 1 from the lattice on.
    pub fn simulation(&self, word: &str, driving: Option<Box<dyn Driving>>, noise: NoiseKey, dt: f64) -> Simulation {
        Simulation::new(self.system(1.0, noise), self.integrator(word), driving, noise, dt).unwrap()
    }

    /// A word at kT = 1 with the fluid's thermostat and alternating sweeps; without an O, at constant energy.
    pub fn integrator(&self, word: &str) -> Integrator {
        let thermostat = if word.contains('O') { self.thermostat } else { Thermostat::None };
        Integrator::Splitting(Schedule::new(word, thermostat, 1.0, SweepOrder::Alternating).unwrap())
    }
}

/// ε = σ = 1.
pub fn lennard_jones(cutoff: f64, truncation: Truncation) -> Potential {
    Potential::LennardJones(LennardJones { epsilon: 1.0, sigma: 1.0, cutoff, truncation })
}

/// Laws by pairs of species.
pub fn interactions(
    masses: &[f64],
    potential: impl FnMut(usize, usize) -> Option<Potential>,
    friction: impl FnMut(usize, usize) -> Option<Friction>,
) -> Interactions {
    let count = masses.len();
    Interactions {
        potentials: PairTable::from_fn(count, potential),
        frictions: PairTable::from_fn(count, friction),
        inverse_reduced_masses: PairTable::from_fn(count, |a, b| 1.0 / masses[a] + 1.0 / masses[b]),
    }
}

/// A word at kT = 1 with the pair thermostat and alternating sweeps; without an O, at constant energy.
pub fn splitting(word: &str) -> Integrator {
    Fluid::groot_warren(0).integrator(word)
}

/// Groot and Warren's scheme at kT = 1 with λ = ½.
pub fn velocity_verlet() -> Integrator {
    Integrator::VelocityVerlet(VelocityVerlet::new(1.0, 0.5, Correction::default()))
}

/// Takes steps until a time has passed.
pub fn advance(simulation: &mut Simulation, time: f64) {
    for _ in 0..(time / simulation.time_step()).round() as u64 {
        simulation.step().unwrap();
    }
}

/// A column of the particles in the order of their ids.
pub fn by_id<T: Copy + Default>(particles: &Particles, column: &[T]) -> Vec<T> {
    let mut ordered = vec![T::default(); column.len()];
    for (k, &value) in column.iter().enumerate() {
        ordered[particles.id[k] as usize] = value;
    }
    ordered
}

/// The positions in the order of their ids, followed through all crossings.
pub fn unwrapped(system: &System) -> Vec<Vector> {
    let mut positions = vec![ZERO; system.particles.count()];
    system.particles.unwrapped_positions(&system.region, &mut positions);
    positions
}

/// What `run(replica)` returns for 0 ≤ replica < `count`, worked out on all cores.
pub fn replicas<T: Send>(count: u64, run: impl Fn(u64) -> T + Sync) -> Vec<T> {
    (0..count as usize).into_par_iter().with_max_len(1).map(|replica| run(replica as u64)).collect()
}

/// A forcing; one that drives a shear flow pushes along x in one wave along y, its mean force removed.
pub fn forcing(kind: ForcingKind) -> ForcingChoice {
    ForcingChoice { kind, wave: Wave { flow: Axis::X, gradient: Axis::Y, waves: 1 }, remove_mean_force: true }
}

/// A force and a response by their components, the mean force removed.
pub fn typed(force: [&str; 3], response: [&str; 3]) -> ForcingChoice {
    let [force, response] = [force, response].map(|components| components.map(str::to_owned));
    forcing(ForcingKind::Expression(ExpressionSource { force, response, parameters: [].into() }))
}

/// A typed forcing whose response changes along all axes, unlike the force.
pub fn typed_in_all_directions() -> ForcingChoice {
    let wave = "sin(2*pi*(y/ly + z/lz))";
    typed(
        [wave, "color*cos(2*pi*z/lz)", "1.5*sin(2*pi*x/lx)"],
        [&format!("{wave}*(1 + cos(2*pi*x/lx)/2)/n"), "color*cos(2*pi*z/lz)/n", "sin(2*pi*x/lx)/n"],
    )
}
