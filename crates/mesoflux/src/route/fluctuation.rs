//! The isothermal compressibility from the fluctuations of the density: S(0) = ρ kT κ_T, S(k) extrapolated from the smallest k.

use super::average::StateRecorder;
use super::compressibility::Wanted;
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells};
use mesoflux_analysis::{Blocking, Estimate, polynomial_functionals};
use mesoflux_core::observable::{Shell, shells, structure_factors};
use mesoflux_io::input::{FluctuationInput, Input};
use mesoflux_io::results::{Conditions, Table};

/// A term in k⁶ beyond so many of its standard errors counts as present.
const PRESENT: f64 = 3.0;
/// 1/S(0) within so many standard errors of zero has no inverse.
const FEWEST_ERRORS: f64 = 3.0;

/// κ_T = S(0)/(ρ kT) of a fluid of one species.
///
/// 1/S(k) = 1 − ρ c(k) is a power series in k² because the direct correlation function c has a short range (Ornstein and Zernike):
/// a parabola in k² is fitted, and one power more where its k⁶ term is seen. (A line through the shortest shells is as noisy, and
/// 1.4 % too low for the soft fluid of Groot and Warren in a box of five cutoffs.) Each shell of wave vectors weighs as many vectors
/// as it has times k², as a sound wave is forgotten in a time that goes as 1/k². In a box with a fixed number of particles S vanishes
/// at k = 0 itself, but the limit from the other wave vectors is that of the unbounded fluid.
pub(super) struct Fluctuation {
    pub wanted: Wanted,
    pub parameters: FluctuationInput,
}

impl Fluctuation {
    fn shells(&self, input: &Input) -> Vec<Shell> {
        // The input was found right, its box with it.
        let region = input.region();
        region.map_or_else(|_| Vec::new(), |region| shells(&region, input.largest_wave_number(&self.parameters)))
    }
}

impl Route for Fluctuation {
    fn method(&self) -> &'static str {
        "fluctuation"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let shells = self.shells(input);
        StateRecorder::boxed(input, shells.len(), move |system| {
            structure_factors(&system.particles, &system.region, &shells, system.workers)
        })
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let (series, shells) = (records[0].series()?, self.shells(input));
        let squares: Vec<f64> = shells.iter().map(|shell| shell.wave_number.powi(2)).collect();
        let weights: Vec<f64> = shells.iter().zip(&squares).map(|(shell, k)| shell.waves.len() as f64 * k).collect();
        let parabola = polynomial_functionals(&squares, &weights, 3)?;
        let cubic = polynomial_functionals(&squares, &weights, 4).ok().filter(|_| shells.len() > 4);
        let seen = |cubic: &Vec<Vec<f64>>| {
            inverse_sum(series, &cubic[3]).z_score_against(0.0, 0.0).is_some_and(|z| z.abs() > PRESENT)
        };
        let fit = cubic.filter(seen).unwrap_or(parabola);
        let inverse = inverse_sum(series, &fit[0]);
        let density = input.particles() as f64 / input.sides().iter().product::<f64>();
        let estimate = inverted(&inverse).scaled((density * input.dynamics.temperature).recip());
        let conditions = Conditions::from([("fitted_powers".to_owned(), fit.len().into())]);
        let rows = shells.iter().enumerate().map(|(index, shell)| {
            let factor = series.component(index);
            let numbers = cells(&factor);
            vec![shell.wave_number, numbers[0], numbers[1], shell.waves.len() as f64]
        });
        let header = ["wave_number [1/l]", "structure_factor [1]", "standard_error [1]", "wave_vectors [1]"];
        Ok(Outcome {
            conditions,
            tables: vec![("", Table::new(header, rows.collect()))],
            ..Outcome::of(self.wanted.of_compressibility(estimate, input))
        })
    }
}

/// Σ c_s/S_s over shells.
fn inverse_sum(series: &Blocking, functional: &[f64]) -> Estimate {
    let terms = |mean: &[f64], power: i32| -> Vec<f64> {
        functional.iter().zip(mean).map(|(c, factor)| c / factor.powi(power)).collect()
    };
    series.function(|mean| terms(mean, 1).iter().sum(), |mean| terms(mean, 2).iter().map(|term| -term).collect())
}

/// 1/x, its error by the delta method.
fn inverted(estimate: &Estimate) -> Estimate {
    match (estimate.value, estimate.standard_error) {
        (Some(value), Some(error)) if value.abs() > FEWEST_ERRORS * error => {
            Estimate { value: Some(value.recip()), standard_error: Some(error / (value * value)), ..estimate.clone() }
        }
        (Some(_), Some(_)) => {
            Estimate::unknown("cannot tell: 1/S(0) lies within three standard errors of zero; run longer")
        }
        _ => Estimate { value: None, ..estimate.clone() },
    }
}
