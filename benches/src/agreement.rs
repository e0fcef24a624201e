//! Whether both programs do the same physics: kinetic temperature and pressure at the same settings.
//!
//! Velocity Verlet is the same algorithm in both: LAMMPS evaluates its pair forces with the velocities of the half step, which is
//! Groot and Warren's prediction with λ = ½. There the two must agree within a percent and four standard errors. (With 3000
//! particles of Groot and Warren's fluid: temperature 1.0112(12) here, 1.0118(16) there.)
//!
//! LAMMPS' virial also holds friction and noise. The noise averages out, in the ideal fluid only over very long runs. Friction, taken with
//! the positions at the end of the step and the velocities of its middle, leaves −γΔt kT/(3V) Σ_pairs ∇²W with W' = r ω(r): of
//! first order in Δt, 0.050 for Groot and Warren's fluid, which is all of the 0.05 by which its pressure is above ours.
//!
//! ABOBA and LAMMPS' scheme have different errors of order Δt²: their kinetic temperatures are 1.009 and 1.012 for Groot and
//! Warren's fluid, 1.009 and 0.998 for the Lennard-Jones liquid. Three percent are allowed there.

use crate::failure::Failure;
use crate::lammps::{Lammps, Run, Variant};
use crate::options::Options;
use crate::task::Task;
use crate::work::{Scheme, Work};
use mesoflux_analysis::{Blocking, Estimate};
use serde::{Deserialize, Serialize};

/// Relative difference that is allowed between the same scheme in both programs.
const SAME_SCHEME: f64 = 0.01;
/// The same between schemes with different errors of order Δt².
const OTHER_SCHEME: f64 = 0.03;
/// Standard errors that two results may be apart on top of what the schemes may differ by.
const STANDARD_ERRORS: f64 = 4.0;

/// One quantity of both programs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// The work.
    pub work: String,
    /// Our integrator.
    pub integrator: String,
    /// Temperature or pressure.
    pub quantity: String,
    /// Ours.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// LAMMPS', with the normalization of ours.
    pub lammps_value: f64,
    /// Its standard error.
    pub lammps_standard_error: f64,
    /// The difference of the two that is not yet a failure.
    pub allowed: f64,
    /// The date on which this was found.
    pub date: String,
}

impl Agreement {
    /// The difference over its standard error.
    pub fn z_score(&self) -> f64 {
        (self.value - self.lammps_value) / self.standard_error.hypot(self.lammps_standard_error)
    }

    /// Fails where the two are too far apart.
    fn check(&self) -> Result<(), Failure> {
        let difference = (self.value - self.lammps_value).abs();
        if difference <= self.allowed {
            return Ok(());
        }
        let Self { work, integrator, quantity, value, standard_error, lammps_value, lammps_standard_error, .. } = self;
        Err(Failure::Disagreement(format!(
            "{work}: mesoflux ({integrator}) and LAMMPS do not do the same physics: {quantity} {value:.5} ± {standard_error:.5} \
             against {lammps_value:.5} ± {lammps_standard_error:.5}; must not be more than {:.5} apart",
            self.allowed
        )))
    }
}

