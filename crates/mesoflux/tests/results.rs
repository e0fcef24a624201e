//! `results.json`, field by field, against the contract of its format.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, MEASURES, list};
use serde_json::Value;
use std::collections::BTreeSet;

const COEFFICIENT: &str = "pair.all.friction.linear.coefficient";

const SWEEP: &str = "
[sweep]
pair.all.friction.linear.coefficient = [2.0, 4.5]
";

/// What the measurements of the shared input must answer: name, quantity, method.
const EXPECTED: [[&str; 3]; 9] = [
    ["D", "diffusion_coefficient", "msd"],
    ["P", "pressure", "virial"],
    ["T", "temperature", "kinetic"],
    ["T_configurational", "configurational_temperature", "configurational"],
    ["U", "potential_energy", "direct"],
    ["mobility", "mobility", "msd"],
    ["mobility", "mobility", "nemd"],
    ["mobility", "mobility", "norton"],
    ["viscosity", "shear_viscosity", "norton"],
];

fn fields(value: &Value) -> BTreeSet<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn text<'a>(value: &'a Value, field: &str) -> &'a str {
    value[field].as_str().unwrap_or_else(|| panic!("{field} of {value}"))
}

fn number(value: &Value, field: &str) -> f64 {
    value[field].as_f64().unwrap_or_else(|| panic!("{field} of {value}"))
}

#[test]
fn the_head_of_the_results_has_its_fields() {
    let results = Folder::with(&format!("{FLUID}{MEASURES}")).run_for_results("--threads 2 --seed 5");
    let contract = [
        "schema",
        "mesoflux",
        "input",
        "seed",
        "threads",
        "complete",
        "kernel",
        "wall_seconds",
        "particle_steps",
        "particle_steps_per_second",
        "runs",
        "estimates",
    ];
    assert!(contract.iter().all(|field| fields(&results).contains(field)), "{:?}", fields(&results));
    assert_eq!(results["schema"], "mesoflux.results/1");
    assert_eq!(results["mesoflux"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&results["seed"], &results["threads"], &results["complete"]), (&5.into(), &2.into(), &true.into()));
    assert!(!text(&results, "kernel").is_empty());
    assert!(number(&results, "wall_seconds") > 0.0);
    // Equilibrium, two magnitudes, one flux and two; two replicas of 64 particles for 10 + 200 steps.
    let work = 6.0 * 2.0 * 64.0 * 210.0;
    assert_eq!(number(&results, "particle_steps"), work);
    let speed = number(&results, "particle_steps_per_second") * number(&results, "wall_seconds");
    assert!((speed / work - 1.0).abs() < 1e-6);
}

#[test]
fn the_input_is_complete_with_its_defaults() {
    let input = &Folder::with(&format!("{FLUID}{MEASURES}")).run_for_results("")["input"];
    assert_eq!(input["system"]["particles"], 64);
    assert_eq!(list(&input["system"]["box"]).len(), 3);
    assert_eq!(input["system"]["start"], "cubic_lattice");
    assert_eq!(input["species"]["fluid"]["mass"], 1.0);
    assert_eq!(input["dynamics"]["word"], "ABOBA");
    assert_eq!(input["dynamics"]["thermostat"], "pair_ornstein_uhlenbeck");
    assert_eq!(input["run"]["seed"], 1);
    assert!(number(&input["run"], "skin") > 0.0);
    assert_eq!(input["measure"]["P"]["routes"], serde_json::json!({ "virial": {} }));
}

#[test]
fn there_is_one_run_for_each_strength_and_replica() {
    let results = Folder::with(&format!("{FLUID}{MEASURES}")).run_for_results("");
    let mut found = Vec::new();
    for run in list(&results["runs"]) {
        let contract = ["route", "point", "replica", "particles", "steps"];
        assert!(contract.iter().all(|field| fields(run).contains(field)), "{run}");
        assert_eq!((&run["particles"], &run["steps"]), (&64.into(), &200.into()));
        found.push(format!("{} {} {}", text(run, "route"), run["point"], run["replica"]));
    }
    found.sort();
    let mut expected = Vec::new();
    for kind in [
        r"equilibrium {}",
        r#"nemd {"magnitude":4.0}"#,
        r#"nemd {"magnitude":8.0}"#,
        r#"norton {"flux":0.0}"#,
        r#"norton {"flux":0.3}"#,
        r#"norton {"flux":2.0}"#,
    ] {
        expected.extend((0..2).map(|replica| format!("{kind} {replica}")));
    }
    assert_eq!(found, expected);
}

