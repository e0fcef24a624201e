//! Stochastic Norton dynamics: the flux R = G·p is held, the forcing that this takes is measured (Wu & Shang, eqs 11, 33–71).

use super::{DrivenStep, Driving};
use crate::forcing::{Forcing, ForcingError, ForcingField};
use crate::integrate::{Change, Constraint, FluxChange, Schedule};
use crate::system::System;
use crate::vector::{add_scaled, dot};

/// Projects the momenta back onto G·p = r after every letter and books the multipliers.
#[derive(Debug)]
pub struct ConstantFlux {
    flux: f64,
    field: ForcingField,
    /// ℓ: the multipliers booked since the beginning of the step.
    booked: f64,
}

impl ConstantFlux {
    /// The dynamics at R = `flux`.
    pub fn new(forcing: Box<dyn Forcing>, flux: f64) -> Self {
        Self { flux, field: ForcingField::new(forcing), booked: 0.0 }
    }

    /// p += ξ F with ξ = (r − G·p)/(F·G), at the present positions (Wu & Shang, eqs 42, 45, 50); returns ξ.
    fn project(&mut self, system: &mut System, moved: bool) -> f64 {
        self.field.update(&system.particles, system.layout(), moved, system.workers);
        let field = &self.field;
        let multiplier = (self.flux - field.flux(&system.particles, system.workers)) / field.control;
        system.workers.for_each_chunk(&mut system.particles.momentum, |offset, momenta| {
            for (k, momentum) in momenta.iter_mut().enumerate() {
                add_scaled(momentum, multiplier, field.force[offset + k]);
            }
        });
        multiplier
    }
}

impl Driving for ConstantFlux {
    fn begin(&mut self, system: &mut System) -> Result<(), ForcingError> {
        self.field.forcing().check(system.particles.count())?;
        self.field.update(&system.particles, system.layout(), true, system.workers);
        // Rounding alone leaves about 1e-16 Σ|F·G|: anything that small controls nothing.
        let scale = system
            .workers
            .sum(system.particles.count(), |k| dot(self.field.force[k], self.field.response[k].vector()).abs());
        if !(self.field.control.abs() > 1e-12 * scale) {
            return Err(ForcingError::NoControl(self.field.control));
        }
        self.project(system, true);
        Ok(())
    }

    fn constraint(&mut self, system: &System) -> Option<Constraint<'_>> {
        self.field.update(&system.particles, system.layout(), false, system.workers);
        let ForcingField { force, response, control, .. } = &self.field;
        Some(Constraint { force, response, control: *control, flux: self.flux })
    }

    fn after_letter(&mut self, system: &mut System, symbol: char, _time: f64, change: Change) {
        // Free flight changes no momentum: where G doesn't depend on positions, nor the flux.
        if symbol == 'A' && !self.field.forcing().depends_on_positions() {
            return;
        }
        let multiplier = change.multiplier.unwrap_or_else(|| self.project(system, symbol == 'A'));
        self.booked += match change.flux {
            FluxChange::Determined => multiplier,
            // The noise moves the flux by a martingale, whose part of the multiplier averages to nothing: eq. 63 leaves it out.
            FluxChange::Expected(expected) => -expected / self.field.control,
        };
    }

    fn end_step(&mut self, system: &System, time_step: f64) -> DrivenStep {
        // The particles may have been sorted anew since the last letter that projected.
        self.field.update(&system.particles, system.layout(), true, system.workers);
        let forcing = std::mem::take(&mut self.booked) / time_step;
        DrivenStep { flux: self.field.flux(&system.particles, system.workers), forcing }
    }

    fn needs_expected_flux(&self) -> bool {
        true
    }

    fn forcing_observable(&mut self, system: &mut System, schedule: &Schedule) -> Option<f64> {
        self.field.update(&system.particles, system.layout(), true, system.workers);
        system.update_forces();
        let field = &self.field;
        let workers = system.workers;
        let particles = &system.particles;
        let conservative =
            workers.sum(particles.count(), |k| dot(field.response[k].vector(), system.forces()[k].vector()));
        let drift = workers.sum(particles.count(), |k| field.forcing().response_drift(particles, k));
        let dissipative = schedule.dissipative_flux(system, &field.response);
        Some(-(conservative + dissipative + drift) / field.control)
    }
}
