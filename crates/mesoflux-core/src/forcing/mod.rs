//! External forcings F(q) and the responses R = G(q)·p that belong to them: one file each, and their registry.

mod color_drift;
mod expression;
mod piecewise_constant;
mod piecewise_linear;
mod shear;
mod sinusoidal;
mod two_particle_drift;

pub use color_drift::ColorDrift;
pub use expression::{ExpressionForcing, ExpressionSource};
pub use piecewise_constant::PiecewiseConstant;
pub use piecewise_linear::PiecewiseLinear;
pub use shear::{Axis, Shear, ShearProfile, Wave};
pub use sinusoidal::Sinusoidal;
pub use two_particle_drift::TwoParticleDrift;

use crate::domain::Workers;
use crate::expression::ExpressionError;
use crate::lanes::Row;
use crate::state::Particles;
use crate::vector::{Vector, ZERO, add_scaled, dot};
use serde::{Deserialize, Serialize};

/// A forcing and its response.
pub trait Forcing: std::fmt::Debug + Send + Sync {
    /// The force F on the particle in place k at unit magnitude, and the response G of the same particle.
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2];
    /// Whether F or G change when positions do.
    fn depends_on_positions(&self) -> bool;
    /// Whether the forces on all particles sum to zero.
    fn is_balanced(&self) -> bool;
    /// (∇G p)·M⁻¹p of the particle in place k: how fast its part of the flux changes by free flight.
    fn response_drift(&self, _particles: &Particles, _k: usize) -> f64 {
        0.0
    }
    /// What forbids the forcing for N particles.
    ///
    /// # Errors
    /// The requirement that isn't met.
    fn check(&self, particles: usize) -> Result<(), ForcingError>;
}

/// A forcing that can't be applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ForcingError {
    /// Two colors need two equal halves.
    #[error("color drift needs an even number of particles, half of them pushed each way: the system has {0}")]
    OddParticles(usize),
    /// Too few particles.
    #[error("the forcing needs at least {needed} particles: the system has {found}")]
    TooFewParticles {
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// A force that changes along its own direction drives no shear flow.
    #[error("must be another axis than that of the flow")]
    FlowAlongGradient,
    /// A force without a wave is the same everywhere.
    #[error("must be at least 1")]
    NoWave,
    /// An expression that can't be used.
    #[error("{key}[{axis}]: {error}")]
    Expression {
        /// `force` or `response`.
        key: &'static str,
        /// Which component.
        axis: usize,
        /// What is wrong with it.
        error: Box<ExpressionError>,
    },
    /// A force or a response, `force` or `response`, without any component.
    #[error("must have a component that isn't zero")]
    Vanishing(&'static str),
    /// Nothing to control the flux with.
    #[error("F·G = {0}: must not be zero, or no magnitude of the forcing can hold the flux")]
    NoControl(f64),
}

/// The known forcings, by their names in the input file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForcingKind {
    /// Particles pushed to both sides by the parity of their ids.
    ColorDrift,
    /// The first two particles pushed apart.
    TwoParticleDrift,
    /// A force along the flow that is a sine along the gradient.
    Sinusoidal,
    /// A force that rises and falls linearly along the gradient.
    PiecewiseLinear,
    /// A force one way in one half of each wave, the other way in the other.
    PiecewiseConstant,
    /// Whatever the user types.
    Expression(ExpressionSource),
}

impl ForcingKind {
    /// |F₁| of eq. 88 for a forcing that drives a shear flow; none for others.
    pub fn first_coefficient(&self) -> Option<f64> {
        match self {
            Self::ColorDrift | Self::TwoParticleDrift | Self::Expression(_) => None,
            Self::Sinusoidal => Some(Sinusoidal::FIRST_COEFFICIENT),
            Self::PiecewiseLinear => Some(PiecewiseLinear::FIRST_COEFFICIENT),
            Self::PiecewiseConstant => Some(PiecewiseConstant::FIRST_COEFFICIENT),
        }
    }

    /// Whether it drives a shear flow.
    pub fn is_shear(&self) -> bool {
        self.first_coefficient().is_some()
    }
}

/// A forcing with all that it needs to be told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForcingChoice {
    /// Which.
    pub kind: ForcingKind,
    /// The directions and the length of a shear flow.
    pub wave: Wave,
    /// Whether the mean force is removed at every step, see [`ForcingField`].
    pub remove_mean_force: bool,
}

