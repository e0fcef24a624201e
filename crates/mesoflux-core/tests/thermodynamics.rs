//! Pressure, Laplacian and kinetic temperature against their definitions.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance};
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange, Topology};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::potential::fene::Fene;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;

/// A disordered Lennard-Jones liquid, whose force vanishes smoothly at the cutoff.
fn liquid() -> System {
    let mut simulation = Fluid::lennard_jones(216).simulation("ABOBA", None, NoiseKey::new(&[1]), 0.004);
    advance(&mut simulation, 0.8);
    simulation.system
}

/// The same liquid with every second particle bonded to the one before, whose pair potential it doesn't feel.
fn dumbbells() -> System {
    let fluid = Fluid::lennard_jones(216);
    let system = fluid.system(1.0, NoiseKey::new(&[1]));
    let law = BondLaw::Fene(Fene { stiffness: 30.0, longest: 1.9 });
    let bonds = (0..108).map(|k| Bond { law: 0, first: 2 * k, second: 2 * k + 1 }).collect();
    let range = ExclusionRange { potential: 1, friction: 0 };
    let system = system.with_bonds(Topology::new(216, vec![law], bonds, range).unwrap());
    let mut simulation = Simulation::new(system, common::splitting("ABOBA"), None, NoiseKey::new(&[1]), 0.004).unwrap();
    advance(&mut simulation, 0.8);
    simulation.system
}

/// The system with all lengths multiplied.
fn scaled(system: &System, factor: f64) -> System {
    let mut particles = system.particles.clone();
    particles.position.iter_mut().for_each(|position| *position = position.map(|x| x * factor));
    let region = PeriodicBox::new(system.region.sides().map(|side| side * factor)).unwrap();
    let mut laws = system.interactions.clone();
    // A bonded system has the kinds that its bonds made already.
    if !system.topology().exclusions().is_empty() {
        laws = Fluid::lennard_jones(216).system(1.0, NoiseKey::new(&[1])).interactions;
    }
    let same = System::new(particles, region, laws, 0.2, system.workers).unwrap();
    same.with_bonds(system.topology().clone())
}

/// P − ρ kT = −dU/dV when all positions follow the box.
#[test]
fn pressure_is_the_response_of_the_energy_to_the_volume() {
    check_pressure(liquid());
}

#[test]
fn pressure_of_bonded_particles_is_the_response_of_the_energy_to_the_volume() {
    check_pressure(dumbbells());
}

fn check_pressure(mut system: System) {
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
    check_laplacian(liquid());
}

#[test]
fn laplacian_of_bonded_particles_is_the_divergence_of_the_forces() {
    check_laplacian(dumbbells());
}

fn check_laplacian(mut system: System) {
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
                moved.forces()[place].vector()[axis]
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
