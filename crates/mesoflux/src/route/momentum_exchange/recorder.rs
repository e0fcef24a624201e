//! What is read of a run by momentum exchange: the flow between the slabs, its profile, and where the energy goes.

use super::record::ExchangeRecord;
use crate::route::{Record, RouteError, RouteRecorder};
use mesoflux_core::driving::{Exchanged, Slabs};
use mesoflux_core::observable::StrainRate;
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::system::System;
use mesoflux_io::input::{Input, MomentumExchangeInput, StrainRateInput};
use mesoflux_io::stream;
use std::f64::consts::TAU;
use std::io::{self, Write};

/// Numbers of a sample before those of the bins.
pub(super) const NUMBERS: usize = 13;
/// Momentum exchanged over time.
pub(super) const EXCHANGED: usize = 0;
/// Work over time.
pub(super) const WORK: usize = 1;
/// Heat over time.
pub(super) const HEAT: usize = 2;
/// Change of the total energy over time.
pub(super) const ENERGY: usize = 3;
/// (2/M) Σ p sin(2πx/L): the slowest mode of the flow.
pub(super) const AMPLITUDE: usize = 4;
/// Σ s p over the fitted middle, s = ξ/h from −1 to 1 in both halves, p with the sign of the half.
pub(super) const FIRST: usize = 5;
/// Σ s³ p.
pub(super) const THIRD: usize = 6;
/// Σ m s².
pub(super) const SECOND_MOMENT: usize = 7;
/// Σ m s⁴.
pub(super) const FOURTH_MOMENT: usize = 8;
/// Σ m s⁶.
pub(super) const SIXTH_MOMENT: usize = 9;
/// Σ 1 over the fitted middle; first of the numbers that bins have, too.
pub(super) const MIDDLE: usize = 10;

/// What is read of a region: its particles, their mass, Σ p²/m across the flow; of a bin Σ p along the flow as well.
pub(super) const COUNT: usize = 0;
/// Σ m.
pub(super) const MASS: usize = 1;
/// Σ p²/m of the two components across the flow.
pub(super) const ACROSS: usize = 2;
/// Σ p along the flow, of bins alone.
pub(super) const MOMENTUM: usize = 3;
/// Particles whose local velocity gradient is known, of bins alone and where it is asked for.
pub(super) const GRADIENTS: usize = 4;
/// Σ ∂v along the flow over ∂x, by the neighbors of each particle.
pub(super) const GRADIENT: usize = 5;

/// Reads the flow of a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader {
    pub slabs: Slabs,
    pub bins: usize,
    /// L.
    pub side: f64,
    /// h: half the thickness of the fitted middle of each half.
    pub reach: f64,
    /// What estimates the gradient around every particle.
    pub strain_rate: Option<StrainRate>,
}

impl Reader {
    pub fn new(input: &Input, route: &MomentumExchangeInput, slabs: Slabs) -> Result<Self, RouteError> {
        let side = input.sides()[slabs.gradient as usize];
        // From the center of a half to the edge of a slab.
        let free = (0.25 - 0.5 * slabs.width) * side;
        let strain_rate = |asked: StrainRateInput| StrainRate::new(asked.cutoff, asked.exponent, asked.normalization);
        let strain_rate = route.strain_rate.map(strain_rate).transpose()?;
        Ok(Self { slabs, bins: route.bins as usize, side, reach: route.fitted_fraction * free, strain_rate })
    }

    /// Numbers of a bin.
    pub fn bin(&self) -> usize {
        if self.strain_rate.is_some() { 6 } else { 4 }
    }

    /// Numbers of a sample.
    pub fn numbers(&self) -> usize {
        NUMBERS + self.bin() * self.bins
    }

