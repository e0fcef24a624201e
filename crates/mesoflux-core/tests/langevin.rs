//! The Langevin thermostat: its process is exact at any step, and what follows from it is known in closed form.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, by_id, check_scores, friction, lennard_jones, replicas, unwrapped};
use mesoflux_analysis::Blocking;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Projection};
use mesoflux_core::field::expression::ExpressionField;
use mesoflux_core::field::{Field, Fields};
use mesoflux_core::forcing::{ColorDrift, Forcing, ForcingField};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::potential::lennard_jones::Truncation;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::vector::Vector;
use std::collections::BTreeMap;

/// Particles that feel nothing but the bath, half of them of mass 1, half of mass `mass`.
fn free(count: usize, mass: f64, drag: f64) -> Fluid {
    let fluid = Fluid { density: 0.02, skin: 0.9, ..Fluid::ideal(count, 0.0) };
    fluid.with_species(&[(count / 2, 1.0), (count / 2, mass)]).with_langevin(drag)
}

fn inverse_masses(simulation: &Simulation) -> Vec<f64> {
    let particles = &simulation.system.particles;
    by_id(particles, &particles.inverse_mass)
}

/// z-scores of the moments of what a step adds to the decayed momenta, and of its correlations with the step before, between
/// axes and between particles.
fn scores_of_noise(before: &[Vec<Vector>; 3], inverse_mass: &[f64], exponent: f64) -> Vec<f64> {
    let deviates = |old: &[Vector], new: &[Vector]| -> Vec<Vector> {
        let one = |k: usize| {
            let decay = (-exponent * inverse_mass[k]).exp();
            let deviation = ((1.0 - decay * decay) / inverse_mass[k]).sqrt();
            std::array::from_fn(|axis| (new[k][axis] - decay * old[k][axis]) / deviation)
        };
        (0..old.len()).map(one).collect()
    };
    let (first, second) = (deviates(&before[0], &before[1]), deviates(&before[1], &before[2]));
    let mean = |term: &dyn Fn(usize, usize) -> f64, expected: f64, variance: f64| {
        let terms = (0..first.len()).flat_map(|k| (0..3).map(move |axis| (k, axis)));
        let sum: f64 = terms.map(|(k, axis)| term(k, axis)).sum();
        let count = 3.0 * first.len() as f64;
        (sum / count - expected) / (variance / count).sqrt()
    };
    vec![
        mean(&|k, axis| first[k][axis], 0.0, 1.0),
        mean(&|k, axis| first[k][axis].powi(2), 1.0, 2.0),
        mean(&|k, axis| first[k][axis].powi(4), 3.0, 96.0),
        mean(&|k, axis| first[k][axis] * second[k][axis], 0.0, 1.0),
        mean(&|k, axis| first[k][axis] * first[k][(axis + 1) % 3], 0.0, 1.0),
        mean(&|k, axis| first[k][axis] * first[(k + 1) % first.len()][axis], 0.0, 1.0),
    ]
}

/// From momenta far from equilibrium the very first step must have the moments of the process, whether one O makes it or two.
#[test]
fn momenta_of_free_particles_follow_their_process_exactly_at_any_step() {
    check_scores(|seed| {
        let mut scores = Vec::new();
        for (case, (word, dt)) in [("ABO", 0.1), ("OBAO", 0.1), ("ABO", 3.0), ("OBAO", 3.0)].into_iter().enumerate() {
            let noise = NoiseKey::new(&[seed, case as u64]);
            let mut simulation = free(20_000, 4.0, 0.5).simulation(word, None, noise, dt);
            simulation.system.particles.momentum.fill([5.0, -3.0, 0.0]);
            let momenta = [0, 1, 2].map(|step| {
                if step > 0 {
                    simulation.step().unwrap();
                }
                let particles = &simulation.system.particles;
                by_id(particles, &particles.momentum)
            });
            scores.extend(scores_of_noise(&momenta, &inverse_masses(&simulation), 0.5 * dt));
        }
        scores
    });
}

