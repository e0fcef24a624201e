//! Nonequilibrium molecular dynamics: a constant magnitude η of the forcing, the flux answers (Wu & Shang, eq. 6).

use super::{DrivenStep, Driving};
use crate::forcing::{ForcingError, ForcingField};
use crate::integrate::Change;
use crate::system::System;

/// Adds η F(q) to the conservative force in every kick.
#[derive(Debug)]
pub struct ConstantForce {
    magnitude: f64,
    field: ForcingField,
}

impl ConstantForce {
    /// The driving by η F.
    pub fn new(field: ForcingField, magnitude: f64) -> Self {
        Self { magnitude, field }
    }
}

impl Driving for ConstantForce {
    fn begin(&mut self, system: &mut System) -> Result<(), ForcingError> {
        self.field.forcing().check(system.particles.count())?;
        self.field.update(&system.particles, system.layout(), true, system.workers);
        Ok(())
    }

    fn after_letter(&mut self, system: &mut System, symbol: char, time: f64, _change: Change) {
        if symbol == 'B' {
            self.field.update(&system.particles, system.layout(), true, system.workers);
            self.field.push(&mut system.particles, time * self.magnitude, system.workers);
        }
    }

    fn end_step(&mut self, system: &mut System, _time_step: f64) -> Option<DrivenStep> {
        self.field.update(&system.particles, system.layout(), true, system.workers);
        Some(DrivenStep { flux: self.field.flux(&system.particles, system.workers), forcing: self.magnitude })
    }
}
