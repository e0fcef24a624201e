//! What the runs at one strength tell: stress, gradient, viscosity, the state of the fluid, each with its error.

use super::record::{Aligned, ExchangeRecord};
use super::recorder::{
    ACROSS, AMPLITUDE, COUNT, ENERGY, EXCHANGED, FIRST, FOURTH_MOMENT, GRADIENT, GRADIENTS, HEAT, MASS, MIDDLE,
    MOMENTUM, NUMBERS, Reader, SECOND_MOMENT, SIXTH_MOMENT, THIRD, WORK,
};
use crate::route::{RouteError, cells};
use mesoflux_analysis::{AnalysisError, Blocking, Estimate, SteadyState, steady_state};
use mesoflux_core::driving::Exchange;
use mesoflux_io::input::{ExchangeStrength, Input};
use std::f64::consts::PI;

/// Standard errors beyond which something is worth a warning.
const ERRORS: f64 = 3.5;
/// So many relaxation times of the flow at least should each replica last.
const FEWEST: f64 = 5.0;

/// The runs at one strength.
pub(super) struct Point {
    /// Δp; of swaps its mean.
    pub momentum: Estimate,
    pub interval: u64,
    /// Π of eq. 55.
    pub stress: Estimate,
    /// |dv/dx| in the middle of the halves.
    pub gradient: Estimate,
    pub viscosity: Estimate,
    /// kT by the momenta across the flow (eq. 58).
    pub temperature: Estimate,
    pub density: Estimate,
    /// The cubic term of the profile over the linear one at the edge of the fitted middle.
    pub curvature: Estimate,
    /// Energy over time.
    pub work: Estimate,
    pub heat: Estimate,
    /// Work less heat less change of the energy, over time.
    pub missing: Estimate,
    /// Time from the start of production to the steady state.
    pub discarded: f64,
    /// Time in which the slowest mode of the flow decays, L²ρ_m/(4π²μ).
    pub relaxation: Option<f64>,
    pub warnings: Vec<String>,
    /// Density, velocity, temperature, effective temperature and, where it is asked for, local gradient by bin, each with its error.
    pub profile: Vec<Vec<f64>>,
}

impl Point {
    pub fn new(
        input: &Input,
        reader: &Reader,
        (strength, interval): (ExchangeStrength, u64),
        record: &ExchangeRecord,
    ) -> Result<Self, RouteError> {
        let aligned = record.aligned();
        let spacing = input.run.sample_interval as f64 * input.dynamics.time_step;
        let mut warnings = Vec::new();
        let start = start(&aligned, &mut warnings);
        let time = |stretches: usize| (stretches as u64 * aligned.length) as f64 * spacing;
        let series = aligned.series(start, 0..NUMBERS)?;

        let sides = input.sides();
        let volume: f64 = sides.iter().product();
        let per_stress = input.momentum_over_stress(reader.slabs.gradient, interval);
        let rate_over_stress = per_stress / (interval as f64 * input.dynamics.time_step);
        let booked = series.component(EXCHANGED).scaled(1.0 / rate_over_stress);
        let (stress, viscosity);
        let gradient = series.ratio(FIRST, SECOND_MOMENT).scaled(-1.0 / reader.reach);
        match input.exchange(reader.slabs.gradient, strength, interval) {
            Exchange::Forced { momentum }
                if is_complete(&booked, momentum / per_stress, interval, input, &aligned, start) =>
            {
                let imposed = momentum / per_stress;
                stress = Estimate::new(imposed, 0.0, gradient.effective_samples);
                viscosity = gradient.clone().inverse().scaled(imposed);
            }
            exchange => {
                if exchange != Exchange::Swap {
                    warnings.push("a slab was empty at times: the stress is what was exchanged".to_owned());
                }
                stress = booked;
                viscosity = over_booked(&series, &gradient, reader.reach / rate_over_stress);
            }
        }
        let momentum = stress.scaled(per_stress);

        let masses = input.masses().into_iter().zip(input.species_counts());
        let total_mass: f64 = masses.map(|(mass, count)| mass * count as f64).sum();
        let middle = aligned.series(start, MIDDLE..NUMBERS)?;
        // Two halves, each 2h thick.
        let middle_volume = volume * 4.0 * reader.reach / reader.side;
        let weights = |given: &[(usize, f64)]| {
            let mut weights = vec![0.0; NUMBERS];
            given.iter().for_each(|&(place, weight)| weights[place] = weight);
            weights
        };
        let relaxation = viscosity.value.filter(|value| *value > 0.0);
        let relaxation = relaxation.map(|value| total_mass / volume * (reader.side / (2.0 * PI)).powi(2) / value);
        let heat = if record.tells_heat { series.component(HEAT) } else { Estimate::default() };
        let missing = series.linear(&weights(&[(WORK, 1.0), (HEAT, -1.0), (ENERGY, -1.0)]));
        let profile = profile(&aligned, start, reader, volume, total_mass, momentum.value.unwrap_or(f64::NAN))?;
        let mut point = Self {
            momentum,
            interval,
            stress,
            gradient,
            viscosity,
            temperature: temperature(&middle, total_mass),
            density: middle.component(COUNT).scaled(1.0 / middle_volume),
            curvature: curvature(&series),
            work: series.component(WORK),
            heat,
            missing: if record.tells_heat { missing } else { Estimate::default() },
            discarded: time(start),
            relaxation,
            warnings,
            profile,
        };
        point.judge(time(aligned.count(start)) / record.replicas() as f64);
        Ok(point)
    }

