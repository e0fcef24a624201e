//! The whole benchmark on tiny systems: every part runs, and what it writes can be read. No time is judged.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn bench(arguments: &[&str], output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesoflux-bench"));
    command
        .args(["--inputs", ".", "--small", "--rounds", "2", "--seconds", "0.01", "--lammps", "none", "--output"])
        .arg(output);
    command.args(arguments).env_remove("MESOFLUX_LAMMPS").output().expect("the benchmark starts")
}

fn succeeded(arguments: &[&str], output: &Path) {
    let result = bench(arguments, output);
    assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
}

fn json(directory: &Path, name: &str) -> Value {
    let bytes = std::fs::read(directory.join(name)).expect("the benchmark wrote its results");
    serde_json::from_slice(&bytes).expect("results are JSON")
}

fn positive(value: &Value) -> bool {
    value.as_f64().is_some_and(|number| number > 0.0 && number.is_finite())
}

#[test]
fn every_part_writes_its_results_and_the_page_shows_them() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    succeeded(&[], directory);

    let results = json(directory, "results.json");
    let rows = results.as_array().unwrap();
    // Groot and Warren's fluid with two integrators, three works with one; each on one thread and on two.
    assert_eq!(rows.len(), 10);
    for row in rows {
        assert!(positive(&row["particle_steps_per_second"]), "{row}");
        assert!(row["lammps_particle_steps_per_second"].is_null() && row["ratio"].is_null(), "{row}");
        assert!(row["rounds"] == 2 && row["precision"] == "double" && positive(&row["particles"]), "{row}");
    }
    for work in ["groot-warren", "ideal-16", "ideal-32", "lj-dpd"] {
        for threads in [1, 2] {
            assert!(rows.iter().any(|row| row["work"] == work && row["threads"] == threads), "{work} on {threads}");
        }
    }
    let kernels = json(directory, "kernels.json");
    for work in kernels["works"].as_array().unwrap() {
        for kernel in work["kernels"].as_array().unwrap() {
            assert!(positive(&kernel["nanoseconds_per_pair"]["median"]), "{kernel}");
            assert!(positive(&kernel["cycles_per_pair"]["median"]), "{kernel}");
        }
        for profile in work["profiles"].as_array().unwrap() {
            let shares = profile["phases"].as_array().unwrap().iter().map(|phase| phase["share"].as_f64().unwrap());
            assert!((shares.sum::<f64>() - 1.0).abs() < 1e-9, "{profile}");
        }
    }
    assert!(
        json(directory, "ours.json")["ratios"].as_array().unwrap().iter().all(|row| positive(&row["ratio"]["median"]))
    );
    assert_eq!(json(directory, "scale.json")["sizes"].as_array().unwrap().len(), 4);
    let page = std::fs::read_to_string(directory.join("RESULTS.md")).unwrap();
    for heading in ["## Machine", "## Against LAMMPS", "## Our own routes", "## Kernels", "## Scale"] {
        assert!(page.contains(heading), "{heading} is missing");
    }
    assert!(!page.contains("NaN"));
}

#[test]
fn a_part_that_is_run_again_leaves_the_others_as_they_are() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    succeeded(&["--work", "ideal-16"], directory);
    let before = json(directory, "results.json");
    succeeded(&["--scale"], directory);
    assert_eq!(json(directory, "results.json"), before);
    succeeded(&["--work", "lj-dpd"], directory);
    assert_eq!(json(directory, "results.json").as_array().unwrap().len(), 4);
    assert!(std::fs::read_to_string(directory.join("RESULTS.md")).unwrap().contains("## Scale"));
}

#[test]
fn an_unknown_work_is_refused_with_the_known_ones() {
    let directory = tempfile::tempdir().unwrap();
    let result = bench(&["--work", "ideal"], directory.path());
    assert_eq!(result.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&result.stderr).contains("ideal-16"));
}
