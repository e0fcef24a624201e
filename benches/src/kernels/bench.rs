//! One call of each kernel on a fluid at equilibrium.

use super::noise;
use mesoflux_core::domain::Workers;
use mesoflux_core::neighbors::NeighborList;
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::pair::{PairNoise, Sweep, conservative_forces, ornstein_uhlenbeck_sweep, velocity_dependent_forces};
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO};

/// A kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kernel {
    /// Sorting the particles by cell and listing their pairs.
    List,
    /// Finding the listed pairs within the cutoff.
    Contacts,
    /// Conservative forces.
    ConservativeForces,
    /// Conservative, dissipative and random forces in one pass.
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
            Self::List => "sorting and building the list",
            Self::Contacts => "finding contacts",
            Self::ConservativeForces => "conservative forces",
            Self::FusedForces => "all forces with noise",
            Self::Sweep => "thermostat's sweep",
            Self::Noise => "pair noise alone",
        }
    }
}

/// A fluid at equilibrium and room for what the kernels yield.
pub struct Bench {
    system: System,
    list: NeighborList,
    velocity: Vec<Vector>,
    force: Vec<Vector>,
    pairs: noise::Pairs,
    key: NoiseKey,
    calls: u64,
}

impl Bench {
    /// The kernels will work on this system.
    pub fn new(mut system: System) -> Self {
        let list = system.contacts().clone();
        let count: usize = list.bricks().iter().map(|brick| brick.contacts.count()).sum();
        let velocity = (0..system.particles.count()).map(|k| system.particles.velocity(k)).collect();
        let force = vec![ZERO; system.particles.count()];
        let pairs = noise::Pairs::new(system.particles.count(), count);
        Self { system, list, velocity, force, pairs, key: NoiseKey::new(&[1]), calls: 0 }
    }

    /// Pairs within the cutoff.
    pub fn pairs(&self) -> usize {
        self.pairs.count()
    }

    /// Brings the contacts up to date with the list, as all kernels but the first two expect them.
    pub fn prepare(&mut self) {
        self.list.update_contacts(&self.system.particles, Workers::One);
    }

    /// Runs a kernel once over all pairs. The thermostat's sweep leaves its momenta behind, nothing else changes the state.
    pub fn call(&mut self, kernel: Kernel) {
        self.calls += 1;
        let draw = self.key.draw(Purpose::Pair, self.calls, 0);
        let Self { system, list, velocity, force, pairs, .. } = self;
        let (interactions, workers) = (&system.interactions, Workers::One);
        let (temperature, time_step) = (1.0, 0.01);
        match kernel {
            Kernel::List => list.build(&mut system.particles, &system.region, None, workers),
            Kernel::Contacts => list.update_contacts(&system.particles, workers),
            Kernel::ConservativeForces => conservative_forces(list, interactions, force, workers),
            Kernel::FusedForces => {
                let noise = PairNoise { temperature, time_step, draw };
                velocity_dependent_forces(list, interactions, &system.particles, velocity, &noise, force, workers);
            }
            Kernel::Sweep => {
                let backward = self.calls % 2 == 1;
                let sweep = Sweep { temperature, time: time_step, noise: draw, backward, response: None };
                ornstein_uhlenbeck_sweep(list, interactions, &mut system.particles, &sweep, workers);
            }
            Kernel::Noise => pairs.draw(draw),
        }
        std::hint::black_box(&self.force);
    }
}
