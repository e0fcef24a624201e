//! The isothermal compressibility κ_T from the pressure at neighboring densities, and the speed of sound that follows from it.

use super::average::StateRecorder;
use super::{Outcome, Record, Route, RouteError, RouteRecorder, RunKind, cell};
use mesoflux_analysis::{Estimate, OrderChoice, ResponsePoint, fit_inverse_response};
use mesoflux_core::observable::Thermodynamics;
use mesoflux_io::input::Input;
use mesoflux_io::results::{Conditions, Table};

/// What the compressibility is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// κ_T itself.
    Compressibility,
    /// c_T = √(1/(ρ_m κ_T)), the speed of sound of long waves where a thermostat acts everywhere.
    SoundSpeed,
}

impl Wanted {
    /// The estimate of what is wanted from that of κ_T.
    pub(super) fn of_compressibility(self, compressibility: Estimate, input: &Input) -> Estimate {
        let (Self::SoundSpeed, Some(value)) = (self, compressibility.value) else {
            return compressibility;
        };
        if value <= 0.0 {
            return Estimate::unknown(format!("cannot tell: the compressibility is {value:e}, where no sound travels"));
        }
        let mass: f64 =
            input.masses().iter().zip(input.species_counts()).map(|(mass, count)| mass * count as f64).sum();
        let density = mass / input.sides().iter().product::<f64>();
        let speed = (density * value).sqrt().recip();
        Estimate {
            value: Some(speed),
            standard_error: compressibility.standard_error.map(|error| 0.5 * speed * error / value),
            ..compressibility
        }
    }
}

/// κ_T from P(ρ(1 + δ)) − P(ρ(1 − δ)) = 2δ/κ_T + O(δ³), in runs of their own.
///
/// Half that difference is an odd function of δ: with several δ the cubic term is fitted and, where it counts, removed.
pub(super) struct Derivative {
    pub wanted: Wanted,
    pub density_steps: Vec<f64>,
}

impl Derivative {
    const PRESSURE: usize = 0;
    const TEMPERATURE: usize = 1;
}

impl Route for Derivative {
    fn method(&self) -> &'static str {
        "derivative"
    }

    fn runs(&self) -> Vec<RunKind> {
        let both = |&step: &f64| [1.0 + step, 1.0 - step].map(|factor| RunKind::AtDensity { factor });
        self.density_steps.iter().flat_map(both).collect()
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        StateRecorder::boxed(input, 2, |system| {
            let state = Thermodynamics::of(system);
            vec![state.pressure, state.kinetic_temperature]
        })
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let estimate = |record: &Record, component| Ok(record.series()?.component(component));
        let pressures: Vec<Estimate> =
            records.iter().map(|record| estimate(record, Self::PRESSURE)).collect::<Result<_, RouteError>>()?;
        let point =
            |(&step, pair): (&f64, &[Estimate])| ResponsePoint::new(step, &half_difference(&pair[0], &pair[1])?);
        let points: Option<Vec<ResponsePoint>> =
            self.density_steps.iter().zip(pressures.chunks(2)).map(point).collect();
        let Some(points) = points else {
            return Ok(Outcome::of(Estimate::unknown(
                "cannot tell: too few samples of the pressure for an error; run longer",
            )));
        };
        let curve = fit_inverse_response(&points, OrderChoice::default())?;
        let mut conditions = Conditions::new();
        if let Some(linear) = curve.linear {
            conditions.insert("linear".to_owned(), linear.into());
            conditions.insert("fitted_powers".to_owned(), curve.order().into());
        }
        let density = input.particles() as f64 / input.sides().iter().product::<f64>();
        let factors = self.density_steps.iter().flat_map(|&step| [1.0 + step, 1.0 - step]);
        let mut rows = Vec::new();
        for ((factor, pressure), record) in factors.zip(&pressures).zip(records) {
            let temperature = estimate(record, Self::TEMPERATURE)?;
            let numbers = [pressure.value, pressure.standard_error, temperature.value];
            rows.push([Some(density * factor)].into_iter().chain(numbers).map(cell).collect());
        }
        rows.sort_by(|a: &Vec<f64>, b| a[0].total_cmp(&b[0]));
        let header = ["density [1/l^3]", "pressure [e/l^3]", "standard_error [e/l^3]", "kinetic_temperature [e]"];
        Ok(Outcome {
            conditions,
            tables: vec![("", Table::new(header, rows))],
            ..Outcome::of(self.wanted.of_compressibility(curve.coefficient, input))
        })
    }
}

/// (a − b)/2 of two independent estimates; its effective samples by Welch and Satterthwaite's formula.
fn half_difference(a: &Estimate, b: &Estimate) -> Option<Estimate> {
    let [first, second] = [a.standard_error?.powi(2), b.standard_error?.powi(2)];
    let degrees = (first + second).powi(2)
        / (first.powi(2) / (a.effective_samples - 1.0) + second.powi(2) / (b.effective_samples - 1.0));
    Some(Estimate::new(0.5 * (a.value? - b.value?), 0.5 * (first + second).sqrt(), degrees + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_difference_and_its_error() {
        let half = half_difference(&Estimate::new(5.0, 0.6, 11.0), &Estimate::new(1.0, 0.8, 11.0)).unwrap();
        assert_eq!((half.value, half.standard_error), (Some(2.0), Some(0.5)));
        // (0.36 + 0.64)²/(0.36²/10 + 0.64²/10) = 18.55.
        assert!((half.effective_samples - 19.546).abs() < 1e-2, "{}", half.effective_samples);
        assert!(half_difference(&Estimate::unknown("short"), &Estimate::new(1.0, 0.8, 11.0)).is_none());
    }
}
