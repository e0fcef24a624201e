//! Stochastic Norton dynamics: of which order in the time step the mean forcing is.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, forcing, replicas};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::driving::{ConstantFlux, Projection};
use mesoflux_core::forcing::{ForcingChoice, ForcingKind, Wave};
use mesoflux_core::noise::NoiseKey;

/// A flux held in an ideal fluid, far beyond the linear regime, so that the forcing is seen well above its fluctuations: the order
/// in the time step is the same.
#[derive(Debug, Clone)]
struct Case {
    forcing: ForcingChoice,
    friction: f64,
    flux: f64,
    /// The smallest of three steps, each twice the one before.
    step: f64,
}

/// ⟨λ⟩.
fn mean_forcing(case: &Case, projection: Projection, dt: f64, seed: u64) -> Estimate {
    let fluid = Fluid::ideal(192, case.friction);
    let parts = replicas(2, |replica| {
        let noise = NoiseKey::new(&[seed, dt.to_bits(), projection as u64, replica]);
        let system = fluid.system(1.0, noise);
        let field = case.forcing.field(system.particles.count(), system.region.sides()).unwrap();
        let driving = Box::new(ConstantFlux::new(field, case.flux, projection));
        let mut simulation = fluid.simulation("ABOBA", Some(driving), noise, dt);
        advance(&mut simulation, 10.0);
        let mut series = Blocking::new(1).unwrap();
        for _ in 0..20_000 {
            series.record(&[simulation.step().unwrap().unwrap().forcing]).unwrap();
        }
        series
    });
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap();
    parts.for_each(|part| all.merge(&part).unwrap());
    all.estimate()
}

/// b of ⟨λ⟩(Δt) = a + bΔt + cΔt² through three steps, and its error.
fn first_order(case: &Case, projection: Projection, seed: u64) -> (f64, f64) {
    // Lagrange's weights for the slope at zero from nodes in the ratio 1 : 2 : 4.
    let plan = [(1.0, -2.0), (2.0, 2.5), (4.0, -0.5)];
    let (mut slope, mut variance) = (0.0, 0.0);
    for (node, weight) in plan {
        let forcing = mean_forcing(case, projection, node * case.step, seed);
        let (value, error) = (forcing.value.unwrap(), forcing.standard_error.unwrap());
        println!("{projection:?}, Δt = {}: λ = {value:.4}({error:.4})", node * case.step);
        slope += weight * value / case.step;
        variance += (weight * error / case.step).powi(2);
    }
    println!("{projection:?}: {slope:.3}({:.3}) Δt", variance.sqrt());
    (slope, variance.sqrt())
}

/// Friction alone takes this flux: the letter O.
#[test]
fn color_drift_has_an_error_of_first_order_in_the_papers_form_and_none_in_ours() {
    let case = Case { forcing: forcing(ForcingKind::ColorDrift), friction: 9.0, flux: 8.0, step: 0.05 };
    check_scores(|seed| {
        let (papers, its_error) = first_order(&case, Projection::Paper, seed);
        let (ours, our_error) = first_order(&case, Projection::Symmetric, seed);
        assert!(papers < -5.0 * its_error, "the error of the paper's form is not seen");
        assert!(our_error < 0.15 * papers.abs(), "the test can't tell");
        vec![ours / our_error]
    });
}

/// Of so short a wave free flight takes the most: the letter A. The paper's form lacks some percent, ours nothing that is seen.
#[test]
fn shear_lacks_forcing_in_the_papers_form_and_not_in_ours() {
    let wave = Wave { waves: 2, ..forcing(ForcingKind::Sinusoidal).wave };
    let forcing = ForcingChoice { wave, ..forcing(ForcingKind::Sinusoidal) };
    let case = Case { forcing, friction: 4.5, flux: 0.4, step: 0.1 };
    check_scores(|seed| {
        let papers = mean_forcing(&case, Projection::Paper, case.step, seed);
        let ours = mean_forcing(&case, Projection::Symmetric, case.step, seed);
        let ours_at_half = mean_forcing(&case, Projection::Symmetric, 0.5 * case.step, seed);
        println!("{papers:?}\n{ours:?}\n{ours_at_half:?}");
        let lacking = ours.value.unwrap() - papers.value.unwrap();
        assert!(papers.z_score(&ours).unwrap() < -5.0, "the error of the paper's form is not seen");
        let error = ours.standard_error.unwrap().hypot(ours_at_half.standard_error.unwrap());
        assert!(error < 0.2 * lacking, "the test can't tell");
        vec![ours.z_score(&ours_at_half).unwrap()]
    });
}
