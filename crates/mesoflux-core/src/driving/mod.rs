//! Drivings: how a fluid is driven. After every letter, and at the end of every step, the driving may act on the momenta.

mod constant_flux;
mod constant_force;
mod momentum_exchange;

pub use constant_flux::{ConstantFlux, Projection};
pub use constant_force::ConstantForce;
pub use momentum_exchange::{Exchange, Exchanged, MomentumExchange, Slabs, mean_field_viscosity};

use crate::forcing::ForcingError;
use crate::integrate::{Change, Constraint, Schedule};
use crate::system::System;
use serde::{Deserialize, Serialize};

/// A way to drive a system out of equilibrium.
pub trait Driving: std::fmt::Debug + Send + Sync {
    /// Prepares the driving and the state before the first step.
    ///
    /// # Errors
    /// A forcing that cannot do what the driving needs.
    fn begin(&mut self, system: &mut System) -> Result<(), ForcingError>;

    /// Whether it acts between letters; one that acts between steps alone works with every integrator.
    fn needs_word(&self) -> bool {
        true
    }

    /// Acts before the letter `symbol`, which is about to take `time`.
    fn before_letter(&mut self, _system: &mut System, _symbol: char, _time: f64) {}

    /// The fixed flux, where there is one: letters must tell their expected change of it, and may restore it; for `system` before
    /// the letter.
    fn constraint(&mut self, _system: &System) -> Option<Constraint<'_>> {
        None
    }

    /// Acts after the letter `symbol`, which took `time` and did as told.
    fn after_letter(&mut self, system: &mut System, symbol: char, time: f64, change: Change);

    /// Acts between two steps, and tells flux and forcing of the one that has ended, if it has any.
    fn end_step(&mut self, system: &mut System, time_step: f64) -> Option<DrivenStep>;

    /// What was exchanged in and after the last step, by a driving that exchanges momentum.
    fn exchanged(&self) -> Option<Exchanged> {
        None
    }

    /// Whether every letter must tell the expected part of its change of the flux.
    fn needs_expected_flux(&self) -> bool {
        false
    }

    /// What the driving remembers from step to step, for the checkpoint.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes over what `memory` gave; false if it can't be.
    fn remember(&mut self, memory: &[f64]) -> bool {
        memory.is_empty()
    }

    /// λ(q, p) of Wu & Shang's eq. 13 at the present state: what the booked multipliers average to as Δt → 0; the friction is that
    /// of the letters.
    ///
    /// `None` for a driving with constant force.
    fn forcing_observable(&mut self, _system: &mut System, _schedule: &Schedule) -> Option<f64> {
        None
    }
}

/// Flux and forcing of one step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DrivenStep {
    /// R = G·p at the end of the step.
    pub flux: f64,
    /// η, or the mean λ of the step.
    pub forcing: f64,
}