/// In equilibrium the autocorrelation of the momenta of each mass after n steps is m kT e^{−γnΔt/m}.
#[test]
fn momenta_of_free_particles_decay_as_they_should() {
    check_scores(|seed| {
        let noise = NoiseKey::new(&[seed]);
        let (dt, lag, count) = (0.3, 4, 20_000);
        let mut simulation = free(count, 4.0, 0.5).simulation("ABOBA", None, noise, dt);
        let mut scores = Vec::new();
        // Windows far apart, so that they are independent.
        let mut sums = [[0.0f64; 2]; 2];
        let windows = 3;
        for _ in 0..windows {
            advance(&mut simulation, 60.0);
            let particles = &simulation.system.particles;
            let (start, inverse_mass) = (by_id(particles, &particles.momentum), inverse_masses(&simulation));
            advance(&mut simulation, f64::from(lag) * dt);
            let particles = &simulation.system.particles;
            let end = by_id(particles, &particles.momentum);
            for k in 0..count {
                let kind = usize::from(inverse_mass[k] < 1.0);
                for axis in 0..3 {
                    sums[kind][0] += start[k][axis].powi(2) * inverse_mass[k];
                    sums[kind][1] += start[k][axis] * end[k][axis] * inverse_mass[k];
                }
            }
        }
        for (kind, mass) in [1.0, 4.0].into_iter().enumerate() {
            let samples = f64::from(3 * windows) * (count / 2) as f64;
            let decay = (-0.5 * f64::from(lag) * dt / mass).exp();
            // Variances of products of normal deviates: 2, and 1 + their squared correlation.
            scores.push((sums[kind][0] / samples - 1.0) / (2.0 / samples).sqrt());
            scores.push((sums[kind][1] / samples - decay) / ((1.0 + decay * decay) / samples).sqrt());
        }
        scores
    });
}

/// x coth x.
fn cotangent(x: f64) -> f64 {
    x / x.tanh()
}

/// z-score of the diffusion coefficient of free particles by the growth of their mean squared displacement over n steps.
fn score_of_diffusion(word: &str, mass: f64, seed: u64) -> f64 {
    let (drag, dt, steps) = (2.0, 0.8 * mass, 8u32);
    let expected = cotangent(0.5 * drag * dt / mass) / drag;
    let fluid = free(2000, mass, drag).with_species(&[(2000, mass)]);
    let noise = NoiseKey::new(&[seed, word.bytes().map(u64::from).sum(), mass.to_bits()]);
    let mut simulation = fluid.simulation(word, None, noise, dt);
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for _ in 0..60 {
        let start = unwrapped(&simulation.system);
        advance(&mut simulation, f64::from(steps) * dt);
        let middle = unwrapped(&simulation.system);
        advance(&mut simulation, f64::from(steps) * dt);
        let end = unwrapped(&simulation.system);
        for k in 0..start.len() {
            for axis in 0..3 {
                let (near, far) = (middle[k][axis] - start[k][axis], end[k][axis] - start[k][axis]);
                let growth = (far * far - near * near) / (2.0 * f64::from(steps) * dt);
                sum += growth;
                squares += growth * growth;
                count += 1.0;
            }
        }
    }
    let mean: f64 = sum / count;
    let error = f64::sqrt((squares / count - mean * mean) / count);
    println!("{word}, m = {mass}: D = {mean:.5}({error:.5}), {expected:.5} expected, {:.5} as Δt → 0", 1.0 / drag);
    assert!(error < 0.005 * expected, "the test can't tell");
    (mean - expected) / error
}

/// D = (kT/γ) x coth x with x = γΔt/2m where A and O each act once in a turn; here 20 % more than kT/γ.
#[test]
fn free_particles_diffuse_as_known_at_a_finite_step() {
    check_scores(|seed| {
        vec![
            score_of_diffusion("ABOBA", 1.0, seed),
            score_of_diffusion("BAOAB", 3.0, seed),
            score_of_diffusion("OBABO", 1.0, seed),
        ]
    });
}

