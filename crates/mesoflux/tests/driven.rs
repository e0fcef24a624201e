//! What driven routes write beside the coefficient: fluctuations, memory, spread and profiles, against what is known exactly.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, MEASURES, estimate, list, table, value};
use mesoflux_analysis::{normal_cdf, standard_normal_summary};
use serde_json::Value;
use std::f64::consts::TAU;

fn condition(results: &Value, measurement: &str, method: &str, name: &str) -> f64 {
    let estimate = estimate(results, measurement, method);
    estimate["conditions"][name].as_f64().unwrap_or_else(|| panic!("{name} of {estimate}"))
}

fn warnings(results: &Value, measurement: &str, method: &str) -> String {
    list(&estimate(results, measurement, method)["warnings"]).iter().map(|warning| warning.as_str().unwrap()).collect()
}

#[test]
fn tables_have_their_columns() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    let results = folder.run_for_results("");
    let fluctuations = |unit: &str| {
        format!(
            "kinetic_temperature [e],variance [{unit}^2],standard_error [{unit}^2],correlation_time [t],standard_error [t],\
             response_asymptotic_variance [{unit}^2 t],standard_error [{unit}^2 t],\
             asymptotic_variance [v^2 t/f^2],standard_error [v^2 t/f^2]"
        )
    };
    let correlation = |unit: &str| {
        format!(
            "time [t],autocorrelation [{unit}^2],standard_error [{unit}^2],normalized_autocorrelation [1],standard_error [1]"
        )
    };
    let density = |unit: &str| format!("value [{unit}],probability_density [1/{unit}],standard_error [1/{unit}]");
    let check = "forcing_observable [f],booked_minus_observable [f],standard_error [f]";
    let profile = "density [1/l^3],standard_error [1/l^3],velocity [v],standard_error [v],temperature [e],standard_error [e],\
                   stress [e/l^3],standard_error [e/l^3],upper_y [l],stress_gradient [e/l^4],standard_error [e/l^4],\
                   force_density [e/l^4],standard_error [e/l^4]";
    for (name, expected, rows) in [
        ("mobility-nemd", format!("magnitude [f],flux [v],standard_error [v],{}", fluctuations("v")), Some(2)),
        ("mobility-nemd-autocorrelation", format!("magnitude [f],{}", correlation("v")), None),
        ("mobility-nemd-histogram", format!("magnitude [f],{}", density("v")), Some(100)),
        ("mobility-norton", format!("flux [v],forcing [f],standard_error [f],{},{check}", fluctuations("f")), Some(1)),
        ("mobility-norton-histogram", format!("flux [v],{}", density("f")), Some(10)),
        ("viscosity-norton", format!("flux [v],forcing [f],standard_error [f],{}", fluctuations("f")), Some(2)),
        ("viscosity-norton-autocorrelation", format!("flux [v],{}", correlation("f")), None),
        ("viscosity-norton-profile", format!("flux [v],y [l],{profile}"), Some(8)),
    ] {
        let (header, found) = table(&folder, &format!("{name}.csv"));
        assert_eq!(header.join(","), expected, "{name}");
        assert!(rows.is_none_or(|rows| found.len() == rows), "{name}: {} rows", found.len());
    }
    assert_eq!(estimate(&results, "mobility", "nemd")["table"], "mobility-nemd.csv");
    let (_, correlations) = table(&folder, "viscosity-norton-autocorrelation.csv");
    assert!(correlations.iter().all(|row| row[1] <= 0.1 + 1e-12) && correlations.len() > 2, "{correlations:?}");
    // How often the structure is renewed: D = kT α, particles as large as the cutoff.
    let (mobility, _) = value(&results, "mobility", "nemd");
    let relaxations = condition(&results, "mobility", "nemd", "structural_relaxations");
    assert!((relaxations / (4.0 * 6.0 * mobility) - 1.0).abs() < 1e-12);
    assert!(warnings(&results, "mobility", "nemd").contains("it should be 100 times as long"));
}

