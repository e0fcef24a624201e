//! From finished runs to results: estimates, comparisons between routes, tables.

use crate::finite_size;
use crate::job::{Finished, JobError, merged_records};
use crate::long_wave;
use crate::plan::{Measurement, Plan, PointPlan, Task};
use crate::response_figure::Profile;
use crate::route::Outcome;
use mesoflux_analysis::{AnalysisError, Estimate};
use mesoflux_io::input::Input;
use mesoflux_io::results::{Comparison, EstimateRecord, Results, RunRecord, SCHEMA, TimeStepBias};

/// What the clock and the command line add to the results.
#[derive(Debug, Clone, Copy)]
pub struct Circumstances {
    /// Threads used.
    pub threads: usize,
    /// Wall time of the runs.
    pub wall_seconds: f64,
}

/// Results, and the tables that belong beside them by file name.
#[derive(Debug, Clone)]
pub struct Answer {
    /// For `results.json`.
    pub results: Results,
    /// File name and contents of tables and figures.
    pub files: Vec<(String, String)>,
}

/// Estimates everything the plan asks for from its finished runs.
///
/// # Errors
/// Records that an estimator refuses.
pub fn answer(
    input: &Input,
    plan: &Plan,
    finished: &[Finished],
    circumstances: Circumstances,
) -> Result<Answer, JobError> {
    let mut estimates = Vec::new();
    let mut comparisons = Vec::new();
    let mut time_step_check = Vec::new();
    let mut files = Vec::new();
    let swept = plan.points.iter().filter(|point| point.checks.is_none()).count() > 1;
    // Where each point's estimates begin.
    let mut first = Vec::new();
    for (index, point) in plan.points.iter().enumerate() {
        let mut found = estimate(plan, finished, index)?;
        finite_size::report(&point.input, &mut found);
        if let Some(checked) = point.checks {
            let conditions = &plan.points[checked].conditions;
            let pairs = estimates[first[checked]..].iter().zip(&found);
            time_step_check
                .extend(pairs.map(|(record, (half, _))| TimeStepBias::new(record, half, conditions.clone())));
            continue;
        }
        first.push(estimates.len());
        let suffix = if swept { format!("-{}", index + 1) } else { String::new() };
        let mut profiles: Vec<Profile> = Vec::new();
        for (mut record, outcome) in found {
            if let Some(outcome) = outcome {
                Profile::collect(&mut profiles, &record, &outcome);
                let name = |part: &str, extension: &str| {
                    let part = if part.is_empty() { String::new() } else { format!("-{part}") };
                    format!("{}-{}{part}{suffix}.{extension}", record.measurement, record.method)
                };
                for (part, mut figure) in outcome.figures {
                    figure.title.clone_from(&input.title);
                    files.push((name(part, "svg"), figure.svg()));
                }
                for (part, table) in outcome.tables {
                    files.push((name(part, "csv"), table.csv()));
                    record.table.get_or_insert(name(part, "csv"));
                }
            }
            estimates.push(record);
        }
        for profile in profiles.iter().filter(|profile| profile.is_worth_drawing()) {
            files.push((format!("{}{suffix}.svg", profile.measurement), profile.figure(&input.title).svg()));
        }
        comparisons.extend(compare(point, &estimates[first[index]..]));
    }
    let failed = |source: AnalysisError| JobError::Route { place: "long-wave limit".to_owned(), source: source.into() };
    let long_wave_limits = long_wave::limits(&estimates).map_err(failed)?;
    let particle_steps = cost(plan, finished, |_| true);
    let before: f64 = finished.iter().map(|run| particles(plan, run) * run.steps_before as f64).sum();
    let results = Results {
        schema: SCHEMA,
        mesoflux: env!("CARGO_PKG_VERSION"),
        input: input.with_defaults(),
        seed: input.run.seed,
        threads: circumstances.threads,
        complete: finished.len() == plan.tasks().len() && finished.iter().all(|run| run.complete),
        kernel: mesoflux_core::lanes::InstructionSet::detect().name(),
        wall_seconds: circumstances.wall_seconds,
        particle_steps,
        particle_steps_per_second: (particle_steps - before) / circumstances.wall_seconds.max(1e-9),
        runs: finished.iter().map(|finished| run_record(plan, finished)).collect(),
        estimates,
        comparisons,
        time_step_check,
        long_wave_limits,
    };
    Ok(Answer { results, files })
}

