//! Mobility by stochastic Norton dynamics: the forcing that a constant flux needs (Wu & Shang, eqs 15, 16, 92).

use super::nemd::{component, driven_conditions, fitted, points, rows};
use super::{DrivenRecorder, Outcome, Record, Response, Route, RouteError, RouteRecorder, RunKind};
use mesoflux_analysis::{Estimate, OrderChoice, fit_inverse_response};
use mesoflux_core::forcing::ForcingKind;
use mesoflux_io::input::Input;
use mesoflux_io::results::Table;

/// α from λ(r) = r/α + c r³ + …; with one flux α = r/⟨λ⟩, the error by the delta method.
pub(super) struct Norton {
    pub forcing: ForcingKind,
    pub fluxes: Vec<f64>,
    pub check_forcing_observable: bool,
}

impl Route for Norton {
    fn method(&self) -> &'static str {
        "norton"
    }

    fn runs(&self) -> Vec<RunKind> {
        self.fluxes.iter().map(|&flux| RunKind::Norton { forcing: self.forcing, flux }).collect()
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        Ok(Box::new(DrivenRecorder::new(input.run.sample_interval, self.check_forcing_observable)?))
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let responses = component(records, DrivenRecorder::FORCING)?;
        let Some(points) = points(&self.fluxes, &responses) else {
            return Ok(Outcome::of(Estimate::unknown(
                "cannot tell: too few samples of the forcing for an error; run longer",
            )));
        };
        let curve = fit_inverse_response(&points, OrderChoice::default())?;
        let mut conditions = driven_conditions(records, &curve)?;
        if let [flux] = self.fluxes[..] {
            conditions.insert("flux".to_owned(), flux.into());
        }
        let mut header = vec!["flux [v]", "forcing [f]", "standard_error [f]", "kinetic_temperature [e]"];
        let mut rows = rows(&points, records)?;
        if self.check_forcing_observable {
            header.extend(["forcing_observable [f]", "booked_minus_observable [f]", "standard_error [f]"]);
            for (row, record) in rows.iter_mut().zip(records) {
                let series = record.series()?;
                let observable = series.component(DrivenRecorder::OBSERVABLE);
                // The difference of the two series has its own, smaller error: both see the same trajectory.
                let difference = series.linear(&[0.0, 1.0, 0.0, -1.0]);
                let numbers = [observable.value, difference.value, difference.standard_error];
                row.extend(numbers.map(|number| number.unwrap_or(0.0)));
            }
        }
        let response = points.iter().map(|p| Response { forcing: (p.y, p.standard_error), flux: (p.x, 0.0) }).collect();
        // The fit is of the forcing by the flux.
        let fitted = fitted(&curve, &points).into_iter().map(|(flux, forcing)| (forcing, flux)).collect();
        let table = Some(Table::new(header, rows));
        Ok(Outcome { estimate: curve.coefficient, conditions, table, response, fitted })
    }
}
