//! Shear viscosity by an exchange of momentum between two slabs (Müller-Plathe 1999; Naseri et al., section 3.3).

mod point;
mod record;
mod recorder;
mod report;

pub use record::ExchangeRecord;

use super::{Outcome, Record, Route, RouteError, RouteRecorder, RunKind};
use mesoflux_analysis::{Estimate, OrderChoice, ResponsePoint, fit_response};
use mesoflux_core::driving::{Exchanged, Slabs};
use mesoflux_io::input::{Input, MeasureInput, MomentumExchangeInput};
use point::Point;
use recorder::{ExchangeRecorder, Reader};

/// μ = Π/|dv/dx|: the stress by what is exchanged, the gradient by a fit over the middle of both halves of the fluid.
///
/// With several strengths the viscosity is that at vanishing stress, one over the slope of the gradient's response
/// |dv/dx| = Π/μ + βΠ³ + …; that of each strength is in the table.
pub(super) struct MomentumExchange {
    slabs: Slabs,
    parameters: MomentumExchangeInput,
}

impl MomentumExchange {
    pub fn new(measure: &MeasureInput, parameters: MomentumExchangeInput) -> Self {
        Self { slabs: parameters.slabs(measure), parameters }
    }

    fn reader(&self, input: &Input) -> Result<Reader, RouteError> {
        Reader::new(input, &self.parameters, self.slabs)
    }
}

impl Route for MomentumExchange {
    fn method(&self) -> &'static str {
        "momentum_exchange"
    }

    fn runs(&self) -> Vec<RunKind> {
        let run = |(strength, interval)| RunKind::MomentumExchange {
            slabs: self.slabs,
            strength,
            interval,
            predicted_viscosity: self.parameters.predicted_viscosity,
        };
        self.parameters.points().into_iter().map(run).collect()
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let reader = self.reader(input)?;
        Ok(Box::new(ExchangeRecorder {
            interval: input.run.sample_interval,
            reader,
            sum: Exchanged::default(),
            energy: None,
            record: ExchangeRecord::new(reader.numbers()),
            failure: None,
        }))
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let reader = self.reader(input)?;
        let point = |(strength, record): (_, &Record)| match record {
            Record::Exchange(record) => Point::new(input, &reader, strength, record),
            _ => Err(RouteError::WrongRecord),
        };
        let points: Vec<Point> =
            self.parameters.points().into_iter().zip(records).map(point).collect::<Result<_, _>>()?;
        let mut outcome = viscosity(&points)?;
        report::complete(&mut outcome, input, &reader, &points);
        Ok(outcome)
    }
}

/// The viscosity at vanishing stress.
fn viscosity(points: &[Point]) -> Result<Outcome, RouteError> {
    if let [point] = points {
        let mut outcome = Outcome::of(point.viscosity.clone());
        if let (Some(_), false) = (point.viscosity.value, point.viscosity.standard_error.is_none()) {
            outcome.estimate.warnings.push("one stress alone: whether the fluid is Newtonian can't be told".to_owned());
        }
        return Ok(outcome);
    }
    // The error of a measured stress counts with that of the gradient: the relative error is the viscosity's.
    let response = |point: &Point| {
        let (gradient, relative) = (point.gradient.value?, point.viscosity.relative_error()?);
        let error = gradient.abs() * relative;
        ResponsePoint::new(point.stress.value?, &Estimate::new(gradient, error, point.gradient.effective_samples))
    };
    let Some(curve) = points.iter().map(response).collect::<Option<Vec<_>>>() else {
        let reason = "cannot tell: at one of the strengths the gradient is unknown, or lost in its error; run longer";
        return Ok(Outcome::of(Estimate::unknown(reason)));
    };
    let curve = fit_response(&curve, OrderChoice::default())?;
    let mut outcome = Outcome::of(curve.coefficient.clone().inverse());
    outcome.conditions = super::driven::curve_conditions(&curve);
    Ok(outcome)
}
