//! Recorder of a profile: many numbers at every sample, each a series of its own.

use super::{Record, RouteError, RouteRecorder};
use mesoflux_analysis::{AnalysisError, Blocking};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::system::System;
use mesoflux_io::input::Input;
use mesoflux_io::stream;
use std::io::{self, Write};

/// Records each number that `read` takes from the system as a series of its own: the correlations between them, of which there
/// would be as many as pairs of numbers, are not kept.
pub(super) struct ProfileRecorder<F> {
    interval: u64,
    read: F,
    series: Vec<Blocking>,
    failure: Option<AnalysisError>,
}

impl<F: Fn(&System) -> Vec<f64> + Send + 'static> ProfileRecorder<F> {
    pub(super) fn boxed(input: &Input, numbers: usize, read: F) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let series = (0..numbers).map(|_| Blocking::new(1)).collect::<Result<_, _>>()?;
        Ok(Box::new(Self { interval: input.run.sample_interval, read, series, failure: None }))
    }
}

impl<F: Fn(&System) -> Vec<f64> + Send> Recorder for ProfileRecorder<F> {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step.is_multiple_of(self.interval) {
            for (series, number) in self.series.iter_mut().zip((self.read)(&moment.simulation.system)) {
                self.failure = self.failure.take().or(series.record(&[number]).err());
            }
        }
    }
}

impl<F: Fn(&System) -> Vec<f64> + Send> RouteRecorder for ProfileRecorder<F> {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, &self.series))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, series): (u64, Vec<Blocking>) = postcard::from_bytes(state)?;
        let fits =
            series.len() == self.series.len() && self.series.iter().zip(&series).all(|(own, kept)| own.accepts(kept));
        if interval != self.interval || !fits {
            return Err(RouteError::OtherState);
        }
        self.series = series;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Profile(self.series)),
        }
    }
}
