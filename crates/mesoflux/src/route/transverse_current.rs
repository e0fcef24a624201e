//! The shear viscosity from the decay of transverse currents (Hansen & McDonald, Theory of Simple Liquids, ch. 8; Palmer 1994).

use super::correlation::{CorrelationRecorder, Correlations, Sample, Sampler, interval};
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cell};
use crate::long_wave::{Point, at_zero};
use mesoflux_analysis::{Estimate, MultipleTau};
use mesoflux_core::observable::{TRANSVERSE, TransverseCurrents};
use mesoflux_core::run::Moment;
use mesoflux_io::input::{Input, TransverseCurrentInput};
use mesoflux_io::results::Table;
use std::f64::consts::TAU;

/// How much more slowly than stresses currents are sampled.
const SLOWER: u64 = 4;
/// Wavenumbers that differ by less, relatively, are the same.
const SAME: f64 = 1e-12;

/// η(k) = ρ_m/(k² τ) with τ = ∫₀^∞ C(t)/C(0) dt, C(t) = ⟨j(t) j*(0)⟩ and ρ_m the density of mass: exact at every k, as the generalized
/// Navier–Stokes equation says that the Laplace transform of C(t)/C(0) at zero frequency is ρ_m/(η(k) k²). The value at k → 0 is that
/// of the line η(0)(1 − b k²) through the points.
pub(super) struct TransverseCurrent {
    pub parameters: TransverseCurrentInput,
}

/// The currents of one wavenumber.
struct Wave {
    wavenumber: f64,
    /// Number of wave lengths in the box, and the place among `TRANSVERSE`.
    currents: Vec<(usize, usize)>,
}

impl TransverseCurrent {
    fn waves(&self, input: &Input) -> Vec<Wave> {
        let sides = input.sides();
        let mut waves: Vec<Wave> = Vec::new();
        for number in 1..=self.parameters.wavenumbers as usize {
            for (place, [_, gradient]) in TRANSVERSE.into_iter().enumerate() {
                let wavenumber = TAU * number as f64 / sides[gradient];
                match waves.iter_mut().find(|wave| (wave.wavenumber / wavenumber - 1.0).abs() < SAME) {
                    Some(wave) => wave.currents.push((number - 1, place)),
                    None => waves.push(Wave { wavenumber, currents: vec![(number - 1, place)] }),
                }
            }
        }
        waves.sort_by(|a, b| a.wavenumber.total_cmp(&b.wavenumber));
        waves.truncate(self.parameters.wavenumbers as usize);
        waves
    }
}

/// Reads the currents, those of each wavenumber together.
struct Currents {
    waves: Vec<Wave>,
    wavenumbers: usize,
}

impl Sampler for Currents {
    fn sample(&mut self, moment: &mut Moment) -> Sample {
        let system = &moment.simulation.system;
        let currents = TransverseCurrents::of(system, self.wavenumbers);
        let of_wave = |wave: &Wave| wave.currents.iter().flat_map(|&(n, place)| currents.waves[n][place]).collect();
        Sample { channels: self.waves.iter().map(of_wave).collect(), averages: vec![system.kinetic_temperature()] }
    }
}

impl Route for TransverseCurrent {
    fn method(&self) -> &'static str {
        "transverse_current"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        // Waves as long as the box decay more slowly than collisions.
        let default = interval(input, None) * SLOWER;
        let interval = self.parameters.sample_interval.unwrap_or(default);
        let spacing = interval as f64 * input.dynamics.time_step;
        let waves = self.waves(input);
        let correlator = |wave: &Wave| {
            let channels = 2 * wave.currents.len();
            let pairs: Vec<[usize; 2]> = (0..channels).map(|channel| [channel, channel]).collect();
            MultipleTau::new(channels, &pairs, spacing)
        };
        let correlators = waves.iter().map(correlator).collect::<Result<_, _>>()?;
        let wavenumbers = self.parameters.wavenumbers as usize;
        CorrelationRecorder::boxed(interval, Currents { waves, wavenumbers }, correlators, 1)
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let Correlations { functions, .. } = records[0].correlations()?;
        let volume: f64 = input.sides().iter().product();
        let mass: f64 =
            input.masses().iter().zip(input.species_counts()).map(|(mass, count)| mass * count as f64).sum();
        let waves = self.waves(input);
        let (mut points, mut times) = (Vec::new(), Vec::new());
        for (wave, function) in waves.iter().zip(functions) {
            let time = function.autocorrelation_time().time;
            let (Some(value), Some(error)) = (time.value, time.standard_error) else {
                return Ok(Outcome::of(time));
            };
            let viscosity = mass / volume / (wave.wavenumber.powi(2) * value);
            // The relative error goes as the root of the decay time over the number of currents.
            let weight = wave.currents.len() as f64 * wave.wavenumber.powi(2);
            points.push(Point {
                wavenumber: wave.wavenumber,
                viscosity,
                error: viscosity * error / value,
                // It follows from the wave alone, as weights from the data would bias.
                weight,
                effective_samples: time.effective_samples,
            });
            times.push(time);
        }
        let mut outcome = Outcome::of(at_zero(&points)?);
        outcome.conditions.insert("smallest_wavenumber".to_owned(), points[0].wavenumber.into());
        let row =
            |(point, time): (&Point, &Estimate)| vec![point.wavenumber, point.viscosity, point.error, cell(time.value)];
        let rows = points.iter().zip(&times).map(row).collect();
        let header = ["wavenumber [1/l]", "shear_viscosity [p t]", "standard_error [p t]", "decay_time [t]"];
        outcome.tables.push(("", Table::new(header, rows)));
        Ok(outcome)
    }
}