/// At η = 0 the flux R = Σ ±v_i/√N of a fluid at rest is normal with variance kT/m, whatever the forces.
#[test]
fn the_flux_of_a_fluid_in_equilibrium_is_normal() {
    let input = FLUID
        .replace("temperature = 1.0", "temperature = 0.5")
        .replace("potential.soft = { repulsion = 25.0, cutoff = 1.0 }", "potential = \"none\"")
        .replace("coefficient = 4.5", "coefficient = 10.0")
        .replace("production_time = 4.0", "production_time = 400.0")
        .replace("sample_interval = 2", "sample_interval = 1");
    let measure = "
[measure.mobility]
quantity = \"mobility\"
forcing = \"color_drift\"
routes.nemd = { magnitude = 0.0, autocorrelation = { sample_interval = 1 }, histogram = { range = [-1.5, 1.5], bins = 12 } }
";
    let folder = Folder::with(&format!("{input}{measure}"));
    let results = folder.run_for_results("");
    let record = estimate(&results, "mobility", "nemd");
    assert!(record["value"].is_null());
    assert!(warnings(&results, "mobility", "nemd").contains("cannot tell: every magnitude is zero"), "{record}");
    let (_, rows) = table(&folder, "mobility-nemd.csv");
    let [magnitude, flux, flux_error, _, variance, variance_error, time, _, asymptotic, _, estimator, estimator_error] =
        rows[0][..]
    else {
        panic!("{rows:?}");
    };
    assert_eq!(magnitude, 0.0);
    assert!((flux / flux_error).abs() < 3.5, "{flux} ± {flux_error}");
    assert!(estimator.is_nan() && estimator_error.is_nan());
    let z = (variance - 0.5) / variance_error;
    assert!(z.abs() < 3.5 && variance_error < 0.03, "{variance} ± {variance_error}");
    assert!((asymptotic / (2.0 * variance * time) - 1.0).abs() < 5e-3, "{asymptotic}, 2 · {variance} · {time}");
    // Counts at every step against the normal distribution.
    let (_, rows) = table(&folder, "mobility-nemd-histogram.csv");
    let width = 0.25;
    let scores = rows.iter().map(|row| {
        let share = |end: f64| normal_cdf(end / 0.5f64.sqrt());
        let expected = (share(row[1] + 0.5 * width) - share(row[1] - 0.5 * width)) / width;
        (row[2] - expected) / row[3]
    });
    let summary = standard_normal_summary(&scores.collect::<Vec<_>>()).unwrap();
    assert!(summary.variance_p_value > 1e-3 && summary.largest < 4.0, "{summary:?}");
    let outside = 2.0 * normal_cdf(-1.5 / 0.5f64.sqrt());
    assert!((condition(&results, "mobility", "nemd", "histogram_share_outside") / outside - 1.0).abs() < 0.2);
    // The correlation begins at the variance, its integral is the one by blocking.
    let (_, rows) = table(&folder, "mobility-nemd-autocorrelation.csv");
    assert!((rows[0][2] / variance - 1.0).abs() < 5e-3 && rows[0][4] == 1.0 && rows[0][5] < 1e-9, "{:?}", rows[0]);
    let decayed = rows.iter().find(|row| row[1] > 3.0 * time).unwrap();
    assert!(decayed[4] < 0.5 && decayed[5] > 0.0, "{decayed:?}");
    let early = &rows[1];
    // What C(t) and C(0) share of their fluctuations is not in the error of their ratio.
    assert!(early[5] < 0.5 * early[3] / rows[0][2], "{early:?}");
}

/// A fluid whose friction carries most of its stress, sheared by a sinusoidal force.
fn sheared(routes: &str) -> Folder {
    let input = FLUID
        .replace("particles = 64", "particles = 192")
        .replace("coefficient = 4.5", "coefficient = 40.0")
        .replace("time_step = 0.02", "time_step = 0.01")
        .replace("equilibration_time = 0.2", "equilibration_time = 5.0")
        .replace("production_time = 4.0", "production_time = 80.0");
    let measure = "[measure.viscosity]\nquantity = \"shear_viscosity\"\nforcing = \"sinusoidal\"\nflow = \"z\"\ngradient = \"x\"\n";
    Folder::with(&format!("{input}\n{measure}{routes}\n"))
}

