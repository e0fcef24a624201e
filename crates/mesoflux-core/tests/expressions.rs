//! Pair potentials and external fields that a user types, in whole configurations: the forces of the built-in laws, Boltzmann's
//! density, conserved energy, the same bits on any number of threads.
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{Fluid, advance, by_id, check_scores, lennard_jones, replicas, splitting, velocity_verlet};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::field::expression::ExpressionField;
use mesoflux_core::field::{Field, Fields};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::expression::{Expression, Source};
use mesoflux_core::potential::lennard_jones::Truncation;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, dot, subtract};
use std::collections::BTreeMap;

fn typed(energy: &str, cutoff: f64, truncation: Truncation) -> Potential {
    let law = Expression::from(Source { energy: energy.to_owned(), parameters: BTreeMap::new(), cutoff, truncation });
    let potential = Potential::Expression(law);
    assert_eq!(potential.fault(), None);
    potential
}

fn field(energy: &str, region: &PeriodicBox, felt_by: &[bool]) -> Field {
    let law = ExpressionField::new(energy, &BTreeMap::new(), region).unwrap();
    Field { law, felt_by: felt_by.to_vec() }
}

#[test]
fn a_liquid_of_typed_laws_has_the_forces_of_the_built_in_ones() {
    let pairs = [
        (Fluid::groot_warren(1500), typed("25/2*(1 - r)^2", 1.0, Truncation::ForceShifted)),
        (Fluid::lennard_jones(500), typed("4*(1/r^12 - 1/r^6)", 2.5, Truncation::ForceShifted)),
        (
            Fluid { potential: Some(lennard_jones(1.4, Truncation::Plain)), ..Fluid::lennard_jones(500) },
            typed("4*(r^-12 - r^-6)", 1.4, Truncation::Plain),
        ),
    ];
    for (built_in, potential) in pairs {
        let expression = Fluid { potential: Some(potential), ..built_in.clone() };
        let noise = NoiseKey::new(&[3]);
        for verlet in [false, true] {
            let state = |fluid: &Fluid| {
                let integrator = if verlet { velocity_verlet() } else { splitting("ABOBA") };
                let mut simulation = Simulation::new(fluid.system(1.0, noise), integrator, None, noise, 0.005).unwrap();
                advance(&mut simulation, 0.1);
                simulation.system.update_forces();
                simulation
            };
            let (mut ours, mut expected) = (state(&expression).system, state(&built_in).system);
            let ordered = |system: &System| {
                let forces: Vec<Vector> = system.forces().iter().map(|row| row.vector()).collect();
                by_id(&system.particles, &forces)
            };
            // Twenty steps of a chaotic fluid let the last bit of a force grow a little.
            let tolerance = 1e-12 * ordered(&expected).iter().map(|f| dot(*f, *f).sqrt()).fold(0.0, f64::max);
            for (found, expected) in ordered(&ours).into_iter().zip(ordered(&expected)) {
                let d = subtract(found, expected);
                assert!(dot(d, d).sqrt() < 10.0 * tolerance, "{found:?} for {expected:?}");
            }
            let (ours, expected) = (Thermodynamics::of(&mut ours), Thermodynamics::of(&mut expected));
            let close = |a: f64, b: f64| (a - b).abs() < 1e-11 * b.abs();
            assert!(close(ours.potential_energy, expected.potential_energy), "{ours:?} for {expected:?}");
            assert!(close(ours.laplacian, expected.laplacian) && close(ours.pressure, expected.pressure));
        }
    }
}

#[test]
fn an_ideal_fluid_in_a_wave_has_boltzmanns_density_and_its_temperature() {
    // ⟨cos nθ⟩ under exp(−A cos θ): −I₁(A)/I₀(A) and I₂(A)/I₀(A), here by the trapezoidal rule, exact for periodic functions.
    let amplitude = 1.5f64;
    let angles = || (0..64).map(|k| std::f64::consts::TAU * f64::from(k) / 64.0);
    let average = |n: f64| {
        let weight = |t: f64| (-amplitude * t.cos()).exp();
        angles().map(|t| (n * t).cos() * weight(t)).sum::<f64>() / angles().map(weight).sum::<f64>()
    };
    let expected = [average(1.0), 1.0, average(2.0)];
    let fluid = Fluid::ideal(54, 4.5);
    let scores = |seed: u64| {
        let means = replicas(48, |replica| {
            let noise = NoiseKey::new(&[seed, replica]);
            let system = fluid.system(1.0, noise);
            let side = system.region.sides()[0];
            let wave = field("1.5*cos(2*pi*x/lx)", &system.region, &[true]);
            let system = system.with_fields(Fields::from(vec![wave]));
            let mut simulation = Simulation::new(system, splitting("ABOBA"), None, noise, 0.02).unwrap();
            advance(&mut simulation, 15.0);
            let (mut sums, samples) = ([0.0; 3], 1200);
            for _ in 0..samples {
                advance(&mut simulation, 0.1);
                let particles = &simulation.system.particles;
                let angle = |place: &Vector| std::f64::consts::TAU * place[0] / side;
                let mean = |n: f64| {
                    particles.position.iter().map(|place| (n * angle(place)).cos()).sum::<f64>()
                        / particles.count() as f64
                };
                let now = [mean(1.0), simulation.system.kinetic_temperature(), mean(2.0)];
                sums.iter_mut().zip(now).for_each(|(sum, now)| *sum += now / f64::from(samples));
            }
            sums
        });
        let score = |quantity: usize| {
            let values: Vec<f64> = means.iter().map(|mean| mean[quantity]).collect();
            let mean = values.iter().sum::<f64>() / 48.0;
            let error = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (47.0 * 48.0)).sqrt();
            println!("{mean} ± {error} for {}", expected[quantity]);
            // 3N − 2 degrees of freedom must be told from 3N − 3 and 3N.
            assert!(error < 1.5e-3, "{error}");
            (mean - expected[quantity]) / error
        };
        // The second wave is not independent of the first.
        assert!(score(2).abs() < 4.0, "z = {} for the second wave", score(2));
        vec![score(0), score(1)]
    };
    check_scores(scores);
}

