//! Stochastic Norton dynamics: the flux is held at every step, and what is booked averages to λ(q, p) of Wu and Shang's eq. 13.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, replicas, typed_in_all_directions};
use mesoflux_analysis::Blocking;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, Projection};
use mesoflux_core::forcing::{Axis, ForcingChoice, ForcingKind, Wave};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::vector::dot;

const WORDS: [&str; 4] = ["ABOBA", "OBABO", "BAOAB", "OABAO"];

fn soft_fluid() -> Fluid {
    Fluid { skin: 0.9, ..Fluid::groot_warren(192) }
}

fn two_masses() -> Fluid {
    soft_fluid().with_species(&[(128, 1.0), (64, 4.0)])
}

const COLOR_DRIFT: ForcingChoice = choice(ForcingKind::ColorDrift);
const TWO_PARTICLE_DRIFT: ForcingChoice = choice(ForcingKind::TwoParticleDrift);

const fn choice(kind: ForcingKind) -> ForcingChoice {
    ForcingChoice { kind, wave: Wave { flow: Axis::X, gradient: Axis::Y, waves: 1 }, remove_mean_force: true }
}

/// Two waves: short enough that free flight takes much of the flux.
fn waves(kind: ForcingKind, remove_mean_force: bool) -> ForcingChoice {
    let wave = Wave { flow: Axis::Z, gradient: Axis::X, waves: 2 };
    ForcingChoice { kind, wave, remove_mean_force }
}

#[derive(Debug, Clone)]
struct Dynamics {
    forcing: ForcingChoice,
    flux: f64,
    word: &'static str,
    projection: Projection,
}

impl Dynamics {
    fn simulation(&self, fluid: &Fluid, noise: NoiseKey, dt: f64) -> Simulation {
        let system = fluid.system(1.0, noise);
        let field = self.forcing.field(system.particles.count(), system.region.sides()).unwrap();
        let driving = ConstantFlux::new(field, self.flux, self.projection);
        fluid.simulation(self.word, Some(Box::new(driving)), noise, dt)
    }
}

fn holds_its_flux(fluid: &Fluid, forcing: &ForcingChoice, strength: f64) {
    for (word, projection) in WORDS
        .into_iter()
        .flat_map(|word| [Projection::Symmetric, Projection::Paper].map(|projection| (word, projection)))
    {
        for flux in [0.0, strength] {
            let dynamics = Dynamics { forcing: forcing.clone(), flux, word, projection };
            let mut simulation = dynamics.simulation(fluid, NoiseKey::new(&[1]), 0.02);
            let system = &simulation.system;
            let mut field = forcing.field(system.particles.count(), system.region.sides()).unwrap();
            for step in 0..150 {
                let driven = simulation.step().unwrap().unwrap();
                let system = &simulation.system;
                field.update(&system.particles, system.layout(), true, Workers::One);
                let terms = field.response.iter().zip(&system.particles.momentum).map(|(g, &p)| dot(g.vector(), p));
                let (sum, scale) = terms.fold((0.0, 0.0), |(sum, scale), term| (sum + term, scale + term.abs()));
                assert!((sum - flux).abs() <= 1e-12 * scale, "{dynamics:?}, step {step}: R = {sum}");
                assert!((driven.flux - flux).abs() <= 1e-12 * scale, "{dynamics:?}, step {step}: {driven:?}");
            }
        }
    }
}

#[test]
fn flux_of_drifts_is_held_at_every_step() {
    for forcing in [COLOR_DRIFT, TWO_PARTICLE_DRIFT] {
        holds_its_flux(&soft_fluid(), &forcing, -1.3);
        holds_its_flux(&two_masses(), &forcing, -1.3);
    }
}

#[test]
fn flux_of_shear_is_held_at_every_step() {
    for kind in [ForcingKind::Sinusoidal, ForcingKind::PiecewiseLinear, ForcingKind::PiecewiseConstant] {
        for remove_mean_force in [true, false] {
            holds_its_flux(&two_masses(), &waves(kind.clone(), remove_mean_force), -0.1);
        }
    }
}

#[test]
fn flux_is_held_with_the_langevin_thermostat() {
    holds_its_flux(&two_masses().with_langevin(2.0), &COLOR_DRIFT, -1.3);
    holds_its_flux(&two_masses().with_langevin(2.0), &waves(ForcingKind::Sinusoidal, false), -0.1);
}

#[test]
fn flux_of_a_typed_forcing_is_held_at_every_step() {
    holds_its_flux(&two_masses(), &typed_in_all_directions(), -0.3);
    let unbalanced = ForcingChoice { remove_mean_force: false, ..typed_in_all_directions() };
    holds_its_flux(&two_masses(), &unbalanced, -0.3);
}

