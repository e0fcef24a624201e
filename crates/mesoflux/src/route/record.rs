//! What a run leaves for the estimators: accumulators of bounded size that replicas merge into.

use super::correlation::Correlations;
use super::{RouteError, RouteRecorder};
use mesoflux_analysis::{AnalysisError, Blocking, Histogram, MeanSquaredDisplacement};
use mesoflux_core::driving::DrivenStep;
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_io::stream;
use std::io::{self, Write};

/// The record of a run, or of several replicas merged.
#[derive(Debug, Clone)]
pub enum Record {
    /// A vector-valued series.
    Series(Blocking),
    /// Mean squared displacements.
    Displacement(MeanSquaredDisplacement),
    /// Series of their own, one for each number of a profile.
    Profile(Vec<Blocking>),
    /// Counts of an observable's values.
    Histogram(Histogram),
    /// Correlations in time.
    Correlations(Box<Correlations>),
}

impl Record {
    /// Adds the record of another replica.
    ///
    /// # Errors
    /// Records of different kinds.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        match (self, other) {
            (Self::Series(mine), Self::Series(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Displacement(mine), Self::Displacement(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Profile(mine), Self::Profile(theirs)) if mine.len() == theirs.len() => {
                Ok(mine.iter_mut().zip(theirs).try_for_each(|(mine, theirs)| mine.merge(theirs))?)
            }
            (Self::Histogram(mine), Self::Histogram(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Correlations(mine), Self::Correlations(theirs)) => mine.merge(theirs),
            _ => Err(RouteError::WrongRecord),
        }
    }

    /// The correlations, for a route that records them.
    ///
    /// # Errors
    /// Another kind of record.
    pub fn correlations(&self) -> Result<&Correlations, RouteError> {
        match self {
            Self::Correlations(correlations) => Ok(correlations),
            _ => Err(RouteError::WrongRecord),
        }
    }

    /// The series, for a route that records one.
    ///
    /// # Errors
    /// Another kind of record.
    pub fn series(&self) -> Result<&Blocking, RouteError> {
        match self {
            Self::Series(series) => Ok(series),
            _ => Err(RouteError::WrongRecord),
        }
    }
}

/// Records flux, forcing, kinetic temperature and, if asked, λ(q, p), averaged over the sample interval where cheap.
#[derive(Debug)]
pub struct DrivenRecorder {
    interval: u64,
    forcing_observable: bool,
    sum: DrivenStep,
    series: Blocking,
    failure: Option<AnalysisError>,
}

impl DrivenRecorder {
    /// Place of the flux R in the series.
    pub const FLUX: usize = 0;
    /// Place of the forcing η or λ.
    pub const FORCING: usize = 1;
    /// Place of the kinetic temperature.
    pub const TEMPERATURE: usize = 2;
    /// Place of λ(q, p).
    pub const OBSERVABLE: usize = 3;

    /// A recorder that averages over `interval` steps.
    ///
    /// # Errors
    /// None that can be met.
    pub fn new(interval: u64, forcing_observable: bool) -> Result<Self, RouteError> {
        let components = if forcing_observable { 4 } else { 3 };
        let sum = DrivenStep { flux: 0.0, forcing: 0.0 };
        Ok(Self { interval, forcing_observable, sum, series: Blocking::new(components)?, failure: None })
    }
}

impl Recorder for DrivenRecorder {
    fn observe(&mut self, moment: &mut Moment) {
        if let Some(step) = moment.driven {
            self.sum.flux += step.flux;
            self.sum.forcing += step.forcing;
        }
        if moment.step.is_multiple_of(self.interval) {
            let scale = 1.0 / self.interval as f64;
            let temperature = moment.simulation.system.kinetic_temperature();
            let mut sample = vec![self.sum.flux * scale, self.sum.forcing * scale, temperature];
            if self.forcing_observable {
                sample.push(moment.simulation.forcing_observable().unwrap_or(f64::NAN));
            }
            self.failure = self.failure.take().or(self.series.record(&sample).err());
            self.sum = DrivenStep { flux: 0.0, forcing: 0.0 };
        }
    }
}

impl RouteRecorder for DrivenRecorder {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, self.sum, &self.series))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, sum, series): (u64, _, _) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.series.accepts(&series) {
            return Err(RouteError::OtherState);
        }
        (self.sum, self.series) = (sum, series);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Series(self.series)),
        }
    }
}