/// ⟨x²⟩k/kT and ⟨p²⟩/mkT in a harmonic field, with ωΔt = 1.
fn harmonic(word: &str, seed: u64) -> Blocking {
    let (stiffness, drag, dt) = (25.0, 3.0, 0.2);
    let fluid = Fluid { density: 0.5, skin: 0.9, ..Fluid::ideal(108, 0.0) }.with_langevin(drag);
    let noise = NoiseKey::new(&[seed, word.bytes().fold(0, |sum, letter| 31 * sum + u64::from(letter))]);
    let mut system = fluid.system(1.0, noise);
    let center = system.region.sides().map(|side| 0.5 * side);
    // From the lattice to the bottom, no farther at once than a list can follow.
    for _ in 0..40 {
        for position in &mut system.particles.position {
            *position = std::array::from_fn(|axis| center[axis] + 0.6 * (position[axis] - center[axis]));
        }
        system.positions_moved().unwrap();
    }
    let energy = "k/2*((x - lx/2)^2 + (y - ly/2)^2 + (z - lz/2)^2)";
    let law = ExpressionField::new(energy, &BTreeMap::from([("k".to_owned(), stiffness)]), &system.region).unwrap();
    let system = system.with_fields(Fields::from(vec![Field { law, felt_by: vec![true] }]));
    let mut simulation = Simulation::new(system, fluid.integrator(word), None, noise, dt).unwrap();
    advance(&mut simulation, 20.0);
    let mut series = Blocking::new(2).unwrap();
    for _ in 0..3000 {
        simulation.step().unwrap();
        let system = &simulation.system;
        let from_center = |r: Vector| (0..3).map(|axis| (r[axis] - center[axis]).powi(2)).sum::<f64>();
        let count = 3.0 * system.particles.count() as f64;
        let squares: f64 = unwrapped(system).into_iter().map(from_center).sum();
        series.record(&[stiffness * squares / count, system.kinetic_temperature()]).unwrap();
    }
    series
}

/// With s = 1 − (ωΔt)²/4 the covariances are known for any drag: BAOAB and ABOBA have the positions exact, OBABO and OABAO the
/// momenta (Leimkuhler & Matthews, Appl. Math. Res. Express 2013, 34).
#[test]
fn harmonic_oscillators_have_the_known_covariances_of_each_word() {
    let s: f64 = 0.75;
    let expected = [("BAOAB", 1.0, s), ("ABOBA", 1.0, 1.0 / s), ("OBABO", 1.0 / s, 1.0), ("OABAO", s, 1.0)];
    check_scores(|seed| {
        let score = |(word, position, momentum): (&str, f64, f64)| {
            let series = harmonic(word, seed);
            let estimates = [(series.component(0), position), (series.component(1), momentum)];
            estimates.map(|(estimate, exact)| {
                let error = estimate.standard_error.unwrap();
                println!("{word}: {:.4}({error:.4}), {exact:.4} expected", estimate.value.unwrap());
                assert!(error < 0.01, "the test can't tell");
                estimate.z_score_against(exact, 0.0).unwrap()
            })
        };
        expected.into_iter().flat_map(score).collect()
    });
}

/// 3N degrees of freedom: with 3(N − 1) the temperature would be 3.8 % too high.
#[test]
fn a_liquid_has_the_temperature_of_its_bath() {
    let fluid = Fluid {
        potential: Some(lennard_jones(1.25, Truncation::ForceShifted)),
        friction: friction(0.0, 1.25),
        density: 0.8,
        ..Fluid::lennard_jones(27)
    };
    let fluid = fluid.with_species(&[(13, 1.0), (14, 2.0)]).with_langevin(10.0);
    check_scores(|seed| {
        let series = replicas(2, |replica| {
            let mut simulation = fluid.simulation("OBABO", None, NoiseKey::new(&[seed, replica]), 0.004);
            advance(&mut simulation, 5.0);
            let mut series = Blocking::new(1).unwrap();
            for _ in 0..20_000 {
                simulation.step().unwrap();
                series.record(&[simulation.system.kinetic_temperature()]).unwrap();
            }
            series
        });
        let estimates = series.iter().map(Blocking::estimate);
        estimates
            .map(|estimate| {
                assert!(estimate.standard_error.unwrap() < 0.009, "the test can't tell: {estimate:?}");
                estimate.z_score_against(1.0, 0.0).unwrap()
            })
            .collect()
    });
}

