//! Diffusion from the autocorrelation of the velocities (Green 1954, Kubo 1957).

use super::correlation::{CorrelationRecorder, Sample, Sampler, integral_conditions, interval};
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells};
use mesoflux_analysis::{IntegralOptions, MultipleTau, Quadrature};
use mesoflux_core::run::Moment;
use mesoflux_io::input::{CorrelationInput, Input};
use mesoflux_io::results::Table;

/// Particles that are followed: more tell little more, as particles near each other move together.
const FOLLOWED: u64 = 1000;

/// D = ∫₀^∞ ⟨v_x(t) v_x(0)⟩ dt, averaged over components and up to 1000 particles.
///
/// All particles of a run share its segments: the error counts time, not particles.
pub(super) struct VelocityAutocorrelation {
    pub parameters: CorrelationInput,
}

/// Reads the velocities of the particles with the first ids, in the order of their ids.
struct Velocities {
    followed: u64,
}

impl Sampler for Velocities {
    fn sample(&mut self, moment: &mut Moment) -> Sample {
        let system = &moment.simulation.system;
        let mut velocities = vec![0.0; 3 * self.followed as usize];
        for (k, &id) in system.particles.id.iter().enumerate().filter(|&(_, &id)| id < self.followed) {
            velocities[3 * id as usize..][..3].copy_from_slice(&system.particles.velocity(k));
        }
        Sample { channels: vec![velocities], averages: vec![system.kinetic_temperature()] }
    }
}

impl Route for VelocityAutocorrelation {
    fn method(&self) -> &'static str {
        "vacf"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let interval = interval(input, self.parameters.sample_interval);
        let spacing = interval as f64 * input.dynamics.time_step;
        let followed = input.particles().min(FOLLOWED);
        let channels = 3 * followed as usize;
        let correlator = MultipleTau::pooled(channels, spacing)?;
        CorrelationRecorder::boxed(interval, Velocities { followed }, vec![correlator], 1)
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let function = &records[0].correlations()?.functions[0];
        let quadrature = Quadrature::Smooth;
        let integral = function.integral(&IntegralOptions { quadrature, longest_time: self.parameters.longest_lag });
        let mut outcome = Outcome::of(integral.estimate.clone());
        outcome.conditions = integral_conditions(function, &integral);
        let header = [
            "time [t]",
            "velocity_autocorrelation [v^2]",
            "standard_error [v^2]",
            "integral [l^2/t]",
            "standard_error [l^2/t]",
        ];
        let rows = function.table(quadrature).into_iter().map(|point| {
            std::iter::once(point.time).chain([point.correlation, point.integral].iter().flat_map(cells)).collect()
        });
        outcome.tables.push(("", Table::new(header, rows.collect())));
        Ok(outcome)
    }
}
