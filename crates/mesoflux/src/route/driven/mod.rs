//! Routes that drive the fluid, by a constant force or at a constant flux: what both have in common.

mod flow;
mod nemd;
mod norton;
mod range;
mod recorder;
mod response;
mod transport;

pub(super) use nemd::Nemd;
pub(super) use norton::Norton;
pub use recorder::DrivenRecord;

use super::{Outcome, Record, Response, Route, RouteError, RouteRecorder, RunKind, cells, correlation, relaxation};
use flow::FlowReader;
use mesoflux_analysis::{
    Blocking, Estimate, Histogram, MultipleTau, OrderChoice, ResponseCurve, ResponsePoint, fit_response,
};
use mesoflux_core::driving::DrivenStep;
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_io::input::{CountingInput, DrivenRecordings, Input};
use mesoflux_io::results::Conditions;
use recorder::DrivenRecorder;
use transport::Transport;

/// A number with its unit, v being that of velocities and f that of forces.
pub(super) struct Unit {
    pub name: &'static str,
    pub unit: &'static str,
}

impl Unit {
    /// The column's header.
    fn header(&self) -> String {
        format!("{} [{}]", self.name, self.unit)
    }
}

/// A way to drive: what is imposed, what answers, and what that says of the coefficient α of the linear response R = αη.
pub(super) trait Way: Send + Sync {
    /// The method's name in the results.
    const METHOD: &'static str;
    /// What is imposed.
    const IMPOSED: Unit;
    /// What answers.
    const ANSWER: Unit;
    /// Its place in the record's series.
    const PLACE: usize;

    /// How the fluid is pushed.
    fn forcing(&self) -> &ForcingChoice;

    /// The strengths that are imposed.
    fn strengths(&self) -> &[f64];

    /// What is recorded beside the answer.
    fn recordings(&self) -> DrivenRecordings;

    /// The run at one strength.
    fn run(&self, strength: f64) -> RunKind;

    /// Whether λ(q, p) is averaged, too.
    fn checks_observable(&self) -> bool {
        false
    }

    /// The transport coefficient from the slope of the answer against what is imposed.
    fn coefficient(transport: &Transport, slope: Estimate) -> Estimate;

    /// The asymptotic variance of the estimator of α at one strength, from the answer's mean and asymptotic variance.
    fn asymptotic_variance(strength: f64, answer: &Estimate, variance: &Estimate) -> Estimate;

    /// The point in a figure of R against η.
    fn drawn(point: &ResponsePoint) -> Response;
}

/// The route by a way of driving.
pub(super) struct Driven<W>(pub W);

impl<W: Way> Route for Driven<W> {
    fn method(&self) -> &'static str {
        W::METHOD
    }

    fn runs(&self) -> Vec<RunKind> {
        self.0.strengths().iter().map(|&strength| self.0.run(strength)).collect()
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let DrivenRecordings { autocorrelation, histogram, profile } = self.0.recordings();
        let observable = self.0.checks_observable();
        let correlation_interval =
            correlation::interval(input, autocorrelation.and_then(|asked| asked.sample_interval));
        let spacing = correlation_interval as f64 * input.dynamics.time_step;
        let flow = profile.and_then(|asked| FlowReader::new(input, self.0.forcing(), asked.bins as usize));
        let correlator = || MultipleTau::autocorrelation(spacing)?.remove_mean(0);
        let counter = |CountingInput { range: [low, high], bins }| Histogram::new(low, high, bins as usize);
        Ok(Box::new(DrivenRecorder {
            interval: input.run.sample_interval,
            correlation_interval,
            answer: W::PLACE,
            observable,
            sum: DrivenStep { flux: 0.0, forcing: 0.0 },
            record: DrivenRecord {
                series: Blocking::new(if observable { 5 } else { 4 })?,
                autocorrelation: autocorrelation.map(|_| correlator()).transpose()?,
                histogram: histogram.map(counter).transpose()?,
                profile: flow.as_ref().map_or(Ok(Vec::new()), FlowReader::series)?,
            },
            flow,
            failure: None,
        }))
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let records: Vec<&DrivenRecord> = records.iter().map(Record::driven).collect::<Result<_, _>>()?;
        let (strengths, forcing) = (self.0.strengths(), self.0.forcing());
        let answers: Vec<Estimate> = records.iter().map(|record| record.series.component(W::PLACE)).collect();
        let mut outcome = self.outcome_of_curve(input, &answers)?;
        for (strength, answer) in strengths.iter().zip(&answers).filter(|(_, answer)| answer.standard_error.is_some()) {
            let warning = |warning| format!("at {} = {strength}: {warning}", W::IMPOSED.name);
            outcome.estimate.warnings.extend(answer.warnings.iter().map(warning));
        }
        let temperatures = records.iter().filter_map(|record| record.series.component(DrivenRecord::TEMPERATURE).value);
        let hottest = temperatures.fold(f64::NEG_INFINITY, f64::max);
        if hottest.is_finite() {
            outcome.conditions.insert("highest_kinetic_temperature".to_owned(), hottest.into());
        }
        if let [strength] = strengths {
            outcome.conditions.insert(W::IMPOSED.name.to_owned(), (*strength).into());
        }
        let spacing = input.run.sample_interval as f64 * input.dynamics.time_step;
        let memories = response::memories::<W>(&records, spacing)?;
        let table = response::table::<W>(strengths, &records, &memories, self.0.checks_observable());
        outcome.tables.push(("", table));
        let DrivenRecordings { autocorrelation, histogram, profile } = self.0.recordings();
        if let Some(asked) = autocorrelation {
            let unknown = response::unknown_memories::<W>(strengths, &memories);
            if !unknown.is_empty() {
                outcome.conditions.insert("asymptotic_variance_unknown".to_owned(), unknown.join("; ").into());
            }
            outcome.tables.push(("autocorrelation", response::autocorrelation::<W>(strengths, &records, asked)));
        }
        if histogram.is_some() {
            response::histogram::<W>(&mut outcome, strengths, &records);
        }
        if profile.is_some() {
            let profiles: Vec<&[Blocking]> = records.iter().map(|record| &record.profile[..]).collect();
            flow::report::<W>(&mut outcome, input, forcing.wave.gradient as usize, strengths, &profiles);
        }
        Ok(outcome)
    }
}

