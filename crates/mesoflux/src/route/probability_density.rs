//! The probability density of an observable, by counting its values in bins.

use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells, observable};
use mesoflux_analysis::{AnalysisError, Estimate, Histogram};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::system::System;
use mesoflux_io::input::{CountingInput, Input, Observable};
use mesoflux_io::results::Table;
use mesoflux_io::stream;
use std::io::{self, Write};

/// The density in each bin as a table; the estimate is the highest of them, and where it is.
pub(super) struct ProbabilityDensity {
    pub observable: Observable,
    pub parameters: CountingInput,
}

impl Route for ProbabilityDensity {
    fn method(&self) -> &'static str {
        "counting"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let CountingInput { range: [low, high], bins } = self.parameters;
        let histogram = Histogram::new(low, high, bins as usize)?;
        let read = observable::reader(self.observable);
        Ok(Box::new(Counter { interval: input.run.sample_interval, read, histogram, failure: None }))
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let [Record::Histogram(histogram)] = records else {
            return Err(RouteError::WrongRecord);
        };
        let bins = histogram.bins();
        let highest = bins.iter().max_by_key(|bin| bin.count).filter(|bin| bin.count > 0);
        let mut outcome = match highest {
            Some(bin) => {
                let mut outcome = Outcome::of(bin.density.clone());
                outcome.conditions.insert("at".to_owned(), (0.5 * (bin.low + bin.high)).into());
                outcome
            }
            None => Outcome::of(Estimate::unknown("cannot tell: no value lay in the range")),
        };
        let outside = histogram.underflow() + histogram.overflow();
        if outside > 0 {
            let (low, high, all) = (histogram.underflow(), histogram.overflow(), histogram.count());
            let warning = format!("{low} of {all} values lay below the range, {high} above");
            outcome.estimate = outcome.estimate.with_warning(warning);
        }
        let rows = bins.iter().map(|bin| {
            let [density, error] = cells(&bin.density);
            vec![bin.low, bin.high, density, error, bin.count as f64]
        });
        let header = ["low [x]", "high [x]", "density [1/x]", "standard_error [1/x]", "count"];
        outcome.tables.push(("", Table::new(header, rows.collect())));
        Ok(outcome)
    }
}

/// Counts an observable at every sample.
struct Counter {
    interval: u64,
    read: fn(&mut System) -> f64,
    histogram: Histogram,
    failure: Option<AnalysisError>,
}

impl Recorder for Counter {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step.is_multiple_of(self.interval) {
            let value = (self.read)(&mut moment.simulation.system);
            self.failure = self.failure.take().or(self.histogram.record(value).err());
        }
    }
}

impl RouteRecorder for Counter {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, &self.histogram))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, histogram): (u64, _) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.histogram.accepts(&histogram) {
            return Err(RouteError::OtherState);
        }
        self.histogram = histogram;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Histogram(self.histogram)),
        }
    }
}
