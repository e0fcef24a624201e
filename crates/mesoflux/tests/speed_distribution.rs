//! The distribution of speeds: Maxwell's, with the total momentum fixed, of every mass; and what is said where it isn't.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{Folder, estimate, list, table, value};
use serde_json::Value;

/// A dozen particles without forces: what fixes their momentum takes a twelfth of each one's variance.
const DOZEN: &str = r#"
[system]
particles = 12
density = 1.0

[pair.all]
potential = "none"
friction.dot = { coefficient = 20.0, thinning = 1.0, cutoff = 1.0 }

[dynamics]
temperature = 0.1
time_step = 0.02

[run]
seed = 3
equilibration_time = 10.0
production_time = 20000.0

[measure.speeds]
quantity = "speed_distribution"
"#;

fn condition(record: &Value, name: &str) -> f64 {
    record["conditions"][name].as_f64().unwrap_or_else(|| panic!("{name} of {record}"))
}

#[test]
fn a_dozen_particles_with_their_momentum_fixed() {
    let folder = Folder::with(DOZEN);
    let results = folder.run_for_results("");
    let record = estimate(&results, "speeds", "speed_histogram");
    let (temperature, error) = value(&results, "speeds", "speed_histogram");
    assert!(error < 0.01 * temperature && (temperature - 0.1).abs() < 3.5 * error, "{temperature} ± {error}");
    assert!(condition(record, "samples") > 4e4, "{record}");
    for name in ["p_value", "shape_p_value"] {
        assert!(condition(record, name) > 0.001, "{record}");
    }
    let [kurtosis, error] = ["kurtosis", "kurtosis_standard_error"].map(|name| condition(record, name));
    assert!(error < 0.03 && (kurtosis - 3.0).abs() < 3.5 * error, "{kurtosis} ± {error}");
    assert!(list(&record["warnings"]).is_empty(), "{record}");

    // The table: normalized, and Maxwell's density for 11/12 of kT.
    let (header, rows) = table(&folder, "speeds-speed_histogram.csv");
    assert_eq!(header, ["speed [v]", "density [1/v]", "standard_error [1/v]", "maxwell [1/v]"]);
    assert_eq!(rows.len(), 150);
    let width = rows[1][0] - rows[0][0];
    for column in [1, 3] {
        let sum: f64 = rows.iter().map(|row| row[column] * width).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    }
    let variance = 0.1 * 11.0 / 12.0;
    let v = rows[40][0];
    let density =
        (2.0 / std::f64::consts::PI).sqrt() * v * v * (-v * v / (2.0 * variance)).exp() / f64::powf(variance, 1.5);
    assert!((rows[40][3] / density - 1.0).abs() < 2e-3, "{} for {density}", rows[40][3]);
    assert!(folder.read("out/speeds-speed_histogram.svg").contains("Maxwell"));
}

#[test]
fn masses_have_distributions_of_their_own() {
    let species = "[species.light]\nparticles = 8\n[species.heavy]\nparticles = 8\nmass = 4.0\n";
    let input = DOZEN.replace("particles = 12\n", "").replace("[pair.all]", &format!("{species}[pair.all]"));
    let input = input.replace("production_time = 20000.0", "production_time = 8000.0");
    let folder = Folder::with(&format!("{input}routes.speed_histogram = {{ bins = 60, sample_interval = 100 }}\n"));
    let results = folder.run_for_results("");
    let record = estimate(&results, "speeds", "speed_histogram");
    let (temperature, error) = value(&results, "speeds", "speed_histogram");
    assert!((temperature - 0.1).abs() < 3.5 * error, "{temperature} ± {error}");
    for name in ["light", "heavy"] {
        assert!(condition(record, &format!("p_value_{name}")) > 0.001, "{record}");
        assert_eq!(condition(record, &format!("samples_{name}")), 8.0 * 4000.0);
    }
    let (header, rows) = table(&folder, "speeds-speed_histogram.csv");
    let columns = [1, 3, 4, 6].map(|column| header[column].as_str());
    assert_eq!(columns, ["density_heavy [1/v]", "maxwell_heavy [1/v]", "density_light [1/v]", "maxwell_light [1/v]"]);
    let fastest = |column: usize| rows.iter().max_by(|a, b| a[column].total_cmp(&b[column])).unwrap()[0];
    assert!((fastest(6) / fastest(3) - 2.0).abs() < 0.3, "{} and {}", fastest(3), fastest(6));
}

#[test]
fn what_the_explicit_scheme_makes_too_hot_is_told() {
    let input = DOZEN
        .replace("particles = 12\ndensity = 1.0", "particles = 200\ndensity = 16.0")
        .replace(
            "friction.dot = { coefficient = 20.0, thinning = 1.0, cutoff = 1.0 }",
            "friction.linear = { coefficient = 5.0, cutoff = 1.0 }",
        )
        .replace("time_step = 0.02", "time_step = 0.01\nexplicit = {}")
        .replace("production_time = 20000.0", "production_time = 150.0");
    let results = Folder::with(&input).run_for_results("");
    let record = estimate(&results, "speeds", "speed_histogram");
    // Each velocity decays by friction alone at the rate a = 4πργ/(3m) ∫(1 − r)² r² dr (N − 1)/N; five correlation times, 5/a.
    let rate = 4.0 / 3.0 * std::f64::consts::PI * 16.0 * 5.0 / 30.0;
    assert_eq!(condition(record, "sample_interval"), (5.0 / (rate * 0.01)).ceil());
    let (temperature, error) = value(&results, "speeds", "speed_histogram");
    let expected = 0.1 / (1.0 - 0.5 * rate * 0.01);
    assert!(error < 0.01 * expected && (temperature - expected).abs() < 3.5 * error, "{temperature} ± {error}");
    assert!(condition(record, "p_value") < 1e-6 && condition(record, "shape_p_value") > 0.001, "{record}");
    assert!(
        list(&record["warnings"]).iter().any(|warning| warning.as_str().unwrap().contains("not those of Maxwell")),
        "{record}"
    );
}
