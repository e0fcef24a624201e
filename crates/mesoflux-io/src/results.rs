//! `results.json`: every estimate with its error, and everything needed to judge and repeat it.

use crate::input::Input;
use mesoflux_analysis::Estimate;
use serde::Serialize;
use std::collections::BTreeMap;

/// The name of the format.
pub const SCHEMA: &str = "mesoflux.results/1";

/// A value that names a point: a number, or whatever the input says.
pub type Conditions = BTreeMap<String, serde_json::Value>;

/// The whole answer of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Results {
    /// The name of this format.
    pub schema: &'static str,
    /// The version of the program.
    pub mesoflux: &'static str,
    /// The complete input with defaults filled in.
    pub input: Input,
    /// The seed.
    pub seed: u64,
    /// How many threads computed.
    pub threads: usize,
    /// Whether everything that was asked for has run.
    pub complete: bool,
    /// The set of kernels; results of one set are the same to the bit.
    pub kernel: &'static str,
    /// Wall time of the session that wrote this; a run that was interrupted has had others.
    pub wall_seconds: f64,
    /// Particles times steps done, summed over all runs and sessions, equilibration included.
    pub particle_steps: f64,
    /// Those of this session per second of its wall time.
    pub particle_steps_per_second: f64,
    /// Every run.
    pub runs: Vec<RunRecord>,
    /// Exactly one estimate for each measurement, route and sweep point.
    pub estimates: Vec<EstimateRecord>,
    /// Independent routes to the same quantity, against each other.
    pub comparisons: Vec<Comparison>,
}

/// Two routes of one measurement that share no run.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// The name of the measurement in the input.
    pub measurement: String,
    /// The two methods.
    pub methods: [&'static str; 2],
    /// The difference of the two values in units of its standard error.
    pub z: Option<f64>,
    /// The sweep's values.
    pub conditions: Conditions,
}

/// One run.
#[derive(Debug, Clone, Serialize)]
pub struct RunRecord {
    /// The route it ran for; `equilibrium` for all that need no driving.
    pub route: &'static str,
    /// Where it stands: the driving's strength and the sweep's values.
    pub point: Conditions,
    /// Which of the independent repetitions.
    pub replica: u64,
    /// N.
    pub particles: u64,
    /// Steps of production done.
    pub steps: u64,
    /// The kinetic temperature averaged over production.
    pub temperature: Option<f64>,
    /// What a reader must know of how it went, such as a damaged checkpoint that was passed over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
}

/// One estimate.
#[derive(Debug, Clone, Serialize)]
pub struct EstimateRecord {
    /// The name of the measurement in the input.
    pub measurement: String,
    /// The quantity, in the field's terms.
    pub quantity: &'static str,
    /// How it was obtained.
    pub method: &'static str,
    /// The value; null where the estimator can't tell.
    pub value: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// How many independent samples the error stands on.
    pub effective_samples: f64,
    /// What it has cost: particles times steps, equilibration included. Runs that several estimates share count for each.
    pub particle_steps: f64,
    /// Under which conditions: the sweep's values, the driving, what was measured beside.
    pub conditions: Conditions,
    /// What a reader must know.
    pub warnings: Vec<String>,
    /// A table beside the results, by its file name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
}

impl EstimateRecord {
    /// Takes over value, error and warnings; a number that isn't finite becomes null with a warning.
    pub fn take(&mut self, estimate: &Estimate) {
        let finite = |number: Option<f64>| number.filter(|number| number.is_finite());
        self.value = finite(estimate.value);
        self.standard_error = finite(estimate.standard_error);
        self.effective_samples = if estimate.effective_samples.is_finite() { estimate.effective_samples } else { 0.0 };
        self.warnings.extend(estimate.warnings.iter().cloned());
        if self.value.is_none() && self.warnings.is_empty() {
            self.warnings.push("cannot tell: the estimator gave no finite number".to_owned());
        }
    }
}

/// A table of numbers as CSV; the header names each column with its units.
pub fn csv(header: &[&str], rows: &[Vec<f64>]) -> String {
    let mut text = header.join(",") + "\n";
    for row in rows {
        text += &row.iter().map(|number| format!("{number:.12e}")).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}