#[test]
fn there_is_one_estimate_for_each_measurement_and_route() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    let results = folder.run_for_results("");
    let mut found = Vec::new();
    for estimate in list(&results["estimates"]) {
        check_estimate(estimate, &folder);
        found.push(["measurement", "quantity", "method"].map(|field| text(estimate, field)));
    }
    found.sort_unstable();
    assert_eq!(found, EXPECTED);
}

#[test]
fn each_point_of_a_sweep_has_its_own_estimates() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}{SWEEP}"));
    let results = folder.run_for_results("");
    for point in [2.0, 4.5] {
        let here = |value: &&Value| value[COEFFICIENT] == point;
        let estimates: Vec<&Value> =
            list(&results["estimates"]).iter().filter(|estimate| here(&&estimate["conditions"])).collect();
        let mut found: Vec<[&str; 3]> = Vec::new();
        for estimate in &estimates {
            check_estimate(estimate, &folder);
            found.push(["measurement", "quantity", "method"].map(|field| text(estimate, field)));
        }
        found.sort_unstable();
        assert_eq!(found, EXPECTED, "at {point}");
        assert_eq!(list(&results["runs"]).iter().filter(|run| here(&&run["point"])).count(), 12);
    }
    let tables: Vec<&str> =
        list(&results["estimates"]).iter().filter_map(|estimate| estimate.get("table")?.as_str()).collect();
    assert_eq!(tables.iter().collect::<BTreeSet<_>>().len(), tables.len(), "no two estimates share a table");
}

/// What holds of every estimate.
fn check_estimate(estimate: &Value, folder: &Folder) {
    let mut contract: BTreeSet<&str> =
        "quantity method value standard_error effective_samples particle_steps conditions \
                                        warnings measurement"
            .split_whitespace()
            .collect();
    if estimate.get("table").is_some() {
        contract.insert("table");
        check_table(text(estimate, "table"), folder);
    }
    assert_eq!(fields(estimate), contract);
    let unknown = estimate["value"].is_null() || estimate["standard_error"].is_null();
    assert!(!unknown || !list(&estimate["warnings"]).is_empty(), "null needs a reason: {estimate}");
    assert!(list(&estimate["warnings"]).iter().all(Value::is_string));
    assert!(number(estimate, "effective_samples") >= 0.0);
    let several = text(estimate, "method") == "nemd" || text(estimate, "measurement") == "viscosity";
    let runs = if several { 2.0 } else { 1.0 };
    assert_eq!(number(estimate, "particle_steps"), runs * 2.0 * 64.0 * 210.0);
    for (name, condition) in estimate["conditions"].as_object().unwrap() {
        assert!(!condition.is_null(), "{name} of {estimate}");
    }
}

/// A header with units, and beneath finite numbers, or nothing where an estimator can't tell.
fn check_table(name: &str, folder: &Folder) {
    let table = folder.read(&format!("out/{name}"));
    let (header, rows) = table.split_once('\n').unwrap();
    let columns = header.split(',').count();
    assert!(columns >= 2, "{name}: {header}");
    for column in header.split(',') {
        assert!(column.contains(" [") && column.ends_with(']'), "{name}: {column:?} gives no units");
    }
    assert!(!rows.is_empty(), "{name} has no rows");
    for row in rows.lines() {
        let told = row.split(',').filter(|field| !field.is_empty());
        let numbers: Vec<f64> = told.map(|number| number.parse().unwrap()).collect();
        assert!(row.split(',').count() == columns && numbers.iter().all(|number| number.is_finite()), "{name}: {row}");
    }
}