    /// Adds what the particles tell to a sample of zeros.
    fn read(&self, system: &mut System, sample: &mut [f64]) -> Result<(), RouteError> {
        let size = self.bin();
        let (flow, gradient) = (self.slabs.flow as usize, self.slabs.gradient as usize);
        if let Some(strain_rate) = &self.strain_rate {
            let local = strain_rate.of(system)?;
            let layers = local.profile(&system.particles, &system.region, gradient, self.bins);
            for (bin, layer) in sample[NUMBERS..].chunks_exact_mut(size).zip(layers) {
                (bin[GRADIENTS], bin[GRADIENT]) = (layer.count as f64, layer.gradient.0[gradient][flow]);
            }
        }
        let particles = &system.particles;
        let (mut total_mass, mut wave) = (0.0, 0.0);
        for k in 0..particles.count() {
            let (x, momentum, inverse_mass) =
                (particles.position[k][gradient], particles.momentum[k], particles.inverse_mass[k]);
            let mass = 1.0 / inverse_mass;
            let across =
                (0..3).filter(|&axis| axis != flow).map(|axis| momentum[axis].powi(2) * inverse_mass).sum::<f64>();
            total_mass += mass;
            wave += momentum[flow] * (TAU * x / self.side).sin();
            let share = x / self.side;
            let index = (((share - share.floor()) * self.bins as f64) as usize).min(self.bins - 1);
            let bin = &mut sample[NUMBERS + size * index..][..size];
            bin[COUNT] += 1.0;
            bin[MASS] += mass;
            bin[ACROSS] += across;
            bin[MOMENTUM] += momentum[flow];
            let (along, sign) = self.slabs.folded(x, self.side);
            if along.abs() <= self.reach {
                let s = along / self.reach;
                let (square, signed) = (s * s, sign * momentum[flow] * s);
                sample[FIRST] += signed;
                sample[THIRD] += signed * square;
                sample[SECOND_MOMENT] += mass * square;
                sample[FOURTH_MOMENT] += mass * square * square;
                sample[SIXTH_MOMENT] += mass * square * square * square;
                sample[MIDDLE + COUNT] += 1.0;
                sample[MIDDLE + MASS] += mass;
                sample[MIDDLE + ACROSS] += across;
            }
        }
        sample[AMPLITUDE] = 2.0 * wave / total_mass;
        Ok(())
    }
}

/// Records a run by momentum exchange.
pub(super) struct ExchangeRecorder {
    pub interval: u64,
    pub reader: Reader,
    /// Since the last sample.
    pub sum: Exchanged,
    /// At the last sample.
    pub energy: Option<f64>,
    pub record: ExchangeRecord,
    pub failure: Option<RouteError>,
}

impl ExchangeRecorder {
    fn sample(&mut self, moment: &mut Moment) {
        let system = &mut moment.simulation.system;
        let energy = 0.5 * system.particles.twice_kinetic_energy(system.workers) + system.pair_sums().potential_energy;
        let (sum, before) = (std::mem::take(&mut self.sum), self.energy.replace(energy));
        // The first sample only tells from what energy on changes count.
        let Some(before) = before else { return };
        let rate = 1.0 / (self.interval as f64 * moment.simulation.time_step());
        let mut sample = vec![0.0; self.reader.numbers()];
        sample[EXCHANGED] = sum.momentum * rate;
        sample[WORK] = sum.work * rate;
        sample[HEAT] = sum.heat.unwrap_or(0.0) * rate;
        sample[ENERGY] = (energy - before) * rate;
        self.record.tells_heat &= sum.heat.is_some();
        let read = self.reader.read(&mut moment.simulation.system, &mut sample);
        let recorded = read.and_then(|()| Ok(self.record.record(&sample)?));
        self.failure = self.failure.take().or(recorded.err());
    }
}

impl Recorder for ExchangeRecorder {
    fn observe(&mut self, moment: &mut Moment) {
        if let Some(step) = moment.exchanged() {
            self.sum.momentum += step.momentum;
            self.sum.work += step.work;
            if let Some(heat) = step.heat {
                *self.sum.heat.get_or_insert_default() += heat;
            }
        }
        if moment.step.is_multiple_of(self.interval) {
            self.sample(moment);
        }
    }
}

impl RouteRecorder for ExchangeRecorder {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, self.sum, self.energy, &self.record))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, sum, energy, record): (u64, _, _, _) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.record.accepts(&record) {
            return Err(RouteError::OtherState);
        }
        (self.sum, self.energy, self.record) = (sum, energy, record);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure),
            None => Ok(Record::Exchange(Box::new(self.record))),
        }
    }
}
