//! The same seed gives the same bits on any number of threads; another seed other numbers; settings do what they say.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{EXCHANGE, FLUID, Folder, MEASURES, list};
use serde_json::Value;

/// The results without what the clock and the machine say.
fn physics(mut results: Value) -> Value {
    let fields = results.as_object_mut().unwrap();
    for circumstance in ["wall_seconds", "threads", "particle_steps_per_second"] {
        assert!(fields.remove(circumstance).is_some(), "{circumstance}");
    }
    results
}

/// Results and tables at 1, 2 and 3 threads must agree to the bit.
fn same_on_any_number_of_threads(input: &str) {
    let folder = Folder::with(input);
    for threads in 1..=3 {
        folder.run(&format!("--quiet --seed 11 --threads {threads} --out {threads}"));
    }
    let first = physics(folder.results("1"));
    for threads in ["2", "3"] {
        assert_eq!(physics(folder.results(threads)), first, "{threads} threads");
        for estimate in list(&first["estimates"]) {
            if let Some(table) = estimate.get("table").and_then(Value::as_str) {
                assert_eq!(folder.read(&format!("{threads}/{table}")), folder.read(&format!("1/{table}")), "{table}");
            }
        }
    }
}

#[test]
fn small_runs_side_by_side_are_the_same_on_any_number_of_threads() {
    same_on_any_number_of_threads(&format!("{FLUID}{MEASURES}{EXCHANGE}"));
}

#[test]
fn a_large_run_on_all_threads_is_the_same_on_any_number_of_them() {
    let input = FLUID
        .replace("particles = 64", "particles = 5000")
        .replace("replicas = 2", "replicas = 1")
        .replace("equilibration_time = 0.2", "equilibration_time = 0.0")
        .replace("production_time = 4.0", "production_time = 0.2");
    let norton =
        "[measure.mobility]\nquantity = \"mobility\"\nforcing = \"color_drift\"\nroutes.norton = { flux = 0.5 }";
    same_on_any_number_of_threads(&format!("{input}\n{norton}\n"));
}

/// The values of all estimates; a run this short can't tell them all.
fn values(results: &Value) -> Vec<Option<f64>> {
    list(&results["estimates"]).iter().map(|estimate| estimate["value"].as_f64()).collect()
}

#[test]
fn the_seed_decides_the_noise() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    for (out, arguments) in [("default", ""), ("one", "--seed 1"), ("two", "--seed 2"), ("set", "--set run.seed=2")] {
        folder.run(&format!("--quiet --out {out} {arguments}"));
    }
    let [default, one, two, set] = ["default", "one", "two", "set"].map(|out| folder.results(out));
    assert_eq!(values(&default), values(&one), "the default seed is 1");
    assert_eq!(values(&two), values(&set));
    assert_eq!((&two["seed"], &two["input"]["run"]["seed"]), (&2.into(), &2.into()));
    let (first, second) = (values(&one), values(&two));
    let told: Vec<(f64, f64)> = first.iter().zip(&second).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
    assert!(told.len() >= 5 && told.iter().all(|(a, b)| a != b), "{first:?} and {second:?}");
}

#[test]
fn a_seed_on_the_command_line_wins_over_a_setting_and_the_file() {
    let folder = Folder::with(&FLUID.replace("[run]", "[run]\nseed = 3"));
    assert_eq!(folder.run_for_results("")["seed"], 3);
    assert_eq!(folder.run_for_results("--force --set run.seed=4")["seed"], 4);
    assert_eq!(folder.run_for_results("--force --set run.seed=4 --seed 5")["seed"], 5);
}

#[test]
fn settings_are_written_into_the_input() {
    let folder = Folder::with(FLUID);
    let settings = "--set run.replicas=3 --set dynamics.word=OBABO --set pair.all.friction.linear.coefficient=40.5 \
                    --set measure.P.quantity=\"pressure\" --set title=changed --set run.replicas=4";
    let results = folder.run_for_results(settings);
    let input = &results["input"];
    assert_eq!(input["run"]["replicas"], 4, "the last of two settings of one key holds");
    assert_eq!(input["dynamics"]["word"], "OBABO");
    assert_eq!(input["pair"]["all"]["friction"]["linear"]["coefficient"], 40.5);
    assert_eq!(input["title"], "changed");
    assert_eq!(list(&results["runs"]).len(), 4);
    assert_eq!(list(&results["estimates"])[0]["quantity"], "pressure");
}

#[test]
fn replicas_and_sweep_points_don_t_share_noise() {
    let sweep = "[sweep]\nrun.sample_interval = [2, 4]\n";
    let results = Folder::with(&format!("{FLUID}{sweep}")).run_for_results("");
    let mut temperatures: Vec<f64> =
        list(&results["runs"]).iter().map(|run| run["temperature"].as_f64().unwrap()).collect();
    temperatures.sort_by(f64::total_cmp);
    temperatures.dedup();
    assert_eq!(temperatures.len(), 4, "{temperatures:?}");
}
