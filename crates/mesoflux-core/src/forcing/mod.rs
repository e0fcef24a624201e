//! External forcings F(q) and the responses R = G(q)·p that belong to them: one file each, and their registry.

mod color_drift;
mod two_particle_drift;

pub use color_drift::ColorDrift;
pub use two_particle_drift::TwoParticleDrift;

use crate::lanes::Row;
use crate::state::Particles;
use crate::vector::{Vector, ZERO, dot};
use serde::{Deserialize, Serialize};

/// A forcing and its response.
pub trait Forcing: std::fmt::Debug + Send + Sync {
    /// The normalized force on the particle in place k, in a system of N particles.
    fn force(&self, particles: &Particles, k: usize) -> Vector;
    /// The response G of the particle in place k.
    fn response(&self, particles: &Particles, k: usize) -> Vector;
    /// Whether F or G change when positions do.
    fn depends_on_positions(&self) -> bool;
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
    /// Nothing to control the flux with.
    #[error("F·G = {0}: must not be zero, or no magnitude of the forcing can hold the flux")]
    NoControl(f64),
}

/// Any of the known forcings, by its name in the input file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForcingKind {
    /// Particles pushed to both sides by the parity of their ids.
    ColorDrift,
    /// The first two particles pushed apart.
    TwoParticleDrift,
}

impl ForcingKind {
    /// The forcing for a system of N particles.
    ///
    /// # Errors
    /// A system for which the forcing is impossible.
    pub fn forcing(self, particles: usize) -> Result<Box<dyn Forcing>, ForcingError> {
        let forcing: Box<dyn Forcing> = match self {
            Self::ColorDrift => Box::new(ColorDrift),
            Self::TwoParticleDrift => Box::new(TwoParticleDrift),
        };
        forcing.check(particles)?;
        Ok(forcing)
    }
}

/// F, G and F·G at the present positions, in storage order.
#[derive(Debug)]
pub struct ForcingField {
    forcing: Box<dyn Forcing>,
    /// F.
    pub force: Vec<Vector>,
    /// G.
    pub response: Vec<Row>,
    /// F·G.
    pub control: f64,
    layout: Option<u64>,
}

impl ForcingField {
    /// A field not yet evaluated.
    pub fn new(forcing: Box<dyn Forcing>) -> Self {
        Self { forcing, force: Vec::new(), response: Vec::new(), control: f64::NAN, layout: None }
    }

    /// Brings F, G and F·G up to date after the storage order (`layout`) or the positions (`moved`) changed.
    pub fn update(&mut self, particles: &Particles, layout: u64, moved: bool, workers: crate::domain::Workers) {
        if self.layout == Some(layout) && !(moved && self.forcing.depends_on_positions()) {
            return;
        }
        self.layout = Some(layout);
        let forcing = &self.forcing;
        self.force.resize(particles.count(), ZERO);
        self.response.resize(particles.count(), Row::default());
        workers.for_each_chunk(&mut self.force, |offset, chunk| {
            chunk.iter_mut().enumerate().for_each(|(k, f)| *f = forcing.force(particles, offset + k));
        });
        workers.for_each_chunk(&mut self.response, |offset, chunk| {
            chunk.iter_mut().enumerate().for_each(|(k, g)| *g = Row::new(forcing.response(particles, offset + k), 0.0));
        });
        self.control = workers.sum(particles.count(), |k| dot(self.force[k], self.response[k].vector()));
    }

    /// R = G·p.
    pub fn flux(&self, particles: &Particles, workers: crate::domain::Workers) -> f64 {
        workers.sum(particles.count(), |k| dot(self.response[k].vector(), particles.momentum[k]))
    }

    /// The forcing.
    pub fn forcing(&self) -> &dyn Forcing {
        self.forcing.as_ref()
    }
}