/// What each measurement of a point comes to, with the outcome where its runs are all there.
fn estimate(
    plan: &Plan,
    finished: &[Finished],
    index: usize,
) -> Result<Vec<(EstimateRecord, Option<Outcome>)>, JobError> {
    let point = &plan.points[index];
    let one = |(place, measurement): (usize, &Measurement)| {
        let failed = |source| JobError::Route { place: format!("measure.{}", measurement.name), source };
        let mut record = blank(point, measurement);
        record.particle_steps =
            cost(plan, finished, |task| task.point == index && measurement.runs.contains(&task.run));
        let Some(records) = merged_records(plan, finished, index, place).map_err(failed)? else {
            record.warnings.push("its runs are not complete".to_owned());
            return Ok((record, None));
        };
        let outcome = measurement.route.estimate(&point.input, &records).map_err(failed)?;
        record.take(&outcome.estimate);
        record.conditions.extend(outcome.conditions.clone());
        Ok((record, Some(outcome)))
    };
    point.measurements.iter().enumerate().map(one).collect()
}

/// Particles times steps that some runs have done, all replicas, equilibration included.
fn cost(plan: &Plan, finished: &[Finished], counts: impl Fn(Task) -> bool) -> f64 {
    finished.iter().filter(|run| counts(run.task)).map(|run| particles(plan, run) * run.steps as f64).sum()
}

fn particles(plan: &Plan, run: &Finished) -> f64 {
    plan.points[run.task.point].input.particles() as f64
}

fn blank(point: &PointPlan, measurement: &Measurement) -> EstimateRecord {
    EstimateRecord {
        measurement: measurement.name.clone(),
        quantity: measurement.quantity,
        method: measurement.route.method(),
        value: None,
        standard_error: None,
        effective_samples: 0.0,
        particle_steps: 0.0,
        conditions: point.conditions.clone(),
        warnings: Vec::new(),
        table: None,
    }
}

fn run_record(plan: &Plan, finished: &Finished) -> RunRecord {
    let point = &plan.points[finished.task.point];
    let kind = &point.runs[finished.task.run];
    let mut conditions = point.conditions.clone();
    conditions.extend(kind.point());
    RunRecord {
        route: kind.name(),
        point: conditions,
        replica: finished.task.replica,
        particles: point.input.particles(),
        steps: finished.steps.saturating_sub(point.input.steps(point.input.run.equilibration_time)),
        temperature: finished.temperature,
        remarks: finished.remarks.iter().cloned().chain(point.input.remark_on_momentum()).collect(),
    }
}

/// Every two routes of one measurement against each other, where they share no run (else their errors are correlated).
fn compare(point: &PointPlan, estimates: &[EstimateRecord]) -> Vec<Comparison> {
    let mut comparisons = Vec::new();
    for (second, b) in estimates.iter().enumerate() {
        for (first, a) in estimates[..second].iter().enumerate() {
            let shared = point.measurements[first].runs.iter().any(|run| point.measurements[second].runs.contains(run));
            if a.measurement != b.measurement || shared {
                continue;
            }
            let estimate = |record: &EstimateRecord| {
                Some(Estimate::new(record.value?, record.standard_error?, record.effective_samples))
            };
            if let (Some(left), Some(right)) = (estimate(a), estimate(b)) {
                comparisons.push(Comparison {
                    measurement: a.measurement.clone(),
                    methods: [a.method, b.method],
                    z: left.z_score(&right),
                    conditions: point.conditions.clone(),
                });
            }
        }
    }
    comparisons
}
