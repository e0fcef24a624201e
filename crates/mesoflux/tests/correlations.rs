//! Viscosities, diffusion and memory by correlations in time, from the command line.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{CORRELATIONS, FLUID, Folder, error, estimate, table, value};

/// |z| of two estimates as if they were independent.
fn apart((a, error_a): (f64, f64), (b, error_b): (f64, f64)) -> f64 {
    (a - b).abs() / error_a.hypot(error_b)
}

/// A strongly damped soft fluid in a small box, cheap enough for viscosities to a few percent.
fn damped(production: f64) -> String {
    FLUID
        .replace("particles = 64", "particles = 81")
        .replace("coefficient = 4.5", "coefficient = 40.5")
        .replace("time_step = 0.02", "time_step = 0.005")
        .replace("equilibration_time = 0.2", "equilibration_time = 5.0")
        .replace("production_time = 4.0", &format!("production_time = {production:?}"))
}

/// η and ζ from runs of the same fluid that are 20 times as long, by the total stress: Helfand's slope of the discrete dynamics.
const SHEAR_VISCOSITY: (f64, f64) = (1.502, 0.014);
const BULK_VISCOSITY: (f64, f64) = (2.706, 0.061);

#[test]
fn viscosities_and_diffusion_by_every_route_agree() {
    let measures = "
[measure.eta]
quantity = \"shear_viscosity\"
routes.green_kubo = {}
routes.green_kubo_total_stress = {}
routes.einstein_helfand = {}

[measure.zeta]
quantity = \"bulk_viscosity\"
routes.green_kubo = {}

[measure.D]
quantity = \"diffusion_coefficient\"
routes.msd = {}
routes.vacf = {}
";
    let results = Folder::with(&format!("{}{measures}", damped(200.0))).run_for_results("");
    // The noise of the total stress costs precision.
    for (method, precision) in [("green_kubo", 0.05), ("green_kubo_total_stress", 0.1), ("einstein_helfand", 0.1)] {
        let found = value(&results, "eta", method);
        println!("eta by {method}: {found:?}");
        assert!(apart(found, SHEAR_VISCOSITY) < 3.0 && found.1 < precision * found.0, "{method}: {found:?}");
    }
    let (bulk, instantaneous) = (value(&results, "zeta", "green_kubo"), estimate(&results, "eta", "green_kubo"));
    println!("zeta {bulk:?}");
    assert!(apart(bulk, BULK_VISCOSITY) < 3.0 && bulk.1 < 0.03 * bulk.0, "{bulk:?}");
    assert!(instantaneous["conditions"]["instantaneous_part"].as_f64().unwrap() > 1.0);
    let (msd, vacf) = (value(&results, "D", "msd"), value(&results, "D", "vacf"));
    println!("D {msd:?}, {vacf:?}");
    assert!(apart(msd, vacf) < 3.0 && vacf.1 < 0.03 * vacf.0);
    // ξ kT/(6πηL) with the viscosity measured beside, L = 3.
    let conditions = &estimate(&results, "D", "vacf")["conditions"];
    let viscosity = value(&results, "eta", "green_kubo").0;
    let correction = 2.837_297 / (6.0 * std::f64::consts::PI * viscosity * 3.0);
    assert!((conditions["finite_size_correction"].as_f64().unwrap() / correction - 1.0).abs() < 1e-12);
    let infinite = conditions["infinite_system_value"].as_f64().unwrap();
    assert!((infinite - vacf.0 - correction).abs() < 1e-12);
}

#[test]
fn memory_of_an_observable_by_blocking_and_by_correlation() {
    let measures = "
[measure.tau]
quantity = \"correlation_time\"
observable = \"shear_stress\"
routes.blocking = {}
routes.correlation = { sample_interval = 2 }

[measure.spread]
quantity = \"asymptotic_variance\"
observable = \"shear_stress\"
routes.blocking = {}
routes.correlation = { sample_interval = 2 }
";
    let results = Folder::with(&format!("{}{measures}", damped(200.0))).run_for_results("");
    for measurement in ["tau", "spread"] {
        let (blocking, correlation) =
            (value(&results, measurement, "blocking"), value(&results, measurement, "correlation"));
        println!("{measurement}: {blocking:?}, {correlation:?}");
        assert!(apart(blocking, correlation) < 3.0 && correlation.1 < 0.2 * correlation.0);
    }
}

