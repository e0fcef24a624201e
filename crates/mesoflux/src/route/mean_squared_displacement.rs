//! Diffusion and mobility from the mean squared displacement of an equilibrium run.

use super::{Outcome, Record, Route, RouteError, RouteRecorder, cell, relaxation};
use mesoflux_analysis::{AnalysisError, MeanSquaredDisplacement};
use mesoflux_core::integrate::{Langevin, Thermostat};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_core::vector::Vector;
use mesoflux_io::input::{Input, MeanSquaredDisplacementInput};
use mesoflux_io::results::{Conditions, Table};
use mesoflux_io::stream;
use std::io::{self, Write};

/// Lags between zero and the longest one at which the displacement is measured.
const LAGS: u64 = 32;

/// D from the slope of the curve, or the mobility α of the driven routes.
///
/// With Σ F_i = 0 and |F| = 1, ⟨R(0) R(t)⟩ is the autocorrelation of one particle's velocity component less the correlation with
/// that of another, whichever: α = β(D − D'). What the centroid does tells D': its own coefficient is (D + (N − 1)D')/N.
/// Where total momentum is conserved and zero it rests if masses are equal, and α = βD N/(N − 1). With a drag γ on every particle, of whatever
/// mass, γ times the centroid's displacement is the mean impulse of the noises, but for what momenta are left: its coefficient
/// is kT/(Nγ), and α = (βD N − 1/γ)/(N − 1).
pub(super) struct MeanSquaredDisplacementRoute {
    pub parameters: MeanSquaredDisplacementInput,
    pub mobility: bool,
}

impl MeanSquaredDisplacementRoute {
    /// Steps between two configurations: the longest lag in `LAGS` parts, rounded to whole steps.
    fn spacing(&self, input: &Input) -> u64 {
        (input.steps(self.parameters.longest_lag(input.run.production_time)) / LAGS).max(1)
    }
}

impl Route for MeanSquaredDisplacementRoute {
    fn method(&self) -> &'static str {
        "msd"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let interval = self.spacing(input);
        let spacing = interval as f64 * input.dynamics.time_step;
        let displacement = MeanSquaredDisplacement::new(input.particles() as usize, LAGS as usize, spacing)?;
        Ok(Box::new(DisplacementRecorder { interval, displacement, positions: Vec::new(), failure: None }))
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let [Record::Displacement(displacement)] = records else {
            return Err(RouteError::WrongRecord);
        };
        let diffusion = displacement.diffusion_coefficient();
        let particles = input.particles() as f64;
        let estimate = if self.mobility {
            let factor = particles / (particles - 1.0) / input.dynamics.temperature;
            let mut mobility = diffusion.estimate.scaled(factor);
            if let Thermostat::Langevin(Langevin { friction }) = input.dynamics.thermostat {
                mobility.value = mobility.value.map(|value| value - 1.0 / (friction * (particles - 1.0)));
            }
            mobility
        } else {
            diffusion.estimate.clone()
        };
        let mut conditions = Conditions::new();
        if let Some((from, to)) = diffusion.window {
            conditions.insert("fit_from".to_owned(), from.into());
            conditions.insert("fit_to".to_owned(), to.into());
        }
        let rows = displacement
            .curve()
            .into_iter()
            .filter_map(|(time, point)| Some(vec![time, point.value?, cell(point.standard_error)]));
        let header = vec!["time [t]", "mean_squared_displacement [l^2]", "standard_error [l^2]"];
        // The mobility is the slope that the driven routes look for.
        let slope = if self.mobility { estimate.value } else { None };
        let tables = vec![("", Table::new(header, rows.collect()))];
        let mut outcome = Outcome { conditions, tables, slope, ..Outcome::of(estimate) };
        relaxation::report(&mut outcome, input, &diffusion.estimate);
        Ok(outcome)
    }
}

/// Follows the unwrapped positions.
struct DisplacementRecorder {
    interval: u64,
    displacement: MeanSquaredDisplacement,
    positions: Vec<Vector>,
    failure: Option<AnalysisError>,
}

impl Recorder for DisplacementRecorder {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step.is_multiple_of(self.interval) {
            let system = &moment.simulation.system;
            system.particles.unwrapped_positions(&system.region, &mut self.positions);
            self.failure = self.failure.take().or(self.displacement.record(&self.positions).err());
        }
    }
}

impl RouteRecorder for DisplacementRecorder {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, &self.displacement))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, displacement): (u64, _) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.displacement.accepts(&displacement) {
            return Err(RouteError::OtherState);
        }
        self.displacement = displacement;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Record, RouteError> {
        // Records of finished runs stay in memory to the end of the job.
        self.displacement.forget_configurations();
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Displacement(self.displacement)),
        }
    }
}
