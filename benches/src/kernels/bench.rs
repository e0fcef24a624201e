//! One call of each kernel on a fluid at equilibrium.

use mesoflux_core::domain::Workers;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::lanes::Row;
use mesoflux_core::neighbors::NeighborList;
use mesoflux_core::noise::{NoiseKey, Purpose, pair_gaussians};
use mesoflux_core::pair::{PairNoise, Sweep, conservative_forces, thermostat_sweep, velocity_dependent_forces};
use mesoflux_core::system::System;

/// A kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kernel {
    /// Sorting the particles by cell.
    List,
    /// Finding the pairs within the cutoff.
    Contacts,
    /// Conservative forces.
    ConservativeForces,
    /// Finding the pairs, and conservative, dissipative and random forces in one pass.
    FusedForces,
    /// The thermostat's sweep.
    Sweep,
    /// The Gaussian of each pair, and nothing else.
    Noise,
}

impl Kernel {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::List, Self::Contacts, Self::ConservativeForces, Self::FusedForces, Self::Sweep, Self::Noise];

    /// What it is called in the results.
    pub fn name(self) -> &'static str {
        match self {
            Self::List => "sorting the particles",
            Self::Contacts => "finding contacts",
            Self::ConservativeForces => "conservative forces",
            Self::FusedForces => "contacts and all forces with noise",
            Self::Sweep => "thermostat's sweep",
            Self::Noise => "pair noise alone",
        }
    }
}

/// A fluid at equilibrium and room for what the kernels yield.
pub struct Bench {
    system: System,
    list: NeighborList,
    velocity: Vec<Row>,
    force: Vec<Row>,
    /// The ids of all pairs, and what they draw.
    pairs: Vec<[u64; 2]>,
    gaussians: Vec<f64>,
    key: NoiseKey,
    calls: u64,
}

impl Bench {
    /// The kernels will work on this system.
    pub fn new(mut system: System) -> Self {
        let list = system.contacts().clone();
        let id = &system.particles.id;
        let ids =
            list.contacts().flat_map(|contacts| (0..contacts.count()).map(|k| contacts.pair(k).map(|place| id[place])));
        let pairs: Vec<[u64; 2]> = ids.collect();
        let velocity = (0..id.len()).map(|k| Row::new(system.particles.velocity(k), 0.0)).collect();
        let force = vec![Row::default(); id.len()];
        Self { system, list, velocity, force, pairs, gaussians: Vec::new(), key: NoiseKey::new(&[1]), calls: 0 }
    }

    /// Pairs within the cutoff.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Brings the contacts up to date with the list, as all kernels but the first two expect them.
    pub fn prepare(&mut self) {
        self.list.update_contacts(&self.system.particles, None, Workers::One);
    }

    /// Runs a kernel once over all pairs. The thermostat's sweep leaves its velocities behind, nothing else changes the state.
    pub fn call(&mut self, kernel: Kernel) {
        self.calls += 1;
        let draw = self.key.draw(Purpose::Pair, self.calls, 0);
        let Self { system, list, velocity, force, pairs, gaussians, .. } = self;
        let (interactions, workers) = (&system.interactions, Workers::One);
        let (temperature, time_step) = (1.0, 0.01);
        match kernel {
            Kernel::List => list.build(&mut system.particles, None, workers),
            Kernel::Contacts => list.update_contacts(&system.particles, None, workers),
            Kernel::ConservativeForces => conservative_forces(list, interactions, force, workers),
            Kernel::FusedForces => {
                let noise = PairNoise { temperature, time_step, draw, correction: Correction::default() };
                velocity_dependent_forces(
                    list,
                    interactions,
                    &system.particles,
                    None,
                    velocity,
                    &noise,
                    force,
                    workers,
                );
            }
            Kernel::Sweep => {
                let backward = self.calls % 2 == 1;
                let sweep = Sweep {
                    temperature,
                    time: time_step,
                    noise: draw,
                    acceptance: draw,
                    backward,
                    response: None,
                    book_stress: false,
                };
                thermostat_sweep(list, interactions, &system.particles, velocity, &sweep, workers);
            }
            Kernel::Noise => pair_gaussians(draw, pairs, gaussians),
        }
        std::hint::black_box(&self.force);
    }
}
