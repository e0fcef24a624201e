//! Mobility by nonequilibrium molecular dynamics: the flux that a constant force drives (Wu & Shang, eqs 8, 9).

use super::{DrivenRecorder, Outcome, Record, Response, Route, RouteError, RouteRecorder, RunKind};
use mesoflux_analysis::{Estimate, OrderChoice, ResponseCurve, ResponsePoint, fit_response};
use mesoflux_core::forcing::ForcingKind;
use mesoflux_io::input::Input;
use mesoflux_io::results::{Conditions, Table};

/// α from R(η) = αη + βη³ + …; with one magnitude α = R/η.
pub(super) struct Nemd {
    pub forcing: ForcingKind,
    pub magnitudes: Vec<f64>,
}

impl Route for Nemd {
    fn method(&self) -> &'static str {
        "nemd"
    }

    fn runs(&self) -> Vec<RunKind> {
        self.magnitudes.iter().map(|&magnitude| RunKind::Nemd { forcing: self.forcing, magnitude }).collect()
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        Ok(Box::new(DrivenRecorder::new(input.run.sample_interval, false)?))
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let responses = component(records, DrivenRecorder::FLUX)?;
        let Some(points) = points(&self.magnitudes, &responses) else {
            return Ok(Outcome::of(Estimate::unknown(
                "cannot tell: too few samples of the flux for an error; run longer",
            )));
        };
        let curve = fit_response(&points, OrderChoice::default())?;
        let mut conditions = driven_conditions(records, &curve)?;
        if let [magnitude] = self.magnitudes[..] {
            conditions.insert("magnitude".to_owned(), magnitude.into());
        }
        let header = vec!["magnitude [f]", "flux [v]", "standard_error [v]", "kinetic_temperature [e]"];
        let table = Some(Table::new(header, rows(&points, records)?));
        let response = points.iter().map(|p| Response { forcing: (p.x, 0.0), flux: (p.y, p.standard_error) }).collect();
        let fitted = fitted(&curve, &points);
        Ok(Outcome { estimate: curve.coefficient, conditions, table, response, fitted })
    }
}

/// The estimate of one component from each record.
pub(super) fn component(records: &[Record], index: usize) -> Result<Vec<Estimate>, RouteError> {
    records.iter().map(|record| Ok(record.series()?.component(index))).collect()
}

/// Points of the response curve; `None` if one has no error.
pub(super) fn points(strengths: &[f64], responses: &[Estimate]) -> Option<Vec<ResponsePoint>> {
    strengths.iter().zip(responses).map(|(&x, response)| ResponsePoint::new(x, response)).collect()
}

/// y = αx + βx³ + … over the x of the points and zero, as (x, y); empty for the straight line.
pub(super) fn fitted(curve: &ResponseCurve, points: &[ResponsePoint]) -> Vec<(f64, f64)> {
    const SEGMENTS: u32 = 60;
    if curve.order() < 2 {
        return Vec::new();
    }
    let low = points.iter().map(|point| point.x).fold(0.0, f64::min);
    let high = points.iter().map(|point| point.x).fold(0.0, f64::max);
    let response = |x: f64| x * curve.polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * x * x + coefficient);
    let x = (0..=SEGMENTS).map(|k| low + (high - low) * f64::from(k) / f64::from(SEGMENTS));
    x.map(|x| (x, response(x))).collect()
}

/// The rows of the response curve's table.
pub(super) fn rows(points: &[ResponsePoint], records: &[Record]) -> Result<Vec<Vec<f64>>, RouteError> {
    let temperatures = component(records, DrivenRecorder::TEMPERATURE)?;
    let row = |(point, temperature): (&ResponsePoint, Estimate)| {
        vec![point.x, point.y, point.standard_error, temperature.value.unwrap_or(0.0)]
    };
    Ok(points.iter().zip(temperatures).map(row).collect())
}

/// What every driven estimate carries: the temperatures measured beside, and whether the response is linear.
pub(super) fn driven_conditions(records: &[Record], curve: &ResponseCurve) -> Result<Conditions, RouteError> {
    let mut conditions = Conditions::new();
    let temperatures = component(records, DrivenRecorder::TEMPERATURE)?;
    let hottest = temperatures.iter().filter_map(|estimate| estimate.value).fold(f64::NEG_INFINITY, f64::max);
    if hottest.is_finite() {
        conditions.insert("highest_kinetic_temperature".to_owned(), hottest.into());
    }
    if let Some(linear) = curve.linear {
        conditions.insert("linear".to_owned(), linear.into());
        conditions.insert("fitted_powers".to_owned(), curve.order().into());
    }
    if let (Some(value), Some(error)) = (curve.nonlinearity.value, curve.nonlinearity.standard_error) {
        conditions.insert("nonlinearity".to_owned(), value.into());
        conditions.insert("nonlinearity_standard_error".to_owned(), error.into());
    }
    Ok(conditions)
}
