//! Stochastic Norton dynamics: the flux is held at every step, and what is booked averages to λ(q, p) of Wu and Shang's eq. 13.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, replicas};
use mesoflux_analysis::Blocking;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::ConstantFlux;
use mesoflux_core::forcing::{ColorDrift, Forcing, ForcingError, ForcingField, TwoParticleDrift};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::state::Particles;
use mesoflux_core::vector::{Vector, dot};

const WORDS: [&str; 4] = ["ABOBA", "OBABO", "BAOAB", "OABAO"];

/// F_i = sin(ky) e_x/√N, G = M⁻¹F: a flux that free flight changes too, so that A has something to book.
#[derive(Debug, Clone, Copy)]
struct Wave {
    wavenumber: f64,
}

impl Wave {
    fn along(particles: &Particles, value: f64) -> f64 {
        value / (particles.count() as f64).sqrt()
    }
}

impl Forcing for Wave {
    fn force(&self, particles: &Particles, k: usize) -> Vector {
        let wave = (self.wavenumber * particles.position[k][1]).sin();
        [Self::along(particles, wave), 0.0, 0.0]
    }
    fn response(&self, particles: &Particles, k: usize) -> Vector {
        self.force(particles, k).map(|f| f * particles.inverse_mass[k])
    }
    fn depends_on_positions(&self) -> bool {
        true
    }
    fn response_drift(&self, particles: &Particles, k: usize) -> f64 {
        let slope = self.wavenumber * (self.wavenumber * particles.position[k][1]).cos();
        let [v_x, v_y, _] = particles.velocity(k);
        Self::along(particles, slope) * v_y * v_x
    }
    fn check(&self, _particles: usize) -> Result<(), ForcingError> {
        Ok(())
    }
}

fn soft_fluid() -> Fluid {
    Fluid { skin: 0.9, ..Fluid::groot_warren(192) }
}

fn two_masses() -> Fluid {
    soft_fluid().with_species(&[(128, 1.0), (64, 4.0)])
}

/// One wave along the box of `soft_fluid`.
fn wave() -> Wave {
    Wave { wavenumber: std::f64::consts::TAU / 4.0 }
}

fn norton(
    fluid: &Fluid,
    forcing: impl Forcing + 'static,
    flux: f64,
    word: &str,
    noise: NoiseKey,
    dt: f64,
) -> Simulation {
    fluid.simulation(word, Some(Box::new(ConstantFlux::new(Box::new(forcing), flux))), noise, dt)
}

fn holds_its_flux(fluid: &Fluid, forcing: impl Forcing + Copy + 'static) {
    for word in WORDS {
        for flux in [0.0, -1.3] {
            let mut simulation = norton(fluid, forcing, flux, word, NoiseKey::new(&[1]), 0.02);
            let mut field = ForcingField::new(Box::new(forcing));
            for step in 0..300 {
                let driven = simulation.step().unwrap().unwrap();
                let system = &simulation.system;
                field.update(&system.particles, system.layout(), true, Workers::One);
                let terms = field.response.iter().zip(&system.particles.momentum).map(|(g, &p)| dot(g.vector(), p));
                let (sum, scale) = terms.fold((0.0, 0.0), |(sum, scale), term| (sum + term, scale + term.abs()));
                assert!((sum - flux).abs() <= 1e-12 * scale, "{word}, step {step}: R = {sum}, r = {flux}");
                assert!((driven.flux - flux).abs() <= 1e-12 * scale, "{word}, step {step}: {driven:?}");
            }
        }
    }
}

#[test]
fn flux_of_color_drift_is_held_at_every_step() {
    holds_its_flux(&soft_fluid(), ColorDrift);
    holds_its_flux(&two_masses(), ColorDrift);
}

#[test]
fn flux_is_held_with_the_langevin_thermostat() {
    holds_its_flux(&two_masses().with_langevin(2.0), ColorDrift);
    holds_its_flux(&two_masses().with_langevin(2.0), wave());
}

