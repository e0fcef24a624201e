//! What the dynamics conserve: momentum, the angular momentum of an isolated cluster, and without a thermostat the energy.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, forcing, friction, interactions, lennard_jones, splitting, unwrapped, velocity_verlet};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Projection};
use mesoflux_core::forcing::{ColorDrift, ForcingChoice, ForcingField, ForcingKind};
use mesoflux_core::friction::Friction;
use mesoflux_core::integrate::{Drift, Integrator, Kick, Letter, PairOrnsteinUhlenbeck, Stroke};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::potential::lennard_jones::Truncation;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO, add_scaled, cross, dot, subtract};

/// 10⁵ steps of a soft fluid of two masses; Σp must stay below 1e-10 per particle.
fn conserves_momentum(integrator: Integrator, driving: Option<Box<dyn Driving>>) {
    let noise = NoiseKey::new(&[1]);
    let mut fluid = Fluid::groot_warren(64).with_species(&[(40, 1.0), (24, 2.5)]);
    fluid.density = 1.0;
    fluid.skin = 0.9;
    let system = fluid.system(1.0, noise);
    let mut simulation = Simulation::new(system, integrator, driving, noise, 0.005).unwrap();
    for step in 0..100_000 {
        simulation.step().unwrap();
        if step % 1000 == 999 {
            let total = simulation.system.particles.total_momentum(Workers::One);
            assert!(dot(total, total).sqrt() < 64e-10, "after {step} steps the total momentum is {total:?}");
        }
    }
}

#[test]
fn aboba_conserves_momentum() {
    conserves_momentum(splitting("ABOBA"), None);
}

#[test]
fn obabo_conserves_momentum() {
    conserves_momentum(splitting("OBABO"), None);
}

#[test]
fn velocity_verlet_conserves_momentum() {
    conserves_momentum(velocity_verlet(), None);
}

#[test]
fn constant_energy_dynamics_conserve_momentum() {
    conserves_momentum(splitting("BAB"), None);
}

#[test]
fn color_drift_at_constant_force_conserves_momentum() {
    conserves_momentum(
        splitting("ABOBA"),
        Some(Box::new(ConstantForce::new(ForcingField::new(Box::new(ColorDrift)), 2.0))),
    );
}

#[test]
fn color_drift_at_constant_flux_conserves_momentum() {
    conserves_momentum(
        splitting("ABOBA"),
        Some(Box::new(ConstantFlux::new(ForcingField::new(Box::new(ColorDrift)), 2.0, Projection::Symmetric))),
    );
}

#[test]
fn shear_conserves_momentum_where_its_mean_force_is_removed() {
    let field = |kind| forcing(kind).field(64, [4.0; 3]).unwrap();
    conserves_momentum(
        splitting("ABOBA"),
        Some(Box::new(ConstantForce::new(field(ForcingKind::PiecewiseConstant), 1.0))),
    );
    let held = ConstantFlux::new(field(ForcingKind::Sinusoidal), 0.1, Projection::Symmetric);
    conserves_momentum(splitting("ABOBA"), Some(Box::new(held)));
}

#[test]
fn shear_lets_the_box_drift_where_its_mean_force_is_kept() {
    let choice = ForcingChoice { remove_mean_force: false, ..forcing(ForcingKind::Sinusoidal) };
    let noise = NoiseKey::new(&[1]);
    let system = Fluid::groot_warren(192).system(1.0, noise);
    let field = choice.field(192, system.region.sides()).unwrap();
    let driving: Box<dyn Driving> = Box::new(ConstantForce::new(field, 1.0));
    let mut simulation = Simulation::new(system, splitting("ABOBA"), Some(driving), noise, 0.01).unwrap();
    for _ in 0..100 {
        simulation.step().unwrap();
    }
    let [along, across, third] = simulation.system.particles.total_momentum(Workers::One);
    assert!(along.abs() > 1e-3 && across.abs() < 1e-10 && third.abs() < 1e-10, "{along}, {across}, {third}");
}