/// The rows of a profile against what is known of it, given the mean forcing, the mean flux and the kinetic temperature of the whole.
fn check_profile(rows: &[Vec<f64>], forcing: f64, flux: f64, kinetic: f64) {
    let bins = rows.len() as f64;
    let (side, half) = (4.0, 0.5 * TAU / bins);
    // Averages of a sine over a bin, and with the weight of a face, a triangle two bins wide.
    let (over_bin, over_face) = (half.sin() / half, (half.sin() / half).powi(2));
    let mut scores = Vec::new();
    for row in rows {
        let phase = TAU * row[1] / side;
        scores.push((row[2] - 3.0) / row[3]);
        // U_1 = 2R: the flow is as sinusoidal as the force.
        scores.push((row[4] - 2.0 * flux * phase.sin() * over_bin) / row[5]);
        // Of the whole, m u²/3 belongs to the flow; friction heats where the shear is strong, by a percent or two.
        let thermal = kinetic - (2.0 * flux).powi(2) / 6.0;
        let tolerance = 4.0 * row[7] + 0.1 * flux.abs();
        assert!((row[6] - thermal).abs() < tolerance && row[7] < 0.01, "{} ± {} for {thermal}", row[6], row[7]);
        let expected = 3.0 * forcing * (TAU * row[10] / side).sin() * over_face;
        assert!((row[13] - expected).abs() <= 0.02 * 3.0 * forcing.abs(), "{} for {expected}", row[13]);
        // σ is the integral of the force from where it vanishes: −(ρη/k) cos(ky).
        let stress = -3.0 * forcing * side / TAU * phase.cos() * over_bin;
        assert!((row[8] - stress).abs() < 4.0 * row[9] + 0.02 * 3.0 * forcing.abs(), "{} for {stress}", row[8]);
    }
    let summary = standard_normal_summary(&scores).unwrap();
    assert!(summary.largest < 4.0 && summary.variance < 1.8, "{summary:?}");
}

#[test]
fn a_sheared_fluid_has_the_profile_of_its_force() {
    let folder = sheared("routes.nemd = { magnitude = [0.0, 2.0], profile = { bins = 8 } }");
    let results = folder.run_for_results("");
    let z = condition(&results, "viscosity", "nemd", "momentum_balance_z");
    assert!(z > 0.0 && z < 4.0, "{z}");
    assert!(!warnings(&results, "viscosity", "nemd").contains("gradient of the stress"));
    let (header, rows) = table(&folder, "viscosity-nemd-profile.csv");
    assert_eq!((header[1].as_str(), header[10].as_str()), ("x [l]", "upper_x [l]"));
    let (_, response) = table(&folder, "viscosity-nemd.csv");
    check_profile(&rows[..8], 0.0, response[0][1], response[0][3]);
    check_profile(&rows[8..], 2.0, response[1][1], response[1][3]);
    // The viscosity by the route is that of the profile's own slope: −σ/(∂u/∂x) of the first harmonics.
    let harmonic = |column: usize, quarter: f64| {
        let wave = |row: &Vec<f64>| row[column] * (TAU * (row[1] / 4.0 + quarter)).sin();
        rows[8..].iter().map(wave).sum::<f64>()
    };
    let (viscosity, error) = value(&results, "viscosity", "nemd");
    let found = -harmonic(8, 0.25) / (harmonic(4, 0.0) * TAU / 4.0);
    assert!((found - viscosity).abs() < 4.0 * error, "{found} and {viscosity} ± {error}");
}

#[test]
fn momentum_is_balanced_at_a_constant_flux() {
    let folder = sheared("routes.norton = { flux = 0.15, profile = { bins = 8 } }");
    let results = folder.run_for_results("");
    let z = condition(&results, "viscosity", "norton", "momentum_balance_z");
    assert!(z > 0.0 && z < 4.0, "{z}");
    let (_, rows) = table(&folder, "viscosity-norton-profile.csv");
    let (_, response) = table(&folder, "viscosity-norton.csv");
    check_profile(&rows, response[0][1], 0.15, response[0][3]);
}

#[test]
fn strengths_beyond_the_linear_regime_are_said() {
    let measure = "[measure.mobility]\nquantity = \"mobility\"\nforcing = \"color_drift\"\n\
                   routes.nemd = { magnitude = [0.0, 4.0, 8.0, 200.0] }";
    let input = FLUID.replace("production_time = 4.0", "production_time = 40.0");
    let results = Folder::with(&format!("{input}\n{measure}\n")).run_for_results("");
    assert!(warnings(&results, "mobility", "nemd").contains("magnitude = 200 lies outside of the linear regime"));
    assert_eq!(condition(&results, "mobility", "nemd", "largest_linear_magnitude"), 8.0);
}