/// The flux of free particles of two masses under a constant force: Σ F·G (Δt/2) coth(γΔt/2m) η, and the same with
/// (Δt/2)/sinh(γΔt/2m) where the step ends after half an O.
#[test]
fn color_drift_of_free_particles_by_a_constant_force_is_known() {
    check_scores(|seed| {
        let score = |(word, half): (&str, bool)| {
            let (drag, mass, dt, force) = (2.0, 3.0, 0.7, 40.0);
            let driving = Box::new(ConstantForce::new(ForcingField::new(Box::new(ColorDrift)), force));
            let noise = NoiseKey::new(&[seed, u64::from(half)]);
            let mut simulation = free(200, mass, drag).simulation(word, Some(driving), noise, dt);
            advance(&mut simulation, 30.0);
            let mut series = Blocking::new(1).unwrap();
            for _ in 0..20_000 {
                series.record(&[simulation.step().unwrap().unwrap().flux / force]).unwrap();
            }
            let particles = &simulation.system.particles;
            let mobility = |k: usize| {
                let x: f64 = 0.5 * drag * dt * particles.inverse_mass[k];
                let [force, response] = ColorDrift.at(particles, k);
                let control = force[0] * response[0];
                0.5 * dt * control / if half { x.sinh() } else { x.tanh() }
            };
            let expected: f64 = (0..particles.count()).map(mobility).sum();
            let estimate = series.estimate();
            let error = estimate.standard_error.unwrap();
            println!("{word}: {:.5}({error:.5}), {expected:.5} expected", estimate.value.unwrap());
            assert!(error < 0.002 * expected, "the test can't tell");
            estimate.z_score_against(expected, 0.0).unwrap()
        };
        [("ABOBA", false), ("OBABO", true)].into_iter().map(score).collect()
    });
}

/// Free particles of one mass decay all at one rate: the forcing has no noise at all. With n letters O in a word, x = γΔt/nm, it is
/// n m r (1 − e^{−x})/Δt where the flux is brought back after each letter, 2 n m r tanh(x/2)/Δt, as under a constant force, where half
/// of that is given before; and λ = γr exactly.
#[test]
fn forcing_of_free_particles_at_a_constant_flux_is_known() {
    let (drag, dt, flux, mass) = (2.0, 0.7, 1.5, 3.0);
    for (word, letters) in [("ABOBA", 1.0), ("BAOAB", 1.0), ("OBABO", 2.0)] {
        let fluid = free(200, mass, drag).with_species(&[(200, mass)]);
        let start = |projection| {
            let driving = ConstantFlux::new(ForcingField::new(Box::new(ColorDrift)), flux, projection);
            fluid.simulation(word, Some(Box::new(driving)), NoiseKey::new(&[1]), dt)
        };
        let x: f64 = drag * dt / mass / letters;
        let mut symmetric = start(Projection::Symmetric);
        let last = (0..1000).map(|_| symmetric.step().unwrap().unwrap().forcing).last().unwrap();
        let expected = 2.0 * letters * mass * flux * (0.5 * x).tanh() / dt;
        assert!((last / expected - 1.0).abs() < 1e-7, "{word}: {last}, {expected} expected");
        let mut simulation = start(Projection::Paper);
        let expected = letters * mass * flux * (1.0 - (-x).exp()) / dt;
        for _ in 0..100 {
            let forcing = simulation.step().unwrap().unwrap().forcing;
            assert!((forcing / expected - 1.0).abs() < 1e-12, "{word}: {forcing}, {expected} expected");
            let observable = simulation.forcing_observable().unwrap();
            assert!((observable / (drag * flux) - 1.0).abs() < 1e-12, "{word}: λ = {observable}");
        }
    }
}

/// A particle's noise follows from its id: lists that sort the particles at other times change nothing.
#[test]
fn noise_does_not_depend_on_the_order_of_storage() {
    let run = |skin: f64| {
        let fluid = Fluid { skin, ..free(500, 2.0, 1.0) };
        let mut simulation = fluid.simulation("ABOBA", None, NoiseKey::new(&[7]), 0.1);
        advance(&mut simulation, 20.0);
        let system = &simulation.system;
        let bits = |vectors: Vec<Vector>| vectors.into_iter().map(|v| v.map(f64::to_bits)).collect::<Vec<_>>();
        (
            bits(by_id(&system.particles, &system.particles.momentum)),
            system.list().builds(),
            system.particles.id.clone(),
        )
    };
    let (thin, thick) = (run(0.2), run(1.4));
    assert!(thin.1 > thick.1 && thin.2 != thick.2, "the orders must differ");
    assert!(thin.0 == thick.0);
}
