//! What routes by correlations in time share: their recorder, its record, and how often it samples.

use super::{Record, RouteError, RouteRecorder};
use mesoflux_analysis::{AnalysisError, Blocking, Integral, MultipleTau};
use mesoflux_core::friction::Friction;
use mesoflux_core::integrate::{Langevin, Thermostat};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_io::input::Input;
use mesoflux_io::results::Conditions;
use mesoflux_io::stream;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::io::{self, Write};

/// Correlations of a run, and averages of what belongs to them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Correlations {
    /// One for each function of time.
    pub functions: Vec<MultipleTau>,
    /// Averages over the samples.
    pub averages: Blocking,
}

impl Correlations {
    /// Adds those of another replica.
    ///
    /// # Errors
    /// Correlations of something else.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        if self.functions.len() != other.functions.len() {
            return Err(RouteError::WrongRecord);
        }
        for (mine, theirs) in self.functions.iter_mut().zip(&other.functions) {
            mine.merge(theirs)?;
        }
        Ok(self.averages.merge(&other.averages)?)
    }

    fn accepts(&self, state: &Self) -> bool {
        let fits = |(mine, theirs): (&MultipleTau, &MultipleTau)| mine.accepts(theirs);
        self.functions.len() == state.functions.len()
            && self.functions.iter().zip(&state.functions).all(fits)
            && self.averages.accepts(&state.averages)
    }
}

/// One sample: the channels of each function, and the numbers to be averaged.
pub(super) struct Sample {
    pub channels: Vec<Vec<f64>>,
    pub averages: Vec<f64>,
}

/// Takes a sample of a moment every so many steps; `gather` sees every step, for what has to be summed in between.
pub(super) trait Sampler: Send {
    /// Looks at a step between samples.
    fn gather(&mut self, _moment: &Moment) {}

    /// What is sampled; takes over what was gathered.
    fn sample(&mut self, moment: &mut Moment) -> Sample;

    /// What is gathered so far, for the checkpoint.
    fn gathered(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes over what `gathered` gave; false if it can't be.
    fn resume(&mut self, gathered: &[f64]) -> bool {
        gathered.is_empty()
    }
}

/// Feeds a sampler's samples to correlations.
pub(super) struct CorrelationRecorder<S> {
    pub interval: u64,
    pub sampler: S,
    pub correlations: Correlations,
    pub failure: Option<AnalysisError>,
}

impl<S: Sampler + 'static> CorrelationRecorder<S> {
    /// A recorder of so many averages beside its functions.
    pub fn boxed(
        interval: u64,
        sampler: S,
        functions: Vec<MultipleTau>,
        averages: usize,
    ) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let correlations = Correlations { functions, averages: Blocking::new(averages)? };
        Ok(Box::new(Self { interval, sampler, correlations, failure: None }))
    }
}

impl<S: Sampler> Recorder for CorrelationRecorder<S> {
    fn observe(&mut self, moment: &mut Moment) {
        self.sampler.gather(moment);
        if moment.step.is_multiple_of(self.interval) {
            let sample = self.sampler.sample(moment);
            let Correlations { functions, averages } = &mut self.correlations;
            let mut recorded = averages.record(&sample.averages);
            for (function, channels) in functions.iter_mut().zip(&sample.channels) {
                recorded = recorded.and_then(|()| function.record(channels));
            }
            self.failure = self.failure.take().or(recorded.err());
        }
    }
}

impl<S: Sampler> RouteRecorder for CorrelationRecorder<S> {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, self.sampler.gathered(), &self.correlations))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, gathered, correlations): (u64, Vec<f64>, Correlations) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.correlations.accepts(&correlations) || !self.sampler.resume(&gathered) {
            return Err(RouteError::OtherState);
        }
        self.correlations = correlations;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Correlations(Box::new(self.correlations))),
        }
    }
}

/// What a reader wants to know of an integral: how it was sampled, where it was cut, how fast the correlation decays.
pub(super) fn integral_conditions(function: &MultipleTau, integral: &Integral) -> Conditions {
    let mut conditions = Conditions::from([("sample_spacing".to_owned(), function.spacing().into())]);
    if let Some(cutoff) = integral.cutoff {
        conditions.insert("cutoff_time".to_owned(), cutoff.into());
    }
    if let Some(time) = integral.decay_time.value {
        conditions.insert("decay_time".to_owned(), time.into());
    }
    conditions
}

/// ∫Γ(r) r² dr of a friction at rest.
pub(super) fn friction_integral(law: &Friction) -> f64 {
    const POINTS: u32 = 200;
    let width = law.cutoff() / f64::from(POINTS);
    let part = |k| {
        let r = (f64::from(k) + 0.5) * width;
        law.at_rest(r) * r * r * width
    };
    (0..POINTS).map(part).sum()
}

/// Samples within the time in which the fastest of the correlations changes.
const SAMPLES: f64 = 4.0;

/// Steps between two samples of quantities that follow collisions and friction, where the input names none: a quarter of the shorter
/// of the time in which friction takes a relative velocity away, 1/(2a) with a = (4πρ/3m)∫Γ(r)r²dr between pairs, m/γ by the
/// Langevin thermostat, and the time of flight at thermal speed over a tenth of the shortest cutoff.
pub(super) fn interval(input: &Input, given: Option<u64>) -> u64 {
    if let Some(interval) = given {
        return interval;
    }
    let interactions = input.interactions();
    let masses = input.masses();
    let mass = masses.iter().copied().fold(f64::INFINITY, f64::min);
    let volume = input.region().map_or(f64::INFINITY, |region| region.volume());
    let density = input.particles() as f64 / volume;
    let frictions = interactions.frictions.entries().iter().flatten();
    let rate = |law: &Friction| 2.0 * 4.0 * PI * density / (3.0 * mass) * friction_integral(law);
    let drag = match input.dynamics.thermostat {
        Thermostat::Langevin(Langevin { friction }) => friction / mass,
        Thermostat::PairOrnsteinUhlenbeck | Thermostat::None => 0.0,
    };
    let fastest = frictions.clone().map(rate).fold(drag, f64::max);
    let cutoffs = frictions.map(Friction::cutoff);
    let cutoffs = cutoffs
        .chain(interactions.potentials.entries().iter().flatten().map(mesoflux_core::potential::Potential::cutoff));
    let flight = 0.1 * cutoffs.fold(f64::INFINITY, f64::min) * (mass / input.dynamics.temperature).sqrt();
    let time = flight.min(1.0 / fastest) / SAMPLES;
    ((time / input.dynamics.time_step) as u64).max(1)
}
