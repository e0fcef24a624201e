//! From finished runs to results: estimates, comparisons between routes, tables.

use crate::figure::Profile;
use crate::job::{Finished, JobError, merged_records};
use crate::plan::{Measurement, Plan, PointPlan, Task};
use mesoflux_analysis::Estimate;
use mesoflux_io::input::Input;
use mesoflux_io::results::{Comparison, EstimateRecord, Results, RunRecord, SCHEMA, csv};

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
    let mut files = Vec::new();
    for (index, point) in plan.points.iter().enumerate() {
        let first = estimates.len();
        let suffix = if plan.points.len() > 1 { format!("-{}", index + 1) } else { String::new() };
        let mut profiles: Vec<Profile> = Vec::new();
        for (place, measurement) in point.measurements.iter().enumerate() {
            let failed = |source| JobError::Route { place: format!("measure.{}", measurement.name), source };
            let mut record = blank(point, measurement);
            record.particle_steps =
                cost(plan, finished, |task| task.point == index && measurement.runs.contains(&task.run));
            if let Some(records) = merged_records(plan, finished, index, place).map_err(failed)? {
                let outcome = measurement.route.estimate(&point.input, &records).map_err(failed)?;
                record.take(&outcome.estimate);
                Profile::collect(&mut profiles, &record, &outcome.response);
                record.conditions.extend(outcome.conditions);
                if let Some((header, rows)) = outcome.table {
                    let name = format!("{}-{}{suffix}.csv", measurement.name, record.method);
                    files.push((name.clone(), csv(&header, &rows)));
                    record.table = Some(name);
                }
            } else {
                record.warnings.push("its runs are not complete".to_owned());
            }
            estimates.push(record);
        }
        for profile in profiles.iter().filter(|profile| profile.is_worth_drawing()) {
            files.push((format!("{}{suffix}.svg", profile.measurement), profile.draw(&input.title)));
        }
        comparisons.extend(compare(point, &estimates[first..]));
    }
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
    };
    Ok(Answer { results, files })
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
        remarks: finished.remarks.iter().cloned().chain(point.input.remark_on_fields()).collect(),
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
