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
    /// Where the time step is checked, what each estimate owes to it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub time_step_check: Vec<TimeStepBias>,
    /// Long-wave limits of viscosities that a sweep has measured at several wavenumbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub long_wave_limits: Vec<LongWaveLimit>,
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

/// One estimate at the time step Δt of the input against the same at Δt/2.
#[derive(Debug, Clone, Serialize)]
pub struct TimeStepBias {
    /// The name of the measurement in the input.
    pub measurement: String,
    /// The quantity, in the field's terms.
    pub quantity: &'static str,
    /// How it was obtained.
    pub method: &'static str,
    /// The value at Δt; null where the estimator can't tell.
    pub value: Option<f64>,
    /// The value at Δt/2, from independent runs.
    pub value_at_half: Option<f64>,
    /// `value` − `value_at_half`: three quarters of the whole bias where it is of second order in Δt, half where of first.
    pub bias: Option<f64>,
    /// The standard error of `bias`.
    pub standard_error: Option<f64>,
    /// `bias` over its standard error.
    pub z: Option<f64>,
    /// The value at Δt = 0 if the bias is of second order: `value_at_half` − `bias`/3.
    pub extrapolated: Option<f64>,
    /// Its standard error.
    pub extrapolated_standard_error: Option<f64>,
    /// The sweep's values.
    pub conditions: Conditions,
}

impl TimeStepBias {
    /// What two estimates from independent runs tell.
    pub fn new(record: &EstimateRecord, half: &EstimateRecord, conditions: Conditions) -> Self {
        let errors = record.standard_error.zip(half.standard_error);
        let values = record.value.zip(half.value);
        let bias = values.map(|(value, half)| value - half);
        let standard_error = errors.map(|(error, half)| error.hypot(half));
        let finite = |number: &f64| number.is_finite();
        Self {
            measurement: record.measurement.clone(),
            quantity: record.quantity,
            method: record.method,
            value: record.value,
            value_at_half: half.value,
            bias,
            standard_error,
            z: bias.zip(standard_error).map(|(bias, error)| bias / error).filter(finite),
            extrapolated: values.map(|(value, half)| (4.0 * half - value) / 3.0),
            extrapolated_standard_error: errors.map(|(error, half)| (4.0 * half).hypot(error) / 3.0),
            conditions,
        }
    }
}

/// What a viscosity measured at several wavenumbers k tends to as k → 0, by the line η(0)(1 − bk²).
#[derive(Debug, Clone, Serialize)]
pub struct LongWaveLimit {
    /// The name of the measurement in the input.
    pub measurement: String,
    /// The quantity, in the field's terms.
    pub quantity: &'static str,
    /// How it was obtained.
    pub method: &'static str,
    /// η(0); null where it can't be told.
    pub value: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// The wavenumbers, ascending.
    pub wavenumbers: Vec<f64>,
    /// The sweep's values but for those of box and waves.
    pub conditions: Conditions,
    /// What a reader must know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl LongWaveLimit {
    /// The limit of the estimates that this one belongs to, not yet found.
    pub fn new(record: &EstimateRecord, conditions: Conditions) -> Self {
        Self {
            measurement: record.measurement.clone(),
            quantity: record.quantity,
            method: record.method,
            value: None,
            standard_error: None,
            wavenumbers: Vec::new(),
            conditions,
            warnings: Vec::new(),
        }
    }

    /// Takes over what was estimated.
    pub fn take(&mut self, estimate: &Estimate) {
        (self.value, self.standard_error) = (estimate.value, estimate.standard_error);
        self.warnings.clone_from(&estimate.warnings);
    }
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
    /// The table beside the results, by its file name; further ones have names that begin alike.
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

/// A table of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The name of each column with its units, `time [t]`.
    pub header: Vec<String>,
    /// As many numbers in each row; what can't be told is not a number (NaN).
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// A table of rows under a header.
    pub fn new(header: impl IntoIterator<Item: Into<String>>, rows: Vec<Vec<f64>>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows }
    }

    /// The table as CSV; what can't be told is an empty field.
    pub fn csv(&self) -> String {
        let field = |number: &f64| if number.is_finite() { format!("{number:.12e}") } else { String::new() };
        let mut text = self.header.join(",") + "\n";
        for row in &self.rows {
            text += &row.iter().map(field).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }
}
