//! Averages of instantaneous quantities over an equilibrium run.

use super::{Outcome, Record, Route, RouteError, RouteRecorder};
use mesoflux_analysis::{AnalysisError, Blocking};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::system::System;
use mesoflux_io::input::Input;
use mesoflux_io::stream;
use std::io::{self, Write};

/// The time average of what `read` takes from the system.
pub(super) struct Average {
    pub method: &'static str,
    pub read: fn(&mut System) -> f64,
}

impl Route for Average {
    fn method(&self) -> &'static str {
        self.method
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let read = self.read;
        StateRecorder::boxed(input, 1, move |system| vec![read(system)])
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        Ok(Outcome::of(records[0].series()?.estimate()))
    }
}

/// Records a vector read from the system at every sample.
pub(crate) struct StateRecorder<F> {
    interval: u64,
    read: F,
    series: Blocking,
    failure: Option<AnalysisError>,
}

impl<F: Fn(&mut System) -> Vec<f64> + Send + 'static> StateRecorder<F> {
    pub(crate) fn boxed(input: &Input, components: usize, read: F) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let series = Blocking::new(components)?;
        Ok(Box::new(Self { interval: input.run.sample_interval, read, series, failure: None }))
    }
}

impl<F: Fn(&mut System) -> Vec<f64> + Send> Recorder for StateRecorder<F> {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step.is_multiple_of(self.interval) {
            let sample = (self.read)(&mut moment.simulation.system);
            self.failure = self.failure.take().or(self.series.record(&sample).err());
        }
    }
}

impl<F: Fn(&mut System) -> Vec<f64> + Send> RouteRecorder for StateRecorder<F> {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, &self.series))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, series): (u64, _) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.series.accepts(&series) {
            return Err(RouteError::OtherState);
        }
        self.series = series;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Series(self.series)),
        }
    }
}
