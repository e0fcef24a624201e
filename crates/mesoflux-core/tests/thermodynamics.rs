//! Pressure, Laplacian and kinetic temperature against their definitions.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;

/// A disordered Lennard-Jones liquid, whose force vanishes smoothly at the cutoff.
fn liquid() -> System {
    let mut simulation = Fluid::lennard_jones(216).simulation("ABOBA", None, NoiseKey::new(&[1]), 0.004);
    advance(&mut simulation, 0.8);
    simulation.system
}

/// The system with all lengths multiplied.
fn scaled(system: &System, factor: f64) -> System {
    let mut particles = system.particles.clone();
    particles.position.iter_mut().for_each(|position| *position = position.map(|x| x * factor));
    let region = PeriodicBox::new(system.region.sides().map(|side| side * factor)).unwrap();
    System::new(particles, region, system.interactions.clone(), 0.2, system.workers).unwrap()
}

/// P − ρ kT = −dU/dV when all positions follow the box.
#[test]
fn pressure_is_the_response_of_the_energy_to_the_volume() {
    let mut system = liquid();
    let now = Thermodynamics::of(&mut system);
    let volume = system.region.volume();
    let h = 1e-5;
    let energy = |factor: f64| Thermodynamics::of(&mut scaled(&system, factor)).potential_energy;
    let slope = (energy(1.0 + h) - energy(1.0 - h)) / (volume * ((1.0 + h).powi(3) - (1.0 - h).powi(3)));
    let virial = now.pressure - 216.0 / volume * now.kinetic_temperature;
    assert!(virial.abs() > 0.1, "nothing is tested");
    assert!((virial + slope).abs() < 1e-5 * (virial.abs() + 1.0), "{virial} against {}", -slope);
}

/// ∇²U = −Σ ∂F/∂r, coordinate by coordinate.
#[test]
fn laplacian_is_the_divergence_of_the_forces() {
    let mut system = liquid();
    let found = Thermodynamics::of(&mut system).laplacian;
    let h = 1e-5;
    let mut divergence = 0.0;
    for k in 0..216 {
        for axis in 0..3 {
            let force = |way: f64| {
                let mut moved = system.clone();
                moved.particles.position[k][axis] += way;
                moved.positions_moved().unwrap();
                moved.update_forces();
                let place = moved.particles.id.iter().position(|&id| id == system.particles.id[k]).unwrap();
                moved.forces()[place][axis]
            };
            divergence += (force(h) - force(-h)) / (2.0 * h);
        }
    }
    assert!((found / -divergence - 1.0).abs() < 1e-5, "{found} against {}", -divergence);
}

/// Momenta drawn at kT = 1 for three particles of different masses: with 3N degrees of freedom the mean would be 2/3.
#[test]
fn kinetic_temperature_has_no_bias_for_few_particles() {
    let laws = common::interactions(&[1.0, 2.5, 4.0], |_, _| None, |_, _| None);
    let sites = vec![[0.5; 3], [1.5; 3], [2.5; 3]];
    let particles = Particles::at_rest(sites, vec![0, 1, 2], &[1.0, 2.5, 4.0]);
    let region = PeriodicBox::new([3.0; 3]).unwrap();
    let mut system = System::new(particles, region, laws, 0.5, mesoflux_core::domain::Workers::One).unwrap();
    let draws = 10_000;
    let mean = (0..draws).map(|draw| {
        draw_momenta(&mut system.particles, 1.0, NoiseKey::new(&[1, draw]));
        system.kinetic_temperature() / draws as f64
    });
    // The variance of one draw is 2/(3(N − 1)) = 1/3.
    let mean: f64 = mean.sum();
    assert!((mean - 1.0).abs() < 4.0 * (1.0 / (3.0 * draws as f64)).sqrt(), "{mean}");
}