impl<W: Way> Driven<W> {
    /// The coefficient from the answers at all strengths but zero.
    fn outcome_of_curve(&self, input: &Input, answers: &[Estimate]) -> Result<Outcome, RouteError> {
        let transport = Transport::new(input, self.0.forcing());
        let strengths = self.0.strengths();
        let driven = strengths.iter().zip(answers).filter(|(strength, _)| **strength != 0.0);
        let points: Option<Vec<ResponsePoint>> =
            driven.map(|(&strength, answer)| ResponsePoint::new(strength, answer)).collect();
        let mut outcome = match points.as_deref() {
            None => Outcome::of(Estimate::unknown(format!(
                "cannot tell: too few samples of the {} for an error; run longer",
                W::ANSWER.name
            ))),
            Some([]) => Outcome::of(Estimate::unknown(format!(
                "cannot tell: every {} is zero, where nothing responds; give one that is not",
                W::IMPOSED.name
            ))),
            Some(points) => {
                let curve = fit_response(points, OrderChoice::default())?;
                let range = range::linear_range(points, &curve);
                let slope = curve.coefficient.clone();
                let mut outcome = Outcome::of(W::coefficient(&transport, slope));
                outcome.conditions = curve_conditions(&curve);
                outcome.response = points.iter().map(W::drawn).collect();
                outcome.fitted = fitted::<W>(&curve, points);
                outcome.slope = curve.coefficient.value.map(|slope| {
                    let (forcing, flux) = drawn::<W>(1.0, slope);
                    flux / forcing
                });
                range.report::<W>(&mut outcome);
                outcome
            }
        };
        outcome.conditions.extend(transport.conditions());
        if matches!(transport, Transport::Mobility) {
            // D = kT α.
            let diffusion = outcome.estimate.scaled(input.dynamics.temperature);
            relaxation::report(&mut outcome, input, &diffusion);
        }
        Ok(outcome)
    }
}

/// A point of the curve of the answer y against what is imposed, as (forcing, flux).
fn drawn<W: Way>(x: f64, y: f64) -> (f64, f64) {
    let point = W::drawn(&ResponsePoint { x, y, standard_error: 0.0, effective_samples: 0.0 });
    (point.forcing.0, point.flux.0)
}

/// αx + βx³ + … over the x of the points and zero, as (forcing, flux); empty for the straight line.
fn fitted<W: Way>(curve: &ResponseCurve, points: &[ResponsePoint]) -> Vec<(f64, f64)> {
    const SEGMENTS: u32 = 60;
    if curve.order() < 2 {
        return Vec::new();
    }
    let low = points.iter().map(|point| point.x).fold(0.0, f64::min);
    let high = points.iter().map(|point| point.x).fold(0.0, f64::max);
    let answer = |x: f64| x * curve.polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * x * x + coefficient);
    let x = (0..=SEGMENTS).map(|k| low + (high - low) * f64::from(k) / f64::from(SEGMENTS));
    x.map(|x| drawn::<W>(x, answer(x))).collect()
}

/// Whether the response is linear.
pub(super) fn curve_conditions(curve: &ResponseCurve) -> Conditions {
    let mut conditions = Conditions::new();
    if let Some(linear) = curve.linear {
        conditions.insert("linear".to_owned(), linear.into());
        conditions.insert("fitted_powers".to_owned(), curve.order().into());
    }
    if let (Some(value), Some(error)) = (curve.nonlinearity.value, curve.nonlinearity.standard_error) {
        conditions.insert("nonlinearity".to_owned(), value.into());
        conditions.insert("nonlinearity_standard_error".to_owned(), error.into());
    }
    conditions
}