#[test]
fn flux_of_two_particle_drift_is_held_at_every_step() {
    holds_its_flux(&soft_fluid(), TwoParticleDrift);
    holds_its_flux(&two_masses(), TwoParticleDrift);
}

#[test]
fn flux_of_a_wave_is_held_at_every_step() {
    holds_its_flux(&two_masses(), wave());
}

/// Booked forcing minus λ(q, p) at the ends of the step, averaged over runs at a step; and the mean of λ itself.
fn booked_minus_observed(
    fluid: &Fluid,
    forcing: impl Forcing + Copy + 'static,
    word: &str,
    dt: f64,
    seed: u64,
) -> Blocking {
    let parts = replicas(2, |replica| {
        let label = format!("{forcing:?}{word}{:?}", fluid.species);
        let label = label.bytes().map(u64::from);
        let identity: Vec<u64> = [seed, dt.to_bits(), replica].into_iter().chain(label).collect();
        let noise = NoiseKey::new(&identity);
        let mut simulation = norton(fluid, forcing, 2.0, word, noise, dt);
        advance(&mut simulation, 2.0);
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
fn score_of_booking(fluid: &Fluid, forcing: impl Forcing + Copy + 'static, word: &str, seed: u64) -> f64 {
    // Lagrange's weights at zero for steps in the ratio 1 : 2 : 4.
    let plan = [(0.0075, 8.0 / 3.0), (0.015, -2.0), (0.03, 1.0 / 3.0)];
    let (mut value, mut variance, mut lambda) = (0.0, 0.0, 0.0);
    for (dt, weight) in plan {
        let series = booked_minus_observed(fluid, forcing, word, dt, seed);
        let [difference, observed] = [series.component(0), series.component(1)];
        let (mean, error) = (difference.value.unwrap(), difference.standard_error.unwrap());
        value += weight * mean;
        variance += (weight * error).powi(2);
        lambda += observed.value.unwrap() / 3.0;
        println!(
            "{forcing:?}, {word}, Δt = {dt}: λ = {:.3}, booked − λ = {mean:.4}({error:.4})",
            observed.value.unwrap()
        );
    }
    let error = variance.sqrt();
    println!("{forcing:?}, {word}: extrapolated {value:.4}({error:.4})");
    let score = value / error;
    assert!(score.abs() > 3.0 || error < 0.01 * lambda.abs(), "the test can't tell");
    score
}

#[test]
fn booked_forcing_of_color_drift_is_that_of_the_equation() {
    check_scores(|seed| {
        ["ABOBA", "OBABO"].map(|word| score_of_booking(&soft_fluid(), ColorDrift, word, seed)).to_vec()
    });
}

#[test]
fn booked_forcing_with_two_masses_is_that_of_the_equation() {
    check_scores(|seed| vec![score_of_booking(&two_masses(), ColorDrift, "ABOBA", seed)]);
}

#[test]
fn booked_forcing_of_two_particle_drift_is_that_of_the_equation() {
    check_scores(|seed| vec![score_of_booking(&soft_fluid(), TwoParticleDrift, "ABOBA", seed)]);
}

#[test]
fn booked_forcing_of_a_wave_is_that_of_the_equation() {
    check_scores(|seed| ["ABOBA", "OBABO"].map(|word| score_of_booking(&two_masses(), wave(), word, seed)).to_vec());
}

/// The friction between the pairs of this fluid acts with no letter, and must not be booked.
#[test]
fn booked_forcing_with_the_langevin_thermostat_is_that_of_the_equation() {
    let fluid = two_masses().with_langevin(2.0);
    check_scores(|seed| {
        vec![score_of_booking(&fluid, wave(), "ABOBA", seed), score_of_booking(&fluid, ColorDrift, "OBABO", seed)]
    });
}

#[test]
fn no_flux_needs_no_forcing() {
    check_scores(|seed| {
        let series = replicas(2, |replica| {
            let noise = NoiseKey::new(&[seed, replica]);
            let mut simulation = norton(&soft_fluid(), ColorDrift, 0.0, "ABOBA", noise, 0.03);
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
