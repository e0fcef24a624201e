//! The instantaneous stress: what equilibrium says of its moments, and what friction makes of a shear.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, friction};
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange, Topology};
use mesoflux_core::domain::Workers;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::{Stress, StressProfile, TRANSVERSE, TransverseCurrents};
use mesoflux_core::potential::harmonic::Harmonic;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::system::System;
use mesoflux_core::tensor::SymmetricTensor;
use mesoflux_core::vector::{Vector, ZERO, add_scaled, dot, subtract};

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
            let strength = frictions.entries()[contacts.kind(k)].as_ref().unwrap().at_rest(r);
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

/// The fluid with bonds between some of its particles, wherever they are by now: their forces needn't be small.
fn bonded_fluid() -> System {
    let law = BondLaw::Harmonic(Harmonic { stiffness: 2.0, length: 1.0 });
    let bonds = (0..30).map(|k| Bond { law: 0, first: 5 * k, second: 5 * k + 3 }).collect();
    let topology = Topology::new(192, vec![law], bonds, ExclusionRange { potential: 1, friction: 1 }).unwrap();
    fluid(NoiseKey::new(&[1])).with_bonds(topology)
}

/// The largest difference between the components of two tensors.
fn distance(a: SymmetricTensor, b: SymmetricTensor) -> f64 {
    (a - b).0.into_iter().fold(0.0, |largest, difference| difference.abs().max(largest))
}

#[test]
fn the_layers_of_a_profile_sum_to_the_stress() {
    let mut system = bonded_fluid();
    let whole = Stress::of(&mut system);
    for (axis, count) in [(0, 1), (0, 7), (1, 40), (2, 1000)] {
        let profile = StressProfile::of(&mut system, axis, count);
        assert_eq!((profile.axis, profile.layers.len()), (axis, count));
        let sum = |part: fn(&Stress) -> SymmetricTensor| {
            profile.layers.iter().fold(SymmetricTensor::default(), |sum, layer| sum + part(layer))
        };
        for part in
            [|s: &Stress| s.kinetic, |s: &Stress| s.conservative, |s: &Stress| s.dissipative, |s: &Stress| s.friction]
        {
            let off = distance(sum(part), part(&whole));
            assert!(off < 1e-9, "axis {axis}, {count} layers: off by {off:e} of {:?}", part(&whole));
        }
    }
}

/// Wu & Shang's eq. 81b with the integral done point by point along the line from one particle to the other.
#[test]
fn each_layer_has_its_share_of_every_line() {
    let mut system = bonded_fluid();
    let (count, points) = (5, 1000);
    for axis in 0..3 {
        let profile = StressProfile::of(&mut system, axis, count);
        let (particles, region) = (&system.particles, system.region);
        let side = region.sides()[axis];
        let layer = |y: f64| ((y / side).rem_euclid(1.0) * count as f64) as usize % count;
        let mut layers = vec![Stress::default(); count];
        for i in 0..particles.count() {
            let kinetic = particles.inverse_mass[i] * SymmetricTensor::square(particles.momentum[i]);
            layers[layer(particles.position[i][axis])].kinetic += kinetic;
            for j in 0..i {
                let d = region.nearest_image(subtract(particles.position[i], particles.position[j]));
                let (r, species) = (dot(d, d).sqrt(), [particles.species[i], particles.species[j]]);
                let ids = [particles.id[i], particles.id[j]];
                let bonded =
                    ids[0].abs_diff(ids[1]) == 3 && ids[0].min(ids[1]).is_multiple_of(5) && ids[0].min(ids[1]) < 150;
                let laws = &system.interactions;
                let force = if bonded {
                    2.0 * (1.0 - r)
                } else {
                    laws.potentials.get(species[0], species[1]).as_ref().unwrap().force(r)
                };
                let strength =
                    if bonded { 0.0 } else { laws.frictions.get(species[0], species[1]).as_ref().unwrap().at_rest(r) };
                if force != 0.0 || strength != 0.0 {
                    let u = dot(d, subtract(particles.velocity(i), particles.velocity(j))) / r;
                    let square = SymmetricTensor::square(d);
                    for point in 0..points {
                        let along = (f64::from(point) + 0.5) / f64::from(points);
                        let target = &mut layers[layer(particles.position[j][axis] + along * d[axis])];
                        target.conservative += (force / r / f64::from(points)) * square;
                        target.dissipative += (-strength * u / r / f64::from(points)) * square;
                    }
                }
            }
        }
        for (found, expected) in profile.layers.iter().zip(&layers) {
            assert!(distance(found.kinetic, expected.kinetic) < 1e-10);
            // Each of some hundred lines that cross a face is shared to 1/1000.
            let off = [(found.conservative, expected.conservative), (found.dissipative, expected.dissipative)];
            let off = off.map(|(found, expected)| distance(found, expected));
            assert!(off[0] < 0.05 && off[1] < 0.05, "axis {axis}: off by {off:?} of {found:?}");
        }
    }
}

#[test]
fn transverse_currents_are_fourier_components_of_the_momenta() {
    let mut system = fluid(NoiseKey::new(&[1]));
    // Positions outside the box are those inside.
    (0..192).for_each(|k| system.particles.position[k][k % 3] += system.region.sides()[k % 3] * (k as f64 % 5.0 - 2.0));
    let currents = TransverseCurrents::of(&system, 4);
    for (n, wave) in currents.waves.iter().enumerate() {
        for (current, [a, b]) in wave.iter().zip(TRANSVERSE) {
            assert_ne!(a, b);
            let k = std::f64::consts::TAU * (n + 1) as f64 / system.region.sides()[b];
            let mut expected = [0.0; 2];
            for (position, momentum) in system.particles.position.iter().zip(&system.particles.momentum) {
                let (sin, cos) = (k * position[b]).sin_cos();
                expected[0] += momentum[a] * cos;
                expected[1] += momentum[a] * sin;
            }
            let off = (current[0] - expected[0]).hypot(current[1] - expected[1]);
            assert!(
                off < 1e-11 && expected[0].hypot(expected[1]) > 0.1,
                "wave {n}, {a}{b}: {current:?} for {expected:?}"
            );
        }
    }
}
