//! How long an observable remembers: its correlation time and asymptotic variance, by correlation and by blocking.

use super::average::StateRecorder;
use super::correlation::{CorrelationRecorder, Sample, Sampler};
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells, observable};
use mesoflux_analysis::{AutocorrelationTime, MultipleTau, Quadrature};
use mesoflux_core::run::Moment;
use mesoflux_core::system::System;
use mesoflux_io::input::{CorrelationInput, Input, Observable, Quantity};
use mesoflux_io::results::Table;

/// τ = ∫₀^∞ C(t)/C(0) dt or σ² = 2∫₀^∞ C(t) dt of an observable.
pub(super) struct Memory {
    pub observable: Observable,
    pub quantity: Quantity,
    /// By correlation; by blocking without.
    pub correlation: Option<CorrelationInput>,
}

impl Memory {
    fn interval(&self, input: &Input) -> u64 {
        self.correlation.and_then(|given| given.sample_interval).unwrap_or(input.run.sample_interval)
    }

    fn spacing(&self, input: &Input) -> f64 {
        self.interval(input) as f64 * input.dynamics.time_step
    }

    fn outcome(&self, found: AutocorrelationTime) -> Outcome {
        let asked = if self.quantity == Quantity::CorrelationTime { found.time } else { found.asymptotic_variance };
        let mut outcome = Outcome::of(asked);
        if let Some(inefficiency) = found.statistical_inefficiency.value {
            outcome.conditions.insert("statistical_inefficiency".to_owned(), inefficiency.into());
        }
        outcome
    }
}

/// Reads one observable.
struct One(fn(&mut System) -> f64);

impl Sampler for One {
    fn sample(&mut self, moment: &mut Moment) -> Sample {
        let value = self.0(&mut moment.simulation.system);
        Sample { channels: vec![vec![value]], averages: vec![value] }
    }
}

impl Route for Memory {
    fn method(&self) -> &'static str {
        if self.correlation.is_some() { "correlation" } else { "blocking" }
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let read = observable::reader(self.observable);
        if self.correlation.is_none() {
            return StateRecorder::boxed(input, 1, move |system| vec![read(system)]);
        }
        let correlator = MultipleTau::autocorrelation(self.spacing(input))?.remove_mean(0)?;
        CorrelationRecorder::boxed(self.interval(input), One(read), vec![correlator], 1)
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        if self.correlation.is_none() {
            let spacing = self.spacing(input);
            return Ok(self.outcome(records[0].series()?.autocorrelation_time(&[1.0], spacing)?));
        }
        let function = &records[0].correlations()?.functions[0];
        let mut outcome = self.outcome(function.autocorrelation_time());
        let rows = function.table(Quadrature::Summed).into_iter().map(|point| {
            let [correlation, error] = cells(&point.correlation);
            vec![point.time, correlation, error]
        });
        let header = ["time [t]", "autocorrelation [squared observable]", "standard_error [squared observable]"];
        outcome.tables.push(("", Table::new(header, rows.collect())));
        Ok(outcome)
    }
}
