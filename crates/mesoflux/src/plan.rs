//! What a job will do: for every sweep point the runs that its routes need, each run once however many routes want it.

use crate::route::{Route, RunKind, routes};
use mesoflux_io::input::{Input, InputError, InputFile};
use mesoflux_io::results::Conditions;

/// One route to one measured quantity.
pub struct Measurement {
    /// The name in the input.
    pub name: String,
    /// The quantity, in the field's terms.
    pub quantity: &'static str,
    /// The way to it.
    pub route: Box<dyn Route>,
    /// Which of the point's runs it uses, in the route's order.
    pub runs: Vec<usize>,
}

/// Everything at one point of a sweep.
pub struct PointPlan {
    /// The sweep's values.
    pub conditions: Conditions,
    /// The input there.
    pub input: Input,
    /// The routes.
    pub measurements: Vec<Measurement>,
    /// The different runs.
    pub runs: Vec<RunKind>,
    /// The point of which this one is the check, with half its time step.
    pub checks: Option<usize>,
}

/// A whole job.
pub struct Plan {
    /// Its points; one where nothing is swept. Those that check the time step of others come last, so that these are what they would
    /// be without.
    pub points: Vec<PointPlan>,
}

/// One replica of one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// Which point.
    pub point: usize,
    /// Which of its runs.
    pub run: usize,
    /// Which repetition.
    pub replica: u64,
}

impl Plan {
    /// The plan of an input file.
    ///
    /// # Errors
    /// A sweep point at which the input is wrong.
    pub fn new(file: &InputFile) -> Result<Self, InputError> {
        let point = |point: &mesoflux_io::input::Point| {
            let input = file.at(point)?;
            let conditions = point.values.iter().map(|(path, value)| (path.clone(), json(value))).collect();
            Ok(PointPlan::new(conditions, input))
        };
        let mut points: Vec<PointPlan> = file.sweep.points.iter().map(point).collect::<Result<_, _>>()?;
        if file.input.check.time_step.is_some() {
            let halves: Vec<PointPlan> =
                points.iter().enumerate().map(|(index, point)| point.at_half_time_step(index)).collect();
            points.extend(halves);
        }
        Ok(Self { points })
    }

    /// Every replica of every run.
    pub fn tasks(&self) -> Vec<Task> {
        let mut tasks = Vec::new();
        for (point, plan) in self.points.iter().enumerate() {
            for replica in 0..plan.input.run.replicas {
                tasks.extend((0..plan.runs.len()).map(|run| Task { point, run, replica }));
            }
        }
        tasks
    }
}

impl PointPlan {
    pub(crate) fn new(conditions: Conditions, input: Input) -> Self {
        let mut runs: Vec<RunKind> = Vec::new();
        let mut measurements = Vec::new();
        for (name, measure) in &input.measure {
            for route in routes(measure) {
                let places = route.runs().into_iter().map(|wanted| {
                    runs.iter().position(|run| *run == wanted).unwrap_or_else(|| {
                        runs.push(wanted);
                        runs.len() - 1
                    })
                });
                let places = places.collect();
                measurements.push(Measurement {
                    name: name.clone(),
                    quantity: measure.quantity.name(),
                    route,
                    runs: places,
                });
            }
        }
        // Without a measurement the run itself is wanted.
        if runs.is_empty() {
            runs.push(RunKind::Equilibrium);
        }
        Self { conditions, input, measurements, runs, checks: None }
    }

    /// The same with half the time step, as the check of the point with this place in the plan.
    fn at_half_time_step(&self, place: usize) -> Self {
        let input = self.input.at_half_time_step();
        let mut conditions = self.conditions.clone();
        conditions.insert("dynamics.time_step".to_owned(), input.dynamics.time_step.into());
        Self { checks: Some(place), ..Self::new(conditions, input) }
    }

    /// The measurements that use a run, by their places.
    pub fn users(&self, run: usize) -> impl Iterator<Item = usize> {
        self.measurements.iter().enumerate().filter(move |(_, user)| user.runs.contains(&run)).map(|(place, _)| place)
    }

    /// Steps of one run, equilibration included.
    pub fn steps(&self) -> u64 {
        self.input.steps(self.input.run.equilibration_time) + self.input.steps(self.input.run.production_time)
    }
}

fn json(value: &toml::Value) -> serde_json::Value {
    serde_json::to_value(value).unwrap_or(serde_json::Value::Null)
}