/// Booked forcing minus λ(q, p) at the ends of the step, averaged over runs at a step; and the mean of λ itself.
fn booked_minus_observed(fluid: &Fluid, dynamics: &Dynamics, dt: f64, seed: u64) -> Blocking {
    let parts = replicas(2, |replica| {
        let label = format!("{dynamics:?}{:?}", fluid.species);
        let label = label.bytes().map(u64::from);
        let identity: Vec<u64> = [seed, dt.to_bits(), replica].into_iter().chain(label).collect();
        let mut simulation = dynamics.simulation(fluid, NoiseKey::new(&identity), dt);
        advance(&mut simulation, 3.0);
        let mut series = Blocking::new(2).unwrap();
        let mut before = simulation.forcing_observable().unwrap();
        for _ in 0..(20.0 / dt) as u64 {
            let booked = simulation.step().unwrap().unwrap().forcing;
            let after = simulation.forcing_observable().unwrap();
            series.record(&[booked - 0.5 * (before + after), after]).unwrap();
            before = after;
        }
        series
    });
    parts
        .into_iter()
        .reduce(|mut all, part| {
            all.merge(&part).unwrap();
            all
        })
        .unwrap()
}

/// The difference extrapolated to Δt → 0 by a parabola through three steps, in standard errors.
fn score_of_booking(fluid: &Fluid, dynamics: &Dynamics, seed: u64) -> f64 {
    // Lagrange's weights at zero for steps in the ratio 1 : 2 : 4.
    let plan = [(0.0075, 8.0 / 3.0), (0.015, -2.0), (0.03, 1.0 / 3.0)];
    let (mut value, mut variance, mut lambda) = (0.0, 0.0, 0.0);
    for (dt, weight) in plan {
        let series = booked_minus_observed(fluid, dynamics, dt, seed);
        let [difference, observed] = [series.component(0), series.component(1)];
        let (mean, error) = (difference.value.unwrap(), difference.standard_error.unwrap());
        value += weight * mean;
        variance += (weight * error).powi(2);
        lambda += observed.value.unwrap() / 3.0;
        println!("{dynamics:?}, Δt = {dt}: λ = {:.3}, booked − λ = {mean:.4}({error:.4})", observed.value.unwrap());
    }
    let error = variance.sqrt();
    println!("{dynamics:?}: extrapolated {value:.4}({error:.4})");
    let score = value / error;
    assert!(score.abs() > 3.0 || error < 0.01 * lambda.abs(), "the test can't tell");
    score
}

/// All of the named words, with both projections.
fn scores_of_booking(fluid: &Fluid, forcing: &ForcingChoice, flux: f64, words: &[&'static str], seed: u64) -> Vec<f64> {
    let cases = words.iter().zip([Projection::Symmetric, Projection::Paper]);
    cases
        .map(|(&word, projection)| {
            score_of_booking(fluid, &Dynamics { forcing: forcing.clone(), flux, word, projection }, seed)
        })
        .collect()
}

#[test]
fn booked_forcing_of_color_drift_is_that_of_the_equation() {
    check_scores(|seed| scores_of_booking(&soft_fluid(), &COLOR_DRIFT, 2.0, &["ABOBA", "OBABO"], seed));
}

#[test]
fn booked_forcing_with_two_masses_is_that_of_the_equation() {
    check_scores(|seed| scores_of_booking(&two_masses(), &COLOR_DRIFT, 2.0, &["ABOBA"], seed));
}

#[test]
fn booked_forcing_of_two_particle_drift_is_that_of_the_equation() {
    check_scores(|seed| scores_of_booking(&soft_fluid(), &TWO_PARTICLE_DRIFT, 2.0, &["ABOBA"], seed));
}

#[test]
fn booked_forcing_of_a_wave_is_that_of_the_equation() {
    check_scores(|seed| {
        let forcing = waves(ForcingKind::PiecewiseLinear, true);
        scores_of_booking(&two_masses(), &forcing, 0.14, &["ABOBA", "OBABO"], seed)
    });
}

#[test]
fn booked_forcing_of_a_typed_forcing_is_that_of_the_equation() {
    check_scores(|seed| scores_of_booking(&two_masses(), &typed_in_all_directions(), 0.4, &["ABOBA"], seed));
}

/// The friction between the pairs of this fluid acts with no letter, and must not be booked.
#[test]
fn booked_forcing_with_the_langevin_thermostat_is_that_of_the_equation() {
    let fluid = two_masses().with_langevin(2.0);
    check_scores(|seed| {
        let wave = waves(ForcingKind::Sinusoidal, false);
        let mut scores = scores_of_booking(&fluid, &wave, 0.14, &["ABOBA"], seed);
        scores.extend(scores_of_booking(&fluid, &COLOR_DRIFT, 2.0, &["OBABO"], seed));
        scores
    });
}

#[test]
fn no_flux_needs_no_forcing() {
    check_scores(|seed| {
        let dynamics = Dynamics { forcing: COLOR_DRIFT, flux: 0.0, word: "ABOBA", projection: Projection::Symmetric };
        let series = replicas(2, |replica| {
            let mut simulation = dynamics.simulation(&soft_fluid(), NoiseKey::new(&[seed, replica]), 0.03);
            advance(&mut simulation, 2.0);
            let mut series = Blocking::new(1).unwrap();
            for _ in 0..3000 {
                series.record(&[simulation.step().unwrap().unwrap().forcing]).unwrap();
            }
            series
        });
        let scores = series.iter().map(|series| series.estimate().z_score_against(0.0, 0.0).unwrap());
        scores.collect()
    });
}