impl ForcingChoice {
    /// The forcing for a system of N particles in a box with these sides.
    ///
    /// # Errors
    /// A system for which the forcing is impossible.
    pub fn field(&self, particles: usize, sides: Vector) -> Result<ForcingField, ForcingError> {
        let forcing: Box<dyn Forcing> = match &self.kind {
            ForcingKind::ColorDrift => Box::new(ColorDrift),
            ForcingKind::TwoParticleDrift => Box::new(TwoParticleDrift),
            ForcingKind::Sinusoidal => Box::new(Shear::<Sinusoidal>::new(self.wave, sides, particles)),
            ForcingKind::PiecewiseLinear => Box::new(Shear::<PiecewiseLinear>::new(self.wave, sides, particles)),
            ForcingKind::PiecewiseConstant => Box::new(Shear::<PiecewiseConstant>::new(self.wave, sides, particles)),
            ForcingKind::Expression(source) => Box::new(ExpressionForcing::new(source, sides, particles)?),
        };
        forcing.check(particles)?;
        Ok(ForcingField { remove_mean_force: self.remove_mean_force, ..ForcingField::new(forcing) })
    }

    /// The number of the kind, and numbers that tell the forcing from all others of its kind.
    pub fn identity(&self) -> (u64, Vec<u64>) {
        let Wave { flow, gradient, waves } = self.wave;
        let mean = u64::from(self.remove_mean_force);
        let shear = vec![flow as u64, gradient as u64, waves.into(), mean];
        match &self.kind {
            ForcingKind::ColorDrift => (0, Vec::new()),
            ForcingKind::TwoParticleDrift => (1, Vec::new()),
            ForcingKind::Sinusoidal => (2, shear),
            ForcingKind::PiecewiseLinear => (3, shear),
            ForcingKind::PiecewiseConstant => (4, shear),
            ForcingKind::Expression(source) => (5, [vec![mean], source.identity()].concat()),
        }
    }
}

/// F, G and F·G at the present positions, in storage order.
///
/// A force on particles that move has a sum that fluctuates, even where it vanishes on average; without a momentum sink it makes the
/// whole box drift. Where the mean force is removed, F_i − (m_i/M)Σ_j F_j acts: what an observer sees who moves with the center
/// of mass.
#[derive(Debug)]
pub struct ForcingField {
    forcing: Box<dyn Forcing>,
    /// F.
    pub force: Vec<Vector>,
    /// G.
    pub response: Vec<Row>,
    /// F·G.
    pub control: f64,
    remove_mean_force: bool,
    layout: Option<u64>,
}

impl ForcingField {
    /// A field not yet evaluated, its mean force removed.
    pub fn new(forcing: Box<dyn Forcing>) -> Self {
        let (force, response) = (Vec::new(), Vec::new());
        Self { forcing, force, response, control: f64::NAN, remove_mean_force: true, layout: None }
    }

    /// Brings F, G and F·G up to date after the storage order (`layout`) or the positions (`moved`) changed.
    pub fn update(&mut self, particles: &Particles, layout: u64, moved: bool, workers: Workers) {
        if self.layout == Some(layout) && !(moved && self.forcing.depends_on_positions()) {
            return;
        }
        self.layout = Some(layout);
        let forcing = &self.forcing;
        self.force.resize(particles.count(), ZERO);
        self.response.resize(particles.count(), Row::default());
        workers.for_each_chunk_of_two(&mut self.force, &mut self.response, |offset, forces, responses| {
            for (k, (force, response)) in forces.iter_mut().zip(responses).enumerate() {
                let [f, g] = forcing.at(particles, offset + k);
                (*force, *response) = (f, Row::new(g, 0.0));
            }
        });
        if self.remove_mean_force && !self.forcing.is_balanced() {
            self.remove_mean(particles, workers);
        }
        self.control = workers.sum(particles.count(), |k| dot(self.force[k], self.response[k].vector()));
    }

    /// F_i −= (m_i/M) Σ_j F_j.
    fn remove_mean(&mut self, particles: &Particles, workers: Workers) {
        let mass = particles.total_mass(workers);
        let force = &self.force;
        let acceleration: Vector =
            std::array::from_fn(|axis| workers.sum(particles.count(), |k| force[k][axis]) / mass);
        workers.for_each_chunk(&mut self.force, |offset, forces| {
            for (k, force) in forces.iter_mut().enumerate() {
                add_scaled(force, -1.0 / particles.inverse_mass[offset + k], acceleration);
            }
        });
    }

    /// R = G·p.
    pub fn flux(&self, particles: &Particles, workers: Workers) -> f64 {
        workers.sum(particles.count(), |k| dot(self.response[k].vector(), particles.momentum[k]))
    }

    /// p += c F.
    pub fn push(&self, particles: &mut Particles, magnitude: f64, workers: Workers) {
        workers.for_each_chunk(&mut particles.momentum, |offset, momenta| {
            for (k, momentum) in momenta.iter_mut().enumerate() {
                add_scaled(momentum, magnitude, self.force[offset + k]);
            }
        });
    }

    /// The forcing.
    pub fn forcing(&self) -> &dyn Forcing {
        self.forcing.as_ref()
    }
}