/// A cold cluster of 27 Lennard-Jones particles of two masses in the middle of a wide box, spinning.
fn cluster(noise: NoiseKey) -> System {
    let sites = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9].map(|c| 6.9 + 1.1 * f64::from(c))).collect();
    let kinds = (0..27).map(|k| u8::from(k % 4 == 0)).collect();
    let masses = [1.0, 2.0];
    let law = |_, _| Some(lennard_jones(2.5, Truncation::ForceShifted));
    let laws = interactions(&masses, law, |_, _| Some(Friction::Linear(friction(4.5, 2.5))));
    let mut particles = Particles::at_rest(sites, kinds, &masses);
    draw_momenta(&mut particles, 0.05, noise);
    for k in 0..27 {
        let spin = cross([0.1, -0.2, 0.3], subtract(particles.position[k], [8.0; 3]));
        add_scaled(&mut particles.momentum[k], 1.0, spin);
    }
    System::new(particles, PeriodicBox::new([16.0; 3]).unwrap(), laws, 0.5, Workers::One).unwrap()
}

/// Σ q × p about the origin.
fn angular_momentum(system: &System) -> Vector {
    let (q, particles) = (unwrapped(system), &system.particles);
    let mut total = ZERO;
    for k in 0..particles.count() {
        add_scaled(&mut total, 1.0, cross(q[particles.id[k] as usize], particles.momentum[k]));
    }
    total
}

fn assert_unchanged(before: Vector, system: &System, what: &str) {
    let change = subtract(angular_momentum(system), before);
    assert!(dot(change, change).sqrt() < 1e-10, "{what}: {before:?} changed by {change:?}");
}

#[test]
fn every_letter_conserves_the_angular_momentum_of_a_cluster() {
    let noise = NoiseKey::new(&[1]);
    let mut system = cluster(noise);
    let letters: [&dyn Letter; 3] = [&Drift, &Kick, &PairOrnsteinUhlenbeck { temperature: 0.05 }];
    assert!(dot(angular_momentum(&system), angular_momentum(&system)) > 1.0, "the cluster must spin");
    for step in 0..2000 {
        for (place, letter) in letters.into_iter().enumerate() {
            let before = angular_momentum(&system);
            let stroke = Stroke {
                time: 0.005,
                place: place as u64,
                noise,
                backward: step % 2 == 1,
                response: None,
                constraint: None,
            };
            let momenta = system.particles.momentum.clone();
            letter.apply(&mut system, &stroke).unwrap();
            assert!(letter.symbol() == 'A' || momenta != system.particles.momentum, "the letter did nothing");
            assert_unchanged(before, &system, &format!("step {step}, letter {}", letter.symbol()));
        }
        system.step += 1;
    }
}

#[test]
fn every_integrator_conserves_the_angular_momentum_of_a_cluster() {
    let noise = NoiseKey::new(&[1]);
    let words = ["ABOBA", "OBABO", "BAOAB", "BAB"];
    let integrators = words.into_iter().map(|word| (word, splitting(word)));
    for (name, integrator) in integrators.chain([("velocity Verlet", velocity_verlet())]) {
        let system = cluster(noise);
        let before = angular_momentum(&system);
        let mut simulation = Simulation::new(system, integrator, None, noise, 0.001).unwrap();
        for _ in 0..1000 {
            simulation.step().unwrap();
        }
        assert_unchanged(before, &simulation.system, name);
    }
}

/// The root mean square error of the energy of a Lennard-Jones liquid over a time of 1.
fn energy_error(word: &str, dt: f64) -> f64 {
    let noise = NoiseKey::new(&[1]);
    let mut warm = Fluid::lennard_jones(216).simulation("ABOBA", None, noise, 0.004);
    common::advance(&mut warm, 1.0);
    let mut simulation = Simulation::new(warm.system, splitting(word), None, noise, dt).unwrap();
    let energy = |system: &mut System| {
        Thermodynamics::of(system).potential_energy + 0.5 * system.particles.twice_kinetic_energy(Workers::One)
    };
    let start = energy(&mut simulation.system);
    let steps = (1.0 / dt).round() as usize;
    let errors = (0..steps).map(|_| {
        simulation.step().unwrap();
        (energy(&mut simulation.system) - start).powi(2)
    });
    (errors.sum::<f64>() / steps as f64).sqrt()
}

#[test]
fn without_a_thermostat_the_energy_error_is_of_second_order() {
    for word in ["BAB", "ABA"] {
        let errors = [0.004, 0.002, 0.001].map(|dt| energy_error(word, dt));
        println!("{word}: energy errors {errors:.3?}");
        for pair in errors.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!((ratio - 4.0).abs() < 0.4, "{word}: halving the step divides the error by {ratio}");
        }
    }
}
