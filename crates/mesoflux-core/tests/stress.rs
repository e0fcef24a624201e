//! The instantaneous stress: what equilibrium says of its moments, and what friction makes of a shear.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, friction};
use mesoflux_core::domain::Workers;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Stress;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO, add_scaled, dot};

/// A disordered Groot–Warren fluid of two masses, with a friction strong enough to tell.
fn fluid(noise: NoiseKey) -> System {
    let fluid =
        Fluid { friction: friction(20.0, 1.2), ..Fluid::groot_warren(192) }.with_species(&[(100, 1.0), (92, 3.0)]);
    let mut simulation = fluid.simulation("ABOBA", None, noise, 0.01);
    advance(&mut simulation, 1.0);
    simulation.system
}

/// Σ_i |A_i|²/m_i for each of the five shear components, A_i = Σ_j Γ r T e: J_D = −Σ_i A_i·v_i.
fn squared_lever_arms(system: &mut System) -> [f64; 5] {
    let (region, positions) = (system.region, system.particles.position.clone());
    let frictions = system.interactions.frictions.clone();
    let mut arms = vec![[ZERO; 5]; positions.len()];
    for contacts in system.contacts().contacts() {
        for k in 0..contacts.count() {
            let ([i, j], (r, e)) = (contacts.pair(k), contacts.separation(k, &positions, &region));
            let strength = frictions.entries()[contacts.kind(k)].unwrap().strength(r);
            let [x, y, z] = e;
            let shear = [x * y, x * z, y * z, (x * x - y * y) / 2.0, (x * x + y * y - 2.0 * z * z) / 12f64.sqrt()];
            for (c, t) in shear.into_iter().enumerate() {
                add_scaled(&mut arms[i][c], strength * r * t, e);
                add_scaled(&mut arms[j][c], -strength * r * t, e);
            }
        }
    }
    std::array::from_fn(|c| {
        arms.iter().zip(&system.particles.inverse_mass).map(|(arm, w)| w * dot(arm[c], arm[c])).sum()
    })
}

/// Mean and variance of independent samples against those expected, and the z-score of their covariance with others.
fn scores(samples: &[f64], others: &[f64], mean: f64, variance: f64) -> [f64; 3] {
    let n = samples.len() as f64;
    let score = |values: &[f64], expected: f64| {
        let mean = values.iter().sum::<f64>() / n;
        let spread = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean - expected) / (spread / n).sqrt()
    };
    let squares: Vec<f64> = samples.iter().map(|x| (x - mean).powi(2)).collect();
    let products: Vec<f64> = samples.iter().zip(others).map(|(x, y)| (x - mean) * y).collect();
    [score(samples, mean), score(&squares, variance), score(&products, 0.0)]
}

/// Maxwell's momenta with a total of zero, ⟨p_i p_j⟩ = kT (m_i δ_ij − m_i m_j/M), at fixed positions:
/// ⟨J_K⟩ = 0 and ⟨J_K²⟩ = (N − 1)(kT)² for each shear component, ⟨tr J_K⟩ = 3(N − 1)kT with the variance 6(N − 1)(kT)²,
/// ⟨J_D⟩ = 0 and ⟨J_D²⟩ = kT Σ_i |A_i|²/m_i, and ⟨J_K J_D⟩ = 0, an odd moment.
#[test]
fn moments_of_kinetic_and_dissipative_stress() {
    let temperature = 1.7;
    check_scores(|seed| {
        let mut system = fluid(NoiseKey::new(&[seed]));
        let arms = squared_lever_arms(&mut system);
        let draws: Vec<Stress> = (0..2000)
            .map(|draw| {
                draw_momenta(&mut system.particles, temperature, NoiseKey::new(&[seed, draw]));
                Stress::of(&mut system)
            })
            .collect();
        let free = system.particles.count() as f64 - 1.0;
        let column = |value: &dyn Fn(&Stress) -> f64| -> Vec<f64> { draws.iter().map(value).collect() };
        let mut found = Vec::new();
        for (c, arm) in arms.into_iter().enumerate() {
            let kinetic = column(&|stress| stress.kinetic.shear()[c]);
            let dissipative = column(&|stress| stress.dissipative.shear()[c]);
            found.extend(scores(&kinetic, &dissipative, 0.0, free * temperature * temperature));
            found.extend(scores(&dissipative, &kinetic, 0.0, temperature * arm));
        }
        let trace = column(&|stress| stress.kinetic.trace());
        let dissipative = column(&|stress| stress.dissipative.trace());
        found.extend(scores(&trace, &dissipative, 3.0 * free * temperature, 6.0 * free * temperature * temperature));
        found
    });
}

/// Where every pair has the relative velocity of a homogeneous flow, v_ij = K r_ij, friction answers with
/// J_D = −Σ Γ r² T T:K: for each flow of the five with what makes η_∞, for a compression with what makes ζ_∞.
#[test]
fn friction_resists_homogeneous_flows_by_the_instantaneous_viscosities() {
    let System { mut particles, region, interactions, workers, .. } = fluid(NoiseKey::new(&[1]));
    // A cluster in the middle of the box, so that no pair looks across its faces.
    let side = region.shortest_side();
    particles
        .position
        .iter_mut()
        .for_each(|position| *position = position.map(|x| 0.2 * side + 0.6 * x.rem_euclid(side)));
    let mut system = System::new(particles, region, interactions, 0.3, workers).unwrap();
    let root = 1.0 / 12f64.sqrt();
    let flows: [[[f64; 3]; 3]; 6] = [
        [[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]],
        [[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]],
        [[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]],
        [[0.5, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0; 3]],
        [[root, 0.0, 0.0], [0.0, root, 0.0], [0.0, 0.0, -2.0 * root]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ];
    for (c, flow) in flows.iter().enumerate() {
        let particles = &mut system.particles;
        for k in 0..particles.count() {
            let velocity: Vector = flow.map(|row| dot(row, particles.position[k]));
            particles.momentum[k] = velocity.map(|v| v / particles.inverse_mass[k]);
        }
        let stress = Stress::of(&mut system);
        let (found, expected) = if c < 5 {
            (stress.dissipative.shear()[c], -stress.instantaneous_shear()[c])
        } else {
            (stress.dissipative.trace(), -9.0 * stress.instantaneous_bulk())
        };
        assert!(found < -100.0 && (found / expected - 1.0).abs() < 1e-12, "flow {c}: {found} for {expected}");
        let difference = stress.forward() - stress.backward();
        assert!((difference.trace() / (2.0 * stress.dissipative.trace()) - 1.0).abs() < 1e-12);
    }
    let stress = Stress::of(&mut system);
    let mean = stress.instantaneous_shear().iter().sum::<f64>() / 5.0;
    assert!((mean / (9.0 / 15.0 * stress.instantaneous_bulk()) - 1.0).abs() < 1e-12, "the mean of the five is ΣΓr²/15");
}

#[test]
fn the_stress_has_the_same_bits_for_any_number_of_threads() {
    let fluid = Fluid::groot_warren(6000).with_species(&[(3000, 1.0), (3000, 2.0)]);
    let mut system = fluid.system(1.0, NoiseKey::new(&[1]));
    let one = Stress::of(&mut system);
    system.workers = Workers::Pool;
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| Stress::of(&mut system)), one);
    }
}
