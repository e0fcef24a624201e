//! The viscosity by momentum exchange against published and independent values; what is told of the flow; what is said of what is wrong.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, estimate, list, printed, table, value};
use serde_json::Value;

/// Naseri et al.'s Ref16: an ideal fluid whose friction carries nearly all of its stress, in a smaller box and at a larger time step.
/// Its flow relaxes in 3.4.
const REFERENCE: &str = r#"
[system]
density = 16.0
box = [6.0, 3.0, 3.0]

[pair.all]
potential = "none"
friction.linear = { coefficient = 5.0, cutoff = 1.0 }

[dynamics]
temperature = 0.1
time_step = 0.01

[run]
replicas = 2
equilibration_time = 5.0
production_time = 60.0
sample_interval = 10

[measure.viscosity]
quantity = "shear_viscosity"
flow = "z"
gradient = "x"
"#;

fn condition(record: &Value, name: &str) -> f64 {
    record["conditions"][name].as_f64().unwrap_or_else(|| panic!("{name} of {record}"))
}

fn warnings(record: &Value) -> String {
    list(&record["warnings"]).iter().map(|warning| format!("{}\n", warning.as_str().unwrap())).collect()
}

#[test]
fn the_reference_fluid_has_the_published_viscosity() {
    let folder = Folder::with(&format!(
        "{REFERENCE}routes.momentum_exchange = {{ stress = 3.42, strain_rate = {{ cutoff = 0.5 }} }}\n"
    ));
    let results = folder.run_for_results("");
    let record = estimate(&results, "viscosity", "momentum_exchange");
    let (viscosity, error) = value(&results, "viscosity", "momentum_exchange");
    // Table 3, third row: the gradient 0.784(4), T_d 0.1033(1), the density 16.0(1), μ 4.36(2).
    assert!(error < 0.03 * viscosity, "{viscosity} ± {error}");
    let [density, density_error] = ["density", "density_standard_error"].map(|name| condition(record, name));
    assert!((density - 16.0).abs() < 0.06 * 16.0, "{density} ± {density_error}");
    // The slabs, colder than the middle, take particles from it in so small a box: friction carries the square of the density.
    let published = 4.36 * (density / 16.0).powi(2);
    let tolerance = error.hypot(0.02).hypot(2.0 * published * density_error / density);
    assert!(((viscosity - published) / tolerance).abs() < 3.0, "{viscosity} ± {error} for {published}");
    let gradient = condition(record, "velocity_gradient");
    assert!((gradient * viscosity / 3.42 - 1.0).abs() < 1e-9);
    assert_eq!(condition(record, "stress"), 3.42);
    assert!((condition(record, "momentum") - 3.42 * 2.0 * 9.0 * 0.01).abs() < 1e-12);
    let [temperature, error] =
        ["dynamic_temperature", "dynamic_temperature_standard_error"].map(|n| condition(record, n));
    // Heated by the flow, though less than far from the slabs; along the flow it would be several times as large.
    assert!(temperature > 0.1 + 3.0 * error && temperature < 0.1033 + 4.0 * error, "{temperature} ± {error}");
    assert!(error < 1e-3);
    // Free of forces, the fluid loses no work but to the thermostat.
    assert!(condition(record, "energy_imbalance") < 1e-9, "{record}");
    let [work, work_error] = ["work_rate", "work_rate_standard_error"].map(|name| condition(record, name));
    let [heat, heat_error] = ["heat_rate", "heat_rate_standard_error"].map(|name| condition(record, name));
    assert!(work > 0.0 && work_error < 0.01 * work, "{work} ± {work_error}");
    assert!(
        (work - heat).abs() < 3.0 * work_error.hypot(heat_error),
        "{work} ± {work_error} and {heat} ± {heat_error}"
    );

    // The profile: odd about both centers, falling from the first slab to the second.
    let (header, rows) = table(&folder, "viscosity-momentum_exchange-profile.csv");
    assert_eq!((header[1].as_str(), rows.len()), ("x [l]", 40));
    for (bin, row) in rows.iter().enumerate() {
        let (center, sign) = match bin {
            0..10 => (0.0, -1.0),
            10..30 => (3.0, 1.0),
            _ => (6.0, -1.0),
        };
        let along = row[1] - center;
        if along.abs() < 0.7 {
            let z = (sign * row[4] + gradient * along) / row[5].hypot(0.01);
            assert!(z.abs() < 4.5, "bin {bin}: {} ± {} at {along}", row[4], row[5]);
            assert!((row[6] - temperature).abs() < 5.0 * row[7], "bin {bin}: {row:?}");
            // The gradient around every particle, by its neighbors, is that of the profile.
            let z = (row[10] + sign * gradient) / row[11].hypot(0.01);
            assert!(z.abs() < 4.5, "bin {bin}: local gradient {} ± {}", row[10], row[11]);
        }
        // In the slabs, four bins each, the exchange counts as heat.
        let given = if (8..12).contains(&(bin % 20)) { condition(record, "momentum").powi(2) / 2.0 } else { 0.0 };
        assert!((row[8] - row[6] - given).abs() < 1e-9, "bin {bin}: {row:?}");
    }
    assert!(folder.read("out/viscosity-momentum_exchange.svg").contains("<circle"));
}