    /// Warns of what is not as it should be, given the time that counts in each replica.
    fn judge(&mut self, counted: f64) {
        if let Some(relaxation) = self.relaxation.filter(|time| counted < FEWEST * time) {
            self.warnings.push(format!(
                "{counted:.4} of the production time of a replica count, {:.2} times the {relaxation:.4} in which the flow relaxes: \
                 whether it is steady can't be told before {FEWEST} times",
                counted / relaxation
            ));
        }
        let z = self.curvature.z_score_against(0.0, 0.0).unwrap_or(0.0);
        if let (true, Some(share)) = (z.abs() > ERRORS, self.curvature.value) {
            self.warnings.push(format!(
                "the profile of the velocity is not straight in the fitted middle: its cubic term is {:.1} % of the linear one at the \
                 edge, z = {z:.1}; a smaller fitted_fraction fits less of it",
                100.0 * share
            ));
        }
    }
}

/// The first stretch that counts, with a warning where no steady state was reached.
fn start(aligned: &Aligned, warnings: &mut Vec<String>) -> usize {
    let Ok(state) = steady_state(&aligned.course(AMPLITUDE)) else {
        warnings.push("too few samples to see whether the flow is steady: run longer".to_owned());
        return 0;
    };
    let SteadyState { start, drift } = &state;
    if !state.is_reached() {
        warnings.push(format!(
            "no steady state was reached: over what counts, the amplitude of the flow still changes by {:.3e} ± {:.1e}; run longer, or \
             give a better predicted_viscosity",
            drift.value.unwrap_or(f64::NAN),
            drift.standard_error.unwrap_or(f64::NAN),
        ));
    }
    *start
}

/// Whether all forced exchanges have taken place: at both ends of each replica, one more or less may have been counted.
fn is_complete(booked: &Estimate, imposed: f64, interval: u64, input: &Input, aligned: &Aligned, start: usize) -> bool {
    let steps = aligned.count(start) as f64 * aligned.length as f64 * input.run.sample_interval as f64;
    let exchanges = steps / interval as f64;
    let missed = booked.value.map_or(0.0, |booked| (1.0 - booked / imposed).abs() * exchanges);
    missed <= 1.5 * input.run.replicas as f64 + 1e-9 * exchanges
}

