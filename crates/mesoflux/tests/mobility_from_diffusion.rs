//! The mobility from the mean squared displacement against the diffusion coefficient of the same run.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, list};

/// With total momentum zero, α = βD N/(N − 1); seen at kT = 2, which two routes over one run share but for this factor.
#[test]
fn mobility_is_diffusion_over_temperature_times_n_over_n_minus_1() {
    let measures = "
[measure.D]
quantity = \"diffusion_coefficient\"
routes.msd = { longest_lag = 4.0 }

[measure.mobility]
quantity = \"mobility\"
forcing = \"color_drift\"
routes.msd = { longest_lag = 4.0 }
";
    let input = FLUID
        .replace("temperature = 1.0", "temperature = 2.0")
        .replace("production_time = 4.0", "production_time = 40.0");
    let results = Folder::with(&format!("{input}{measures}")).run_for_results("");
    let estimates = list(&results["estimates"]);
    let find = |quantity: &str| estimates.iter().find(|estimate| estimate["quantity"] == quantity).unwrap();
    for field in ["value", "standard_error"] {
        let ratio = find("mobility")[field].as_f64().unwrap() / find("diffusion_coefficient")[field].as_f64().unwrap();
        assert!((ratio / (64.0 / 63.0 / 2.0) - 1.0).abs() < 1e-12, "{field}: {ratio}");
    }
}
