//! Integrators: letters, the words made of them, and velocity Verlet.

mod drift;
mod explicit;
mod kick;
mod langevin;
mod pair_ornstein_uhlenbeck;
mod splitting;
mod velocity_verlet;

pub use drift::Drift;
pub use explicit::Explicit;
pub use kick::Kick;
pub use langevin::{Langevin, ParticleOrnsteinUhlenbeck};
pub use pair_ornstein_uhlenbeck::PairOrnsteinUhlenbeck;
pub use splitting::{Schedule, WordError};
pub use velocity_verlet::VelocityVerlet;

use crate::lanes::Row;
use crate::noise::NoiseKey;
use crate::system::{SimulationError, System};
use crate::vector::Vector;
use serde::{Deserialize, Serialize};

/// What a letter is told: how long it acts, and whence its noise.
#[derive(Debug, Clone, Copy)]
pub struct Stroke<'a> {
    /// The time over which the letter acts.
    pub time: f64,
    /// The letter's place in its word.
    pub place: u64,
    /// The run's noise.
    pub noise: NoiseKey,
    /// Whether this step's sweeps go from the last pair to the first.
    pub backward: bool,
    /// G of every particle in storage order, where a driving follows the flux G·p.
    pub response: Option<&'a [Row]>,
    /// Where the momenta must stay on a fixed flux: a letter that changes them in one last pass may project them in it.
    pub constraint: Option<Constraint<'a>>,
}

/// G·p = r, restored along F.
#[derive(Debug, Clone, Copy)]
pub struct Constraint<'a> {
    /// F, in storage order.
    pub force: &'a [Vector],
    /// G, in storage order.
    pub response: &'a [Row],
    /// F·G.
    pub control: f64,
    /// r.
    pub flux: f64,
}

/// What a letter did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// To the flux G·p, before any projection.
    pub flux: FluxChange,
    /// ξ, where it projected the momenta itself.
    pub multiplier: Option<f64>,
}

/// What a letter did to the flux G·p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FluxChange {
    /// All of it was determined by the state: the driving books all of it.
    Determined,
    /// The letter drew noise; this is the part expected given the state before each pair, the rest is a martingale.
    Expected(f64),
}

/// One part of the splitting: a map of the state over a time.
pub trait Letter: std::fmt::Debug + Send + Sync {
    /// Its symbol in a word.
    fn symbol(&self) -> char;
    /// Acts on the system.
    ///
    /// # Errors
    /// A state that is no longer finite.
    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<Change, SimulationError>;
    /// Whether the letter can tell the expected part of its change of a flux; without that, constant flux is refused.
    fn tells_expected_flux(&self) -> bool {
        true
    }
    /// Whether it leaves the total momentum as it was.
    fn conserves_momentum(&self) -> bool {
        true
    }
    /// G·(the friction force that it stands for) at the present state, for a response G in storage order.
    fn dissipative_flux(&self, _system: &mut System, _response: &[Row]) -> f64 {
        0.0
    }
}

/// Which thermostat the letter O stands for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Thermostat {
    /// The exact update of each pair in turn.
    PairOrnsteinUhlenbeck,
    /// The exact update of each particle by drag and noise of a bath: momentum is not conserved.
    Langevin(Langevin),
    /// None: constant energy.
    None,
}

/// In which direction the pairs are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SweepOrder {
    /// Forward at even steps, backward at odd ones.
    #[default]
    Alternating,
    /// Always forward: the form of the papers.
    Forward,
}

/// How time goes on.
#[derive(Debug)]
pub enum Integrator {
    /// A word of letters.
    Splitting(Schedule),
    /// Groot and Warren's velocity Verlet.
    VelocityVerlet(VelocityVerlet),
    /// The explicit scheme.
    Explicit(Explicit),
}

impl Integrator {
    /// Whether it leaves the total momentum as it was, but for external fields.
    pub fn conserves_momentum(&self) -> bool {
        match self {
            Self::Splitting(schedule) => schedule.entries().iter().all(|(letter, _)| letter.conserves_momentum()),
            Self::VelocityVerlet(_) | Self::Explicit(_) => true,
        }
    }

    /// kT of its noise.
    pub fn temperature(&self) -> f64 {
        match self {
            Self::Splitting(schedule) => schedule.temperature(),
            Self::VelocityVerlet(scheme) => scheme.temperature(),
            Self::Explicit(scheme) => scheme.temperature(),
        }
    }
}
