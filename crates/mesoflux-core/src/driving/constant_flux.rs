//! Stochastic Norton dynamics: the flux R = G·p is held, the forcing that this takes is measured (Wu & Shang, eqs 11, 33–71).

use super::{DrivenStep, Driving};
use crate::forcing::{ForcingError, ForcingField};
use crate::integrate::{Change, Constraint, FluxChange, Schedule};
use crate::system::System;
use crate::vector::dot;
use serde::{Deserialize, Serialize};

/// How the flux is brought back after a letter has changed it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Half of what a letter takes from the flux on average is given before it, the rest after it: while the letter acts, the flux
    /// is r at its middle. The mean multiplier is of second order in the time step.
    #[default]
    Symmetric,
    /// All of it after the letter, as in Wu & Shang's eqs 40–69: while the letter acts, the flux is too small, and the mean
    /// multiplier is too small at first order.
    Paper,
}

/// Projects the momenta back onto G·p = r after every letter and books the multipliers.
///
/// The derivation of both projections is in `book/src/norton.md`.
#[derive(Debug)]
pub struct ConstantFlux {
    flux: f64,
    field: ForcingField,
    projection: Projection,
    /// ℓ: the multipliers booked since the beginning of the step.
    booked: f64,
    /// The mean multiplier of A and of O.
    flight: MeanRate,
    thermostat: MeanRate,
}

/// The mean of a multiplier over time, the last thousand strokes counting most.
#[derive(Debug, Clone, Copy, Default)]
struct MeanRate {
    mean: f64,
    /// How much the mean counts against the next stroke.
    strokes: f64,
}

impl MeanRate {
    /// Long enough that the mean hardly knows of the present fluctuation: else giving half of it in advance would correlate with the
    /// noise and disturb the balance of fluctuation and dissipation.
    const MEMORY: f64 = 1000.0;

    fn record(&mut self, rate: f64) {
        self.mean += (rate - self.mean) / (1.0 + self.strokes);
        // What is recorded at the beginning, at a start that is no steady state, is forgotten soon.
        self.strokes = (self.strokes + 0.25).min(Self::MEMORY);
    }
}

impl ConstantFlux {
    /// The dynamics at R = `flux`.
    pub fn new(field: ForcingField, flux: f64, projection: Projection) -> Self {
        let (flight, thermostat) = Default::default();
        Self { flux, field, projection, booked: 0.0, flight, thermostat }
    }

    /// p += ξ F with ξ = (r − G·p)/(F·G), at the present positions (Wu & Shang, eqs 42, 45, 50); returns ξ.
    fn project(&mut self, system: &mut System, moved: bool) -> f64 {
        self.field.update(&system.particles, system.layout(), moved, system.workers);
        let multiplier = (self.flux - self.field.flux(&system.particles, system.workers)) / self.field.control;
        self.field.push(&mut system.particles, multiplier, system.workers);
        multiplier
    }

    /// The mean multiplier of a letter that changes the flux while it acts; B changes it by one impulse, before or after which is
    /// the same.
    fn mean_rate(&mut self, symbol: char) -> Option<&mut MeanRate> {
        match symbol {
            'A' if self.field.forcing().depends_on_positions() => Some(&mut self.flight),
            'O' => Some(&mut self.thermostat),
            _ => None,
        }
    }

    /// What is given before a letter that acts for `time`.
    fn advance(&mut self, symbol: char, time: f64) -> f64 {
        match self.projection {
            Projection::Paper => 0.0,
            Projection::Symmetric => self.mean_rate(symbol).map_or(0.0, |rate| 0.5 * time * rate.mean),
        }
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

    fn before_letter(&mut self, system: &mut System, symbol: char, time: f64) {
        let advance = self.advance(symbol, time);
        if advance != 0.0 {
            self.field.update(&system.particles, system.layout(), false, system.workers);
            self.field.push(&mut system.particles, advance, system.workers);
        }
    }

    fn constraint(&mut self, system: &System) -> Option<Constraint<'_>> {
        self.field.update(&system.particles, system.layout(), false, system.workers);
        let ForcingField { force, response, control, .. } = &self.field;
        Some(Constraint { force, response, control: *control, flux: self.flux })
    }

    fn after_letter(&mut self, system: &mut System, symbol: char, time: f64, change: Change) {
        // Free flight changes no momentum: where G doesn't depend on positions, nor the flux.
        if symbol == 'A' && !self.field.forcing().depends_on_positions() {
            return;
        }
        let advance = self.advance(symbol, time);
        let multiplier = change.multiplier.unwrap_or_else(|| self.project(system, symbol == 'A'));
        let booked = match change.flux {
            FluxChange::Determined => advance + multiplier,
            // The noise moves the flux by a martingale, whose part of the multiplier averages to nothing: eq. 63 leaves it out.
            FluxChange::Expected(expected) => -expected / self.field.control,
        };
        self.booked += booked;
        if let Some(rate) = self.mean_rate(symbol) {
            rate.record(booked / time);
        }
    }

    fn end_step(&mut self, system: &mut System, time_step: f64) -> Option<DrivenStep> {
        // The particles may have been sorted anew since the last letter that projected.
        self.field.update(&system.particles, system.layout(), true, system.workers);
        let forcing = std::mem::take(&mut self.booked) / time_step;
        Some(DrivenStep { flux: self.field.flux(&system.particles, system.workers), forcing })
    }

    fn needs_expected_flux(&self) -> bool {
        true
    }

    fn memory(&self) -> Vec<f64> {
        [self.flight, self.thermostat].iter().flat_map(|rate| [rate.mean, rate.strokes]).collect()
    }

    fn remember(&mut self, memory: &[f64]) -> bool {
        let &[flight, flights, thermostat, sweeps] = memory else {
            return false;
        };
        self.flight = MeanRate { mean: flight, strokes: flights };
        self.thermostat = MeanRate { mean: thermostat, strokes: sweeps };
        memory.iter().all(|number| number.is_finite()) && flights >= 0.0 && sweeps >= 0.0
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