/// Π/|dv/dx| with both measured, from their joint series; `scale` is h over 2A.
fn over_booked(series: &Blocking, gradient: &Estimate, scale: f64) -> Estimate {
    if gradient.z_score_against(0.0, 0.0).is_none_or(|z| z < 3.0) {
        return gradient.clone().inverse();
    }
    let value = |mean: &[f64]| -scale * mean[EXCHANGED] * mean[SECOND_MOMENT] / mean[FIRST];
    series.function(value, |mean| {
        let mut gradient = vec![0.0; mean.len()];
        gradient[EXCHANGED] = -scale * mean[SECOND_MOMENT] / mean[FIRST];
        gradient[SECOND_MOMENT] = -scale * mean[EXCHANGED] / mean[FIRST];
        gradient[FIRST] = -value(mean) / mean[FIRST];
        gradient
    })
}

/// kT = ⟨Σ p²/m⟩ of the two components across the flow over their 2(1 − m/M) degrees of freedom a particle.
fn temperature(region: &Blocking, total_mass: f64) -> Estimate {
    let degrees = |mean: &[f64]| 2.0 * (mean[COUNT] - mean[MASS] / total_mass);
    region.function(
        |mean| mean[ACROSS] / degrees(mean),
        |mean| {
            let (degrees, temperature) = (degrees(mean), mean[ACROSS] / degrees(mean));
            let mut gradient = vec![0.0; mean.len()];
            gradient[ACROSS] = 1.0 / degrees;
            gradient[COUNT] = -2.0 * temperature / degrees;
            gradient[MASS] = 2.0 * temperature / (total_mass * degrees);
            gradient
        },
    )
}

/// b/a of the least-squares flow as + bs³.
fn curvature(series: &Blocking) -> Estimate {
    let parts = |mean: &[f64]| {
        let (first, third) = (mean[FIRST], mean[THIRD]);
        let cubic = mean[SECOND_MOMENT] * third - mean[FOURTH_MOMENT] * first;
        let linear = mean[SIXTH_MOMENT] * first - mean[FOURTH_MOMENT] * third;
        (cubic / linear, linear)
    };
    series.function(
        |mean| parts(mean).0,
        |mean| {
            let (ratio, linear) = parts(mean);
            let (first, third) = (mean[FIRST], mean[THIRD]);
            let mut gradient = vec![0.0; mean.len()];
            gradient[FIRST] = -(mean[FOURTH_MOMENT] + ratio * mean[SIXTH_MOMENT]) / linear;
            gradient[THIRD] = (mean[SECOND_MOMENT] + ratio * mean[FOURTH_MOMENT]) / linear;
            gradient[SECOND_MOMENT] = third / linear;
            gradient[FOURTH_MOMENT] = (ratio * third - first) / linear;
            gradient[SIXTH_MOMENT] = -ratio * first / linear;
            gradient
        },
    )
}

/// Density, velocity, temperature, effective temperature and local gradient of every bin.
///
/// The effective temperature is kT + Δp²/2m (Naseri et al., below Fig. 7) in the slabs, m being the mean mass there: with it, the pressure of an ideal
/// gas is the same everywhere.
fn profile(
    aligned: &Aligned,
    start: usize,
    reader: &Reader,
    volume: f64,
    total_mass: f64,
    momentum: f64,
) -> Result<Vec<Vec<f64>>, AnalysisError> {
    let row = |bin: usize| {
        let first = NUMBERS + reader.bin() * bin;
        let series = aligned.series(start, first..first + reader.bin())?;
        let density = cells(&series.component(COUNT).scaled(reader.bins as f64 / volume));
        let velocity = cells(&series.ratio(MOMENTUM, MASS));
        let temperature = cells(&temperature(&series, total_mass));
        let masses = series.mean().map_or(f64::NAN, |mean| mean[MASS] / mean[COUNT]);
        let given = reader.slabs.share_inside(bin, reader.bins) * momentum * momentum / (2.0 * masses);
        let effective = [temperature[0] + given, temperature[1]];
        let mut row = [density, velocity, temperature, effective].concat();
        if reader.strain_rate.is_some() {
            row.extend(cells(&series.ratio(GRADIENT, GRADIENTS)));
        }
        Ok(row)
    };
    (0..reader.bins).map(row).collect()
}