/// Compares both quantities for every scheme of a work that is timed.
pub fn check(options: &Options, work: &Work, lammps: &Lammps, date: &str) -> Result<Vec<Agreement>, Failure> {
    // A short trial needs no long samples: its errors only come out larger.
    let sampled = ((work.sampled as f64 * (options.seconds / 4.0).min(1.0)) as u64).max(200);
    let run = Run { steps: 1, sampled, ..options.lammps_run(work, 1) };
    let theirs = lammps.run(Variant::Plain, &run)?;
    let mut found = Vec::new();
    for &scheme in work.schemes {
        // Our momenta start at a temperature that fluctuates, LAMMPS' at exactly the mean: ours get longer to settle.
        let task = Task { sampled, warm_up: work.warm_up + sampled, ..options.task(work, scheme) };
        let ours = task.perform()?;
        let input = crate::setup::read(&task.input, &task.settings)?;
        let (particles, volume) = (input.particles() as f64, input.sides().iter().product::<f64>());
        // How far the mean temperature of so short a run is bound to stray, which no series of that length can tell:
        // a single moment has the variance 2T²/(3N), and the mean at least 2τ/t of it.
        let remembered = (2.0 * work.relaxation as f64 / sampled as f64).min(1.0);
        let stray = input.dynamics.temperature * (remembered * 2.0 / (3.0 * particles)).sqrt();
        let relative = match scheme {
            Scheme::VelocityVerlet => SAME_SCHEME,
            Scheme::Aboba => OTHER_SCHEME,
        };
        for (component, quantity) in ["temperature", "pressure"].into_iter().enumerate() {
            let least = if quantity == "pressure" { stray * particles / volume } else { stray };
            let (value, standard_error) = mean(&ours.samples, component, least);
            let (mut lammps_value, lammps_standard_error) = mean(&theirs.samples, component, least);
            if quantity == "pressure" {
                // LAMMPS counts (N − 1) kT of kinetic pressure, we N kT.
                lammps_value += mean(&theirs.samples, 0, stray).0 / volume;
            }
            let allowed = relative * lammps_value.abs() + STANDARD_ERRORS * standard_error.hypot(lammps_standard_error);
            let (work, integrator) = (work.name.to_owned(), scheme.name().to_owned());
            let (quantity, date) = (quantity.to_owned(), date.to_owned());
            found.push(Agreement {
                work,
                integrator,
                quantity,
                value,
                standard_error,
                lammps_value,
                lammps_standard_error,
                allowed,
                date,
            });
        }
    }
    for row in &found {
        let (ours, theirs) = (row.value, row.lammps_value);
        eprintln!(
            "{}, {}: {} {ours:.5}, LAMMPS {theirs:.5}, z = {:.1}",
            row.work,
            row.integrator,
            row.quantity,
            row.z_score()
        );
        row.check()?;
    }
    Ok(found)
}

/// The mean of a component and its standard error by blocking, or what it is at least; where blocking warns, the
/// deviation of a single sample.
fn mean(samples: &[[f64; 2]], component: usize, least: f64) -> (f64, f64) {
    let estimate = Blocking::new(1).map_or_else(
        |error| Estimate::unknown(error.to_string()),
        |mut blocking| {
            let mut record = |sample: &[f64; 2]| blocking.record(&sample[component..=component]);
            match samples.iter().try_for_each(&mut record) {
                Ok(()) => blocking.estimate(),
                Err(error) => Estimate::unknown(error.to_string()),
            }
        },
    );
    let mean = samples.iter().map(|sample| sample[component]).sum::<f64>() / samples.len() as f64;
    let squares = samples.iter().map(|sample| (sample[component] - mean).powi(2)).sum::<f64>();
    let deviation = (squares / (samples.len() as f64 - 1.0)).sqrt();
    (mean, estimate.standard_error.filter(|_| estimate.warnings.is_empty()).unwrap_or(deviation).max(least))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_apart_by_more_than_allowed_are_a_failure_that_names_them() {
        let agreement = Agreement {
            work: "ideal-16".into(),
            integrator: "ABOBA".into(),
            quantity: "temperature".into(),
            value: 1.00,
            standard_error: 0.003,
            lammps_value: 1.05,
            lammps_standard_error: 0.004,
            allowed: 0.06,
            date: String::new(),
        };
        assert!((agreement.z_score() + 10.0).abs() < 1e-9);
        assert!(agreement.check().is_ok());
        let message = Agreement { allowed: 0.04, ..agreement }.check().unwrap_err().to_string();
        assert!(message.contains("temperature 1.00000 ± 0.00300 against 1.05000"), "{message}");
    }

    #[test]
    fn a_series_too_short_for_blocking_has_the_error_of_one_sample() {
        let samples = [[1.0, 0.0], [3.0, 0.0]];
        let (value, error) = mean(&samples, 0, 0.0);
        assert_eq!(value, 2.0);
        assert!((error - 2.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(mean(&samples, 0, 7.0), (2.0, 7.0));
    }
}
