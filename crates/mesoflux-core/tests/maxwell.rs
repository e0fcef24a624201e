//! The pair thermostat alone gives Maxwell's speeds exactly: at weak and strong friction, at any time step, for any masses.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, probit, replicas};
use mesoflux_analysis::{kolmogorov_smirnov_p_value, maxwell_speed_cdf};
use mesoflux_core::domain::Workers;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::vector::dot;

/// Snapshots taken of each of two replicas.
const SNAPSHOTS: usize = 20;

/// The rate at which a particle loses its velocity, γρ∫ω(r) d³r/(3m), for ω = (1 − r)²: 2πγρ/(45 m).
fn velocity_rate(fluid: &Fluid, mass: f64) -> f64 {
    2.0 * std::f64::consts::TAU * fluid.friction.coefficient * fluid.density / (90.0 * mass)
}

/// Two independent scores: the mean kinetic temperature of one replica's snapshots, and Kolmogorov and Smirnov's test of
/// the speeds of the other's.
///
/// With the total momentum zero a component of the velocity has variance (kT/m)(1 − m/M). The momenta start at a wrong
/// temperature, so that nothing right is inherited.
fn scores_of_speeds(fluid: &Fluid, word: &str, dt: f64, seed: u64) -> Vec<f64> {
    let heaviest = fluid.species.iter().map(|&(_, mass)| mass).fold(0.0, f64::max);
    // Five correlation times of the slowest velocity, and of the longest shear wave, whose rate is of order one.
    let interval = 5.0 / velocity_rate(fluid, heaviest).min(1.0);
    let runs = replicas(2, |replica| {
        let noise = NoiseKey::new(&[seed, dt.to_bits(), fluid.friction.coefficient.to_bits(), replica]);
        let mut simulation = fluid.simulation(word, None, noise, dt);
        for momentum in &mut simulation.system.particles.momentum {
            *momentum = momentum.map(|p| p * std::f64::consts::SQRT_2);
        }
        advance(&mut simulation, 2.0 * interval);
        let (mut places, mut temperature) = (Vec::new(), 0.0);
        for _ in 0..SNAPSHOTS {
            advance(&mut simulation, interval);
            let particles = &simulation.system.particles;
            let total_mass = particles.total_mass(Workers::One);
            for k in 0..particles.count() {
                let (v, inverse_mass) = (particles.velocity(k), particles.inverse_mass[k]);
                // The place of the speed in its distribution: uniform between 0 and 1, whatever the mass.
                places.push(maxwell_speed_cdf(dot(v, v).sqrt(), inverse_mass - 1.0 / total_mass));
            }
            temperature += simulation.system.kinetic_temperature() / SNAPSHOTS as f64;
        }
        (places, temperature)
    });
    let temperature = runs[0].1;
    let error = (2.0 / (3.0 * (fluid.count() as f64 - 1.0) * SNAPSHOTS as f64)).sqrt();
    let mut places = runs[1].0.clone();
    places.sort_by(f64::total_cmp);
    let p_value = kolmogorov_smirnov_p_value(&places, |place| place).unwrap();
    let gamma = fluid.friction.coefficient;
    println!("γ = {gamma}, {word}, Δt = {dt}: p = {p_value:.4}, kT = {temperature:.4}({error:.4})");
    vec![(temperature - 1.0) / error, probit(p_value)]
}

fn ideal(coefficient: f64) -> Fluid {
    Fluid { skin: 0.9, ..Fluid::ideal(192, coefficient) }
}

#[test]
fn speeds_at_weak_friction() {
    check_scores(|seed| scores_of_speeds(&ideal(0.5), "ABOBA", 0.1, seed));
}

#[test]
fn speeds_at_the_usual_friction() {
    check_scores(|seed| {
        let scores = [0.1, 0.03].map(|dt| scores_of_speeds(&ideal(4.5), "ABOBA", dt, seed));
        scores.concat()
    });
}

#[test]
fn speeds_at_strong_friction() {
    check_scores(|seed| {
        let scores = [0.1, 0.03].map(|dt| scores_of_speeds(&ideal(40.5), "OBABO", dt, seed));
        scores.concat()
    });
}

#[test]
fn speeds_of_two_masses() {
    let fluid = ideal(4.5).with_species(&[(150, 1.0), (42, 3.0)]);
    check_scores(|seed| scores_of_speeds(&fluid, "ABOBA", 0.1, seed));
}