#[test]
fn exchange_and_norton_agree_on_a_fluid_with_forces() {
    let input = FLUID
        .replace("particles = 64\ndensity = 3.0", "density = 3.0\nbox = [3.0, 8.0, 3.0]")
        .replace("coefficient = 4.5", "coefficient = 20.0")
        .replace("equilibration_time = 0.2", "equilibration_time = 10.0")
        .replace("production_time = 4.0", "production_time = 150.0")
        .replace("sample_interval = 2", "sample_interval = 5");
    let measure = "[measure.viscosity]\nquantity = \"shear_viscosity\"\nforcing = \"sinusoidal\"\n\
                   routes.norton = { flux = 0.3 }\nroutes.momentum_exchange = { stress = [0.3, 0.6] }\n\
                   [measure.by_swaps]\nquantity = \"shear_viscosity\"\n\
                   routes.momentum_exchange = { kind = \"swap\", interval = 25 }\n";
    let folder = Folder::with(&format!("{input}\n{measure}"));
    let results = folder.run_for_results("");
    let (norton, norton_error) = value(&results, "viscosity", "norton");
    // The sinusoidal flow is that of k = 2π/8: what that changes is less than the errors.
    for (name, most) in [("viscosity", 0.12), ("by_swaps", 0.08)] {
        let (found, error) = value(&results, name, "momentum_exchange");
        let z = (found - norton) / error.hypot(norton_error);
        assert!(z.abs() < 3.0 && error < most * found, "{name}: {found} ± {error}, Norton {norton} ± {norton_error}");
    }
    assert!(!warnings(estimate(&results, "viscosity", "momentum_exchange")).contains("steady"));
    let swaps = estimate(&results, "by_swaps", "momentum_exchange");
    assert!(condition(swaps, "stress_standard_error") > 0.0);
    // A swap does no work: what friction makes of the flow, swaps take out again.
    assert!(condition(swaps, "work_rate").abs() < 1e-9, "{swaps}");
    let (_, rows) = table(&folder, "viscosity-momentum_exchange.csv");
    assert_eq!(rows.len(), 2);
    for (row, stress) in rows.iter().zip([0.3, 0.6]) {
        // Δp = 2 A Δt Π.
        assert!((row[2] - stress).abs() < 1e-12 && (row[0] - stress * 2.0 * 9.0 * 0.02).abs() < 1e-12, "{row:?}");
        assert!((row[4] * row[6] / stress - 1.0).abs() < 1e-9, "{row:?}");
    }
    let (_, response) = table(&folder, "viscosity-norton.csv");
    assert_eq!(response.len(), 1);
}

#[test]
fn a_flow_that_still_grows_is_told() {
    let input = REFERENCE
        .replace("equilibration_time = 5.0", "equilibration_time = 0.0")
        .replace("production_time = 60.0", "production_time = 2.0");
    // As good as at rest at the start.
    let routes = "routes.momentum_exchange = { stress = 3.42, predicted_viscosity = 1e6 }\n";
    let results = Folder::with(&format!("{input}{routes}")).run_for_results("");
    let record = estimate(&results, "viscosity", "momentum_exchange");
    assert!(warnings(record).contains("no steady state was reached"), "{record}");
    assert!(warnings(record).contains("in which the flow relaxes"), "{record}");
}

#[test]
fn velocity_verlet_exchanges_too_and_tells_no_heat() {
    let input = REFERENCE
        .replace("time_step = 0.01", "time_step = 0.01\nvelocity_verlet = {}")
        .replace("production_time = 60.0", "production_time = 4.0");
    let folder = Folder::with(&format!("{input}routes.momentum_exchange.momentum = 0.6\n"));
    let results = folder.run_for_results("");
    let record = estimate(&results, "viscosity", "momentum_exchange");
    assert!((condition(record, "stress") - 0.6 / (2.0 * 9.0 * 0.01)).abs() < 1e-12);
    assert!(record["conditions"].get("heat_rate").is_none() && record["conditions"].get("energy_imbalance").is_none());
    let (viscosity, _) = value(&results, "viscosity", "momentum_exchange");
    assert!((3.0..6.0).contains(&viscosity), "{viscosity}");
}

#[test]
fn half_the_time_step_leaves_the_stress() {
    let input = REFERENCE.replace("production_time = 60.0", "production_time = 2.0");
    let routes = "routes.momentum_exchange = { momentum = 0.6 }\n[check.time_step]\n";
    let folder = Folder::with(&format!("{input}{routes}"));
    let results = folder.run_for_results("");
    let bias = &list(&results["time_step_check"])[0];
    let [value, half] = ["value", "value_at_half"].map(|name| bias[name].as_f64().unwrap());
    assert!((value / half - 1.0).abs() < 0.3, "{bias}");
    let check = folder.mesoflux("check fluid.toml --threads 1");
    assert!(
        printed(&check).contains("#   momentum_exchange, interval = 1, momentum = 0.6, 2 replicas"),
        "{}",
        printed(&check)
    );
    assert!(
        printed(&check).contains("#   momentum_exchange, interval = 2, momentum = 0.6, 2 replicas"),
        "{}",
        printed(&check)
    );
}
