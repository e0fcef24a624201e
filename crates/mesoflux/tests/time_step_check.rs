//! `[check.time_step]`: what each estimate owes to the time step.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, MEASURES, STRUCTURE, list, printed};
use serde_json::Value;

const CHECK: &str = "\n[check.time_step]\n";

#[test]
fn the_estimates_are_what_they_would_be_without_the_check() {
    let sweep = "[sweep]\ndynamics.temperature = [1.0, 1.5]\n";
    let plain = format!("{FLUID}{MEASURES}{STRUCTURE}{sweep}");
    let folder = Folder::with(&plain);
    folder.run("--quiet --out plain");
    folder.write("fluid.toml", format!("{plain}{CHECK}"));
    folder.run("--quiet --out checked");
    let (plain, checked) = (folder.results("plain"), folder.results("checked"));
    for field in ["estimates", "comparisons"] {
        assert_eq!(plain[field], checked[field]);
    }
    assert!(plain.get("time_step_check").is_none());
    let (checks, estimates) = (list(&checked["time_step_check"]), list(&checked["estimates"]));
    assert_eq!(checks.len(), estimates.len());
    for (check, estimate) in checks.iter().zip(estimates) {
        for field in ["measurement", "quantity", "method", "value"] {
            assert_eq!(check[field], estimate[field], "{check}");
        }
        let temperature = "dynamics.temperature";
        assert_eq!(check["conditions"][temperature], estimate["conditions"][temperature]);
        let number = |value: &Value, field: &str| value[field].as_f64();
        let Some(bias) = number(check, "bias") else {
            assert!(check["value"].is_null() || check["value_at_half"].is_null(), "{check}");
            continue;
        };
        let [value, half] = ["value", "value_at_half"].map(|field| number(check, field).unwrap());
        assert!(value != half, "independent runs: {check}");
        assert!((bias - (value - half)).abs() < 1e-12 * value.abs());
        assert!((number(check, "extrapolated").unwrap() - (half - bias / 3.0)).abs() < 1e-9 * value.abs());
        if let (Some(error), Some(z)) = (number(check, "standard_error"), number(check, "z")) {
            assert!(error > number(estimate, "standard_error").unwrap());
            assert!((z * error - bias).abs() < 1e-9 * value.abs());
            assert!(number(check, "extrapolated_standard_error").unwrap() > 0.0);
        }
    }
    // Every run once more with half the step: twice the steps, over the same times.
    let (runs, all) = (list(&plain["runs"]), list(&checked["runs"]));
    assert_eq!(all.len(), 2 * runs.len());
    let halves: Vec<&Value> = all.iter().filter(|run| run["point"]["dynamics.time_step"] == 0.01).collect();
    assert_eq!(halves.len(), runs.len());
    assert!(halves.iter().all(|run| run["steps"] == 400));
    // The tables are those of the input's own step.
    for name in ["g-histogram-2.csv", "mobility-nemd-1.csv"] {
        assert_eq!(folder.read(&format!("plain/{name}")), folder.read(&format!("checked/{name}")));
    }
}

/// Groot and Warren's scheme heats: kT = 1.026 at Δt = 0.04, 1.0065 to 1.014 at half of it.
#[test]
fn the_heat_of_velocity_verlet_is_seen() {
    let input = FLUID
        .replace("time_step = 0.02", "time_step = 0.04\nvelocity_verlet = { lambda = 0.5 }")
        .replace("particles = 64", "particles = 192")
        .replace("equilibration_time = 0.2", "equilibration_time = 5.0")
        .replace("production_time = 4.0", "production_time = 300.0");
    let folder = Folder::with(&format!("{input}[measure.T]\nquantity = \"temperature\"\n{CHECK}"));
    let output = folder.run("--out out");
    let check = &folder.results("out")["time_step_check"][0];
    println!("{check}");
    let number = |field: &str| check[field].as_f64().unwrap();
    assert!(number("z") > 4.0 && number("bias") > 0.008, "{check}");
    assert!((number("value") - 1.026).abs() < 0.006, "{check}");
    assert!((number("extrapolated") - 1.0).abs() < 0.015, "{check}");
    assert!(printed(&output).contains("time step: T by kinetic: ") && printed(&output).contains("BIASED"));
}

#[test]
fn a_checked_run_made_longer_has_the_bits_of_one_that_was_long_from_the_start() {
    let folder = Folder::with(&format!("{FLUID}{STRUCTURE}{CHECK}"));
    folder.run("--quiet --out short");
    assert!(folder.mesoflux("resume short --quiet --set run.production_time=6.0").status.success());
    folder.run("--quiet --out long --set run.production_time=6.0");
    folder.assert_same_results("short", "long");
    let check = |out: &str| folder.results(out)["time_step_check"].clone();
    assert_eq!(check("short"), check("long"));
}
