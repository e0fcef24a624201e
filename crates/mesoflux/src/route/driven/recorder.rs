//! What a driven run records: flux and forcing, and where asked for their memory, their spread and the profile of the flow.

use super::flow::FlowReader;
use crate::route::{Record, RouteError, RouteRecorder};
use mesoflux_analysis::{AnalysisError, Blocking, Histogram, MultipleTau};
use mesoflux_core::driving::DrivenStep;
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_io::stream;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// The record of a driven run, or of several replicas merged.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DrivenRecord {
    /// Flux, forcing, kinetic temperature, the square of the answer and, if asked for, λ(q, p). All but temperature and
    /// λ(q, p) are averages over the sample interval.
    pub series: Blocking,
    /// Of the answer, read at instants.
    pub autocorrelation: Option<MultipleTau>,
    /// Of the answer at every step.
    pub histogram: Option<Histogram>,
    /// A series for every layer of the profile, see `flow.rs`.
    pub profile: Vec<Blocking>,
}

impl DrivenRecord {
    /// Place of the flux R in the series.
    pub const FLUX: usize = 0;
    /// Place of the forcing η or λ.
    pub const FORCING: usize = 1;
    /// Place of the kinetic temperature.
    pub const TEMPERATURE: usize = 2;
    /// Place of the square of the answer: of R, or of λ.
    pub const SQUARE: usize = 3;
    /// Place of λ(q, p).
    pub const OBSERVABLE: usize = 4;

    /// Adds the record of another replica.
    ///
    /// # Errors
    /// A record of something else.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        self.series.merge(&other.series)?;
        match (&mut self.autocorrelation, &other.autocorrelation) {
            (Some(mine), Some(theirs)) => mine.merge(theirs)?,
            (None, None) => {}
            _ => return Err(RouteError::WrongRecord),
        }
        match (&mut self.histogram, &other.histogram) {
            (Some(mine), Some(theirs)) => mine.merge(theirs)?,
            (None, None) => {}
            _ => return Err(RouteError::WrongRecord),
        }
        if self.profile.len() != other.profile.len() {
            return Err(RouteError::WrongRecord);
        }
        Ok(self.profile.iter_mut().zip(&other.profile).try_for_each(|(mine, theirs)| mine.merge(theirs))?)
    }

    fn accepts(&self, state: &Self) -> bool {
        let correlations = match (&self.autocorrelation, &state.autocorrelation) {
            (Some(mine), Some(theirs)) => mine.accepts(theirs),
            (mine, theirs) => mine.is_none() && theirs.is_none(),
        };
        let histograms = match (&self.histogram, &state.histogram) {
            (Some(mine), Some(theirs)) => mine.accepts(theirs),
            (mine, theirs) => mine.is_none() && theirs.is_none(),
        };
        self.series.accepts(&state.series)
            && correlations
            && histograms
            && self.profile.len() == state.profile.len()
            && self.profile.iter().zip(&state.profile).all(|(mine, theirs)| mine.accepts(theirs))
    }
}

/// Records a driven run.
pub(super) struct DrivenRecorder {
    /// Steps over which the series averages, and from one reading of the profile to the next.
    pub interval: u64,
    /// Steps between two samples of the autocorrelation.
    pub correlation_interval: u64,
    /// What answers to what is imposed, `FLUX` or `FORCING`.
    pub answer: usize,
    /// Whether λ(q, p) is averaged, too.
    pub observable: bool,
    /// Flux and forcing since the last sample.
    pub sum: DrivenStep,
    pub flow: Option<FlowReader>,
    pub record: DrivenRecord,
    pub failure: Option<AnalysisError>,
}

impl DrivenRecorder {
    fn keep(&mut self, recorded: Result<(), AnalysisError>) {
        self.failure = self.failure.take().or(recorded.err());
    }

    fn sample(&mut self, moment: &mut Moment) {
        let scale = 1.0 / self.interval as f64;
        let mean = DrivenStep { flux: self.sum.flux * scale, forcing: self.sum.forcing * scale };
        self.sum = DrivenStep { flux: 0.0, forcing: 0.0 };
        let temperature = moment.simulation.system.kinetic_temperature();
        let mut sample = vec![mean.flux, mean.forcing, temperature];
        sample.push(sample[self.answer].powi(2));
        if self.observable {
            sample.push(moment.simulation.forcing_observable().unwrap_or(f64::NAN));
        }
        let recorded = self.record.series.record(&sample);
        self.keep(recorded);
        if let Some(flow) = &mut self.flow {
            let forcing = moment.driven.map_or(0.0, |step| step.forcing);
            let layers = flow.read(&mut moment.simulation.system, forcing);
            let mut series = self.record.profile.iter_mut().zip(&layers);
            let recorded = series.try_for_each(|(series, layer)| series.record(layer));
            self.keep(recorded);
        }
    }
}

impl Recorder for DrivenRecorder {
    fn observe(&mut self, moment: &mut Moment) {
        if let Some(step) = moment.driven {
            self.sum.flux += step.flux;
            self.sum.forcing += step.forcing;
            let answer = [step.flux, step.forcing][self.answer];
            let counted = self.record.histogram.as_mut().map_or(Ok(()), |histogram| histogram.record(answer));
            self.keep(counted);
            if let Some(correlation) = &mut self.record.autocorrelation
                && moment.step.is_multiple_of(self.correlation_interval)
            {
                let recorded = correlation.record(&[answer]);
                self.keep(recorded);
            }
        }
        if moment.step.is_multiple_of(self.interval) {
            self.sample(moment);
        }
    }
}

impl RouteRecorder for DrivenRecorder {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, self.correlation_interval, self.sum, &self.record))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, correlation_interval, sum, record): (u64, u64, _, _) = postcard::from_bytes(state)?;
        let intervals = (interval, correlation_interval);
        if intervals != (self.interval, self.correlation_interval) || !self.record.accepts(&record) {
            return Err(RouteError::OtherState);
        }
        (self.sum, self.record) = (sum, record);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Driven(Box::new(self.record))),
        }
    }
}