#[test]
fn energy_is_conserved_in_a_field_and_momentum_where_it_does_not_push() {
    let potential = typed("20*exp(-(r/0.4)^2) + 3*(1 - r)^2*sin(7*r)", 1.0, Truncation::ForceShifted);
    let fluid = Fluid { potential: Some(potential), ..Fluid::groot_warren(300) };
    let excursion = |time_step: f64| {
        let noise = NoiseKey::new(&[8]);
        let system = fluid.system(1.0, noise);
        let waves = field("cos(2*pi*x/lx) - 0.5*sin(4*pi*x/lx)*cos(2*pi*z/lz)", &system.region, &[true]);
        let system = system.with_fields(Fields::from(vec![waves]));
        let mut simulation = Simulation::new(system, splitting("BAB"), None, noise, time_step).unwrap();
        let energy = |system: &mut System| {
            0.5 * system.particles.twice_kinetic_energy(Workers::One) + Thermodynamics::of(system).potential_energy
        };
        let momentum = |system: &System| system.particles.total_momentum(Workers::One);
        let (first, before) = (energy(&mut simulation.system), momentum(&simulation.system));
        let mut largest = 0.0f64;
        for _ in 0..20 {
            advance(&mut simulation, 0.1);
            largest = largest.max((energy(&mut simulation.system) - first).abs());
        }
        let change = subtract(momentum(&simulation.system), before);
        assert!(change[0].abs() > 1.0 && change[1].abs() < 1e-10 && change[2].abs() > 0.1, "{change:?}");
        largest
    };
    let (coarse, fine) = (excursion(0.002), excursion(0.001));
    eprintln!("largest excursions of the energy: {coarse:.3e}, {fine:.3e}");
    assert!((3.0..5.5).contains(&(coarse / fine)), "not of second order: {coarse} and {fine}");
    assert!(coarse < 0.05, "{coarse}");
}

#[test]
fn fields_push_those_that_feel_them_to_the_same_bits_on_any_number_of_threads() {
    let fluid = Fluid::groot_warren(0).with_species(&[(3000, 1.0), (2001, 2.0)]);
    let noise = NoiseKey::new(&[4]);
    let energy = "cos(2*pi*x/lx)*exp(sin(2*pi*y/ly)) + tanh(sin(2*pi*z/lz))^2";
    let forces = |fields: &[&[bool]], workers: Workers, verlet: bool| {
        let mut system = fluid.system(1.0, noise);
        system.workers = workers;
        let fields: Vec<Field> = fields.iter().map(|felt_by| field(energy, &system.region, felt_by)).collect();
        let system = system.with_fields(Fields::from(fields));
        let integrator = if verlet { velocity_verlet() } else { splitting("BAB") };
        let mut simulation = Simulation::new(system, integrator, None, noise, 0.01).unwrap();
        simulation.step().unwrap();
        simulation.system.update_forces();
        simulation.system
    };
    let rows = |system: &System| system.forces().to_vec();
    let one = forces(&[&[false, true]], Workers::One, false);
    // Against the law itself, particle by particle; some have left the box since the last sorting.
    let mut bare = one.clone().with_fields(Fields::default());
    bare.update_forces();
    let law = ExpressionField::new(energy, &BTreeMap::new(), &one.region).unwrap();
    for k in 0..one.particles.count() {
        let mut place = one.particles.position[k];
        one.region.wrap(&mut place, &mut [0; 3]);
        let push = if one.particles.species[k] == 1 { law.force(&place) } else { [0.0; 3] };
        let found = subtract(one.forces()[k].vector(), bare.forces()[k].vector());
        assert!(subtract(found, push).iter().all(|d| d.abs() < 1e-11), "{found:?} for {push:?} at {place:?}");
    }
    for verlet in [false, true] {
        let one = rows(&forces(&[&[false, true], &[true, true]], Workers::One, verlet));
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let many = pool.install(|| rows(&forces(&[&[false, true], &[true, true]], Workers::Pool, verlet)));
            assert!(one == many, "{threads} threads");
        }
    }
}