#[test]
fn the_kinetic_temperature_has_the_density_of_its_distribution() {
    let measures = "
[measure.p_of_T]
quantity = \"probability_density\"
observable = \"temperature\"
routes.counting = { range = [0.4, 1.9], bins = 15 }
";
    let folder = Folder::with(&format!("{}{measures}", damped(100.0)));
    let results = folder.run_for_results("");
    let found = estimate(&results, "p_of_T", "counting");
    assert!((found["conditions"]["at"].as_f64().unwrap() - 1.0).abs() < 0.11, "{found}");
    let (_, rows) = table(&folder, "p_of_T-counting.csv");
    // A gamma distribution of 3(N − 1)/2 = 120 with the mean 1, by the midpoint rule.
    let density = |t: f64| ((119.0 * t.ln()) - 120.0 * t + 120.0 * 120.0_f64.ln() - LN_GAMMA_120).exp();
    for row in rows.iter().filter(|row| row[4] > 200.0) {
        let points = 200;
        let width = (row[1] - row[0]) / f64::from(points);
        let mean = (0..points).map(|k| density(row[0] + (f64::from(k) + 0.5) * width)).sum::<f64>() / f64::from(points);
        assert!((row[2] - mean).abs() < 3.5 * row[3], "{row:?} against {mean}");
    }
    assert!(rows.iter().filter(|row| row[4] > 200.0).count() >= 5, "{rows:?}");
}

/// ln Γ(120) = ln 119!.
const LN_GAMMA_120: f64 = 453.024_896_238;

#[test]
fn short_runs_cannot_tell_and_say_how_much_longer() {
    let short = FLUID.replace("production_time = 4.0", "production_time = 1.0");
    let results = Folder::with(&format!("{short}{CORRELATIONS}")).run_for_results("");
    for (measurement, method) in [("eta", "green_kubo"), ("eta", "green_kubo_total_stress"), ("zeta", "green_kubo")] {
        let estimate = estimate(&results, measurement, method);
        assert!(estimate["value"].is_null() && estimate["standard_error"].is_null(), "{estimate}");
        let warning = estimate["warnings"][0].as_str().unwrap();
        assert!(warning.starts_with("cannot tell yet") && warning.contains("times longer"), "{warning}");
    }
}

#[test]
fn recorders_of_correlations_go_on_to_the_same_bits() {
    let folder = Folder::with(&format!("{FLUID}{CORRELATIONS}"));
    folder.run("--quiet --out short --set run.production_time=8.0");
    let longer = folder.mesoflux("resume short --quiet --set run.production_time=20.0 --threads 3");
    assert_eq!((longer.status.code(), error(&longer)), (Some(0), ""));
    folder.run("--quiet --out long --threads 1 --set run.production_time=20.0");
    folder.assert_same_results("short", "long");
    // With velocity Verlet, too, which books a force twice.
    let verlet = "--set dynamics.velocity_verlet.lambda=0.5";
    folder.run(&format!("--quiet --out a {verlet} --set run.production_time=7.0"));
    let longer = folder.mesoflux("resume a --quiet --set run.production_time=15.0");
    assert_eq!((longer.status.code(), error(&longer)), (Some(0), ""));
    folder.run(&format!("--quiet --out b {verlet} --set run.production_time=15.0"));
    folder.assert_same_results("a", "b");
}

#[test]
fn sampling_changes_no_trajectory() {
    let temperature = "\n[measure.T]\nquantity = \"temperature\"\n";
    let plain = Folder::with(&format!("{FLUID}{temperature}")).run_for_results("");
    let sampled = Folder::with(&format!("{FLUID}{temperature}{CORRELATIONS}")).run_for_results("");
    assert_eq!(estimate(&plain, "T", "kinetic")["value"], estimate(&sampled, "T", "kinetic")["value"]);
}
