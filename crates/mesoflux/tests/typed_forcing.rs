//! The transport coefficient of a typed forcing against the shear viscosity and the mobility of the built-in one.
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, estimate, value};
use std::f64::consts::TAU;

const TYPED: &str = r#"
[measure.viscosity]
quantity = "shear_viscosity"
forcing = "sinusoidal"
routes.nemd = { magnitude = [1.0, 2.0] }
routes.norton = { flux = [0.4, 0.8] }

[measure.shear]
quantity = "transport_coefficient"
forcing.expression = { force = ["sin(2*pi*y/ly)", "0", "0"], response = ["2*a*sin(2*pi*y/ly)/n", "0", "0"], parameters = { a = 2.0 } }
routes.nemd = { magnitude = [1.0, 2.0] }
routes.norton = { flux = [1.6, 3.2] }

[measure.mobility]
quantity = "mobility"
forcing = "color_drift"
routes.nemd = { magnitude = 20.0 }

[measure.drift]
quantity = "transport_coefficient"
forcing.expression = { force = ["color/sqrt(n)", "0", "0"], response = ["color/sqrt(n)", "0", "0"] }
routes.nemd = { magnitude = 20.0 }
"#;

#[test]
fn typed_forcings_tell_what_the_built_in_ones_do() {
    let input = FLUID
        .replace("particles = 64", "particles = 192")
        .replace("coefficient = 4.5", "coefficient = 40.0")
        .replace("time_step = 0.02", "time_step = 0.01")
        .replace("equilibration_time = 0.2", "equilibration_time = 4.0")
        .replace("production_time = 4.0", "production_time = 40.0");
    let results = Folder::with(&format!("{input}{TYPED}")).run_for_results("");
    // η = (ρ/k²)|F₁|/α, |F₁| = 1/2, for a response of sin(ky)/N; ours is four times that.
    let (wavenumber, density) = (TAU / 4.0, 3.0);
    let viscosity = |alpha: f64| density / wavenumber.powi(2) * 0.5 / (alpha / 4.0);
    for method in ["nemd", "norton"] {
        let (expected, its_error) = value(&results, "viscosity", method);
        let (alpha, error) = value(&results, "shear", method);
        let (found, error) = (viscosity(alpha), viscosity(alpha) * error / alpha);
        let z = (found - expected) / error.hypot(its_error);
        println!("{method}: {found} ± {error} for {expected} ± {its_error}");
        assert!(z.abs() < 4.0 && error < 0.06 * found, "{method}: {found} ± {error} for {expected} ± {its_error}");
        // Other texts, other noise.
        assert!(found != expected);
        let record = estimate(&results, "shear", method);
        assert_eq!(
            (&record["quantity"], &record["conditions"]["remove_mean_force"]),
            (&"transport_coefficient".into(), &true.into())
        );
    }
    let ((found, error), (expected, its_error)) =
        (value(&results, "drift", "nemd"), value(&results, "mobility", "nemd"));
    println!("drift: {found} ± {error} for {expected} ± {its_error}");
    assert!((found - expected).abs() < 4.0 * error.hypot(its_error) && error < 0.2 * found);
}
