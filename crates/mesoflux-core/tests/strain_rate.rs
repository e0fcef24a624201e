//! The local velocity gradient: what flows put in by hand give, what thermal motion adds, and the same bits for any number of threads.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, check_scores, friction, interactions};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::friction::Friction;
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::observable::{LocalGradients, Normalization, StrainRate, StrainRateError, VelocityGradient};
use mesoflux_core::start::{Start, draw_free_momenta, positions};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, dot, subtract};

/// Particles without potential anywhere in a cubic box, at rest; the neighbor list sees as far as 1.
fn ideal_fluid(count: usize, side: f64, masses: &[f64], noise: NoiseKey) -> System {
    let region = PeriodicBox::new([side; 3]).unwrap();
    let species = (0..count).map(|k| (k % masses.len()) as u8).collect();
    let particles = Particles::at_rest(positions(Start::Random, count, &region, noise), species, masses);
    let law = Friction::Linear(friction(4.5, 1.0));
    let laws = interactions(masses, |_, _| None, |_, _| Some(law.clone()));
    System::new(particles, region, laws, 0.3, Workers::One).unwrap()
}

/// Adds a velocity that follows from the place to every particle.
fn add_flow(system: &mut System, velocity: impl Fn(Vector) -> Vector) {
    let particles = &mut system.particles;
    for k in 0..particles.count() {
        let flow = velocity(particles.position[k]);
        for axis in 0..3 {
            particles.momentum[k][axis] += flow[axis] / particles.inverse_mass[k];
        }
    }
}

/// v_b = Σ_a r_a ∂_a v_b.
fn uniform(gradient: [Vector; 3]) -> impl Fn(Vector) -> Vector {
    move |place| [0, 1, 2].map(|b| (0..3).map(|a| place[a] * gradient[a][b]).sum())
}

/// The gradients of those particles that see no face of the box, across which a uniform gradient jumps.
fn inner(system: &System, gradients: &LocalGradients) -> Vec<VelocityGradient> {
    let side = system.region.shortest_side();
    let inside = |place: &Vector| place.iter().all(|&x| x > 1.0 && x < side - 1.0);
    let all = system.particles.position.iter().zip(&gradients.0);
    all.filter(|(place, _)| inside(place)).map(|(_, gradient)| gradient.unwrap()).collect()
}

/// The sum over a number of particles that itself is random, over about what it is: the mean over them would be biased, because
/// where many lie in a region, their neighbors do too.
fn excess(differences: impl Iterator<Item = f64>) -> f64 {
    differences.sum::<f64>() / 40.0
}

/// The z-score of the mean of independent samples.
fn score(samples: &[f64], expected: f64) -> f64 {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    println!("{mean:.5} ± {:.5} for {expected:.5}", (variance / n).sqrt());
    (mean - expected) / (variance / n).sqrt()
}

fn estimator(cutoff: f64, exponent: f64, normalization: Normalization) -> StrainRate {
    StrainRate::new(cutoff, exponent, normalization).unwrap()
}

/// A gradient without any symmetry.
const GRADIENT: [Vector; 3] = [[0.3, -1.1, 0.2], [2.0, -0.7, 0.5], [-0.4, 0.9, 1.3]];

#[test]
fn every_particle_finds_a_uniform_gradient_exactly() {
    let mut system = ideal_fluid(500, 3.6, &[1.0, 2.5], NoiseKey::new(&[1]));
    add_flow(&mut system, uniform(GRADIENT));
    for (cutoff, exponent) in [(1.0, 0.0), (0.8, 0.0), (1.0, 2.0), (0.9, 0.5)] {
        let gradients = estimator(cutoff, exponent, Normalization::Local).of(&mut system).unwrap();
        let found = inner(&system, &gradients);
        assert!(found.len() > 30);
        for (found, expected) in
            found.iter().flat_map(|gradient| gradient.0.as_flattened().iter().zip(GRADIENT.as_flattened()))
        {
            assert!((found - expected).abs() < 1e-11, "{found} for {expected}, s = {exponent}");
        }
    }
}

/// The paper's form among neighbors of two masses that lie anywhere and move thermally: right on average with the step function.
#[test]
fn the_papers_form_finds_a_uniform_gradient_on_average() {
    check_scores(|seed| {
        let step = estimator(1.0, 0.0, Normalization::Isotropic);
        let mut samples = [const { Vec::new() }; 9];
        for configuration in 0..300 {
            let noise = NoiseKey::new(&[seed, configuration]);
            let mut system = ideal_fluid(400, 3.6, &[1.0, 2.5], noise);
            draw_free_momenta(&mut system.particles, 1.0, noise);
            add_flow(&mut system, uniform(GRADIENT));
            let gradients = step.of(&mut system).unwrap();
            let found = inner(&system, &gradients);
            for (k, samples) in samples.iter_mut().enumerate() {
                let expected = GRADIENT.as_flattened()[k];
                samples.push(excess(found.iter().map(|gradient| gradient.0.as_flattened()[k] - expected)));
            }
        }
        samples.iter().map(|samples| score(samples, 0.0)).collect()
    });
}

/// The number of neighbors within a distance of one, of all others in the box: the mean of 1/n over those who have any.
fn mean_inverse_neighbors(count: usize, side: f64) -> f64 {
    let chance = 4.0 / 3.0 * std::f64::consts::PI / side.powi(3);
    let others = count as f64 - 1.0;
    let (mut probability, mut sum) = ((1.0 - chance).powf(others), 0.0);
    let none = probability;
    for n in 1..count {
        probability *= (others - n as f64 + 1.0) / n as f64 * chance / (1.0 - chance);
        sum += probability / n as f64;
    }
    sum / (1.0 - none)
}

/// ⟨Σωr²/Σω⟩/(3C) for ω = (1 − r)² over the neighbors within one of a particle that has any, of all others in the box.
///
/// 1/B = ∫₀^∞ e^(−tB) dt, and the neighbors are independent: with q the chance that one of N − 1 others is near, the mean is
/// (N − 1) q ∫ ⟨ωr² e^(−tω)⟩ (1 − q + q⟨e^(−tω)⟩)^(N − 2) dt over the chance of any.
fn mean_ratio_of_weighted_sums(count: usize, side: f64) -> f64 {
    let chance = 4.0 / 3.0 * std::f64::consts::PI / side.powi(3);
    let others = count as f64 - 1.0;
    let (radii, times, end) = (500, 4000, 30.0);
    let integrand = |t: f64| {
        let [moment, transform] =
            (0..radii).map(|k| (f64::from(k) + 0.5) / f64::from(radii)).fold([0.0; 2], |[a, b], r| {
                let weight = (1.0 - r) * (1.0 - r);
                let share = 3.0 * r * r / f64::from(radii) * (-t * weight).exp();
                [a + share * weight * r * r, b + share]
            });
        moment * (1.0 - chance + chance * transform).powf(others - 1.0)
    };
    let step = end / f64::from(times);
    let integral: f64 = (0..times).map(|k| step * integrand((f64::from(k) + 0.5) * step)).sum();
    let constant = 4.0 / (6.0 * 7.0);
    others * chance * integral / (1.0 - (1.0 - chance).powf(others)) / (3.0 * constant)
}

/// With ω = (1 − r)², Σωr² and Σω vary together: the mean of their ratio is high by some
/// ⟨1/n⟩(⟨ω²⟩/⟨ω⟩² − ⟨ω²r²⟩/(⟨ω⟩⟨ωr²⟩)) = 1.19⟨1/n⟩.
#[test]
fn the_papers_form_with_another_weight_is_high_by_one_over_the_neighbors() {
    let (count, side) = (500, 3.6);
    let expected = mean_ratio_of_weighted_sums(count, side);
    let leading = (20.0 / 7.0 - 5.0 / 3.0) * mean_inverse_neighbors(count, side);
    println!("{expected:.5}, to leading order {:.5}", 1.0 + leading);
    assert!((expected - 1.0 - leading).abs() < 0.2 * leading);
    check_scores(|seed| {
        let weighted = estimator(1.0, 2.0, Normalization::Isotropic);
        let samples: Vec<f64> = (0..300)
            .map(|configuration| {
                let mut system = ideal_fluid(count, side, &[1.0], NoiseKey::new(&[seed, configuration]));
                add_flow(&mut system, uniform([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
                let gradients = weighted.of(&mut system).unwrap();
                excess(inner(&system, &gradients).iter().map(|gradient| gradient.divergence() / 3.0 - expected))
            })
            .collect();
        vec![score(&samples, 0.0)]
    });
}

/// v = Ω × r has the vorticity 2Ω and no rate of strain; of the paper's form only the divergence is zero for every particle.
#[test]
fn rotation_is_no_strain() {
    let turning = [0.7, -0.4, 1.1];
    let mut system = ideal_fluid(500, 3.6, &[1.0, 3.0], NoiseKey::new(&[1]));
    add_flow(&mut system, |[x, y, z]| {
        let [a, b, c] = turning;
        [b * z - c * y, c * x - a * z, a * y - b * x]
    });
    let gradients = estimator(1.0, 1.0, Normalization::Local).of(&mut system).unwrap();
    for gradient in inner(&system, &gradients) {
        assert!(gradient.shear_rate() < 1e-11 && gradient.divergence().abs() < 1e-11);
        for (found, expected) in gradient.vorticity().into_iter().zip(turning) {
            assert!((found - 2.0 * expected).abs() < 1e-11, "{found} for {}", 2.0 * expected);
        }
    }
    let gradients = estimator(1.0, 0.0, Normalization::Isotropic).of(&mut system).unwrap();
    let largest = inner(&system, &gradients).iter().fold([0.0f64; 2], |[expansion, shear], gradient| {
        [expansion.max(gradient.divergence().abs()), shear.max(gradient.shear_rate())]
    });
    assert!(largest[0] < 1e-12 && largest[1] > 0.1, "{largest:?}");
}

/// The field of v_x = sin(ky)/k is cos(ky), less what the sphere of neighbors smooths: f = 15[(3 − k²) sin k − 3k cos k]/k⁵ for r_c = 1.
#[test]
fn the_profile_of_a_wave_is_the_smoothed_field() {
    check_scores(|seed| {
        let (side, layers) = (4.0, 8);
        let k = std::f64::consts::TAU / side;
        let smoothing = 15.0 * ((3.0 - k * k) * k.sin() - 3.0 * k * k.cos()) / k.powi(5);
        assert!((0.8..0.9).contains(&smoothing));
        // Means of cos(ky) over the layers.
        let edge = |layer: usize| k * side * layer as f64 / layers as f64;
        let expected: Vec<f64> =
            (0..layers).map(|n| (edge(n + 1).sin() - edge(n).sin()) / (edge(n + 1) - edge(n))).collect();
        let samples: Vec<f64> = (0..150)
            .map(|configuration| {
                let mut system = ideal_fluid(500, side, &[1.0, 2.5], NoiseKey::new(&[seed, configuration]));
                add_flow(&mut system, |[_, y, _]| [(k * y).sin() / k, 0.0, 0.0]);
                let gradients = estimator(1.0, 0.0, Normalization::Isotropic).of(&mut system).unwrap();
                let profile = gradients.profile(&system.particles, &system.region, 1, layers);
                assert_eq!(profile.iter().map(|layer| layer.count).sum::<u64>(), 500);
                let found = profile.iter().map(|layer| layer.gradient.0[1][0]);
                let product: f64 = found.zip(&expected).map(|(found, expected)| found * expected).sum();
                product / (500.0 / layers as f64 * expected.iter().map(|c| c * c).sum::<f64>())
            })
            .collect();
        vec![score(&samples, smoothing)]
    });
}

/// In equilibrium every component has the variance 2kT⟨1/n⟩/(mC), so that ⟨γ̇²⟩ is ten times that.
#[test]
fn thermal_motion_gives_a_shear_rate_of_known_size() {
    check_scores(|seed| {
        let (count, side, temperature) = (400, 3.6, 0.1);
        let step = estimator(1.0, 0.0, Normalization::Isotropic);
        let variance = 2.0 * temperature * mean_inverse_neighbors(count, side) / step.constant();
        let mut samples = [const { Vec::new() }; 2];
        for configuration in 0..150 {
            let noise = NoiseKey::new(&[seed, configuration]);
            let mut system = ideal_fluid(count, side, &[1.0], noise);
            draw_free_momenta(&mut system.particles, temperature, noise);
            let gradients: Vec<VelocityGradient> = step.of(&mut system).unwrap().0.into_iter().flatten().collect();
            let mean = |value: &dyn Fn(&VelocityGradient) -> f64| {
                gradients.iter().map(value).sum::<f64>() / gradients.len() as f64
            };
            samples[0].push(mean(&|gradient| gradient.vorticity().map(|w| w * w).into_iter().sum::<f64>() / 6.0));
            samples[1].push(mean(&|gradient| gradient.shear_rate().powi(2)));
        }
        vec![score(&samples[0], variance), score(&samples[1], 10.0 * variance)]
    });
}

/// A fluid in some state of motion, its particles not where they were when they were sorted.
fn moving_fluid(count: usize) -> System {
    let fluid = Fluid::groot_warren(count).with_species(&[(count / 2, 1.0), (count - count / 2, 2.0)]);
    let mut system = fluid.system(1.0, NoiseKey::new(&[1]));
    let draw = NoiseKey::new(&[2]).draw(Purpose::Start, 0, 0);
    for (k, position) in system.particles.position.iter_mut().enumerate() {
        *position = [0, 1, 2].map(|axis| position[axis] + 0.08 * draw.gaussian(k as u64, axis as u64).clamp(-1.0, 1.0));
    }
    system.positions_moved().unwrap();
    system
}

/// Eq. 26 as it stands, over all pairs; C from the weight's moments is r_c²/5 for s = 0 and 2r_c²/15 for s = 1.
#[test]
fn sums_are_those_over_all_pairs() {
    let mut system = moving_fluid(300);
    let cutoff = 0.9;
    for (exponent, constant) in [(0.0, cutoff * cutoff / 5.0), (1.0, 2.0 / 15.0 * cutoff * cutoff)] {
        let found = estimator(cutoff, exponent, Normalization::Isotropic).of(&mut system).unwrap();
        let particles = &system.particles;
        let mut lonely = 0;
        for i in 0..particles.count() {
            let (mut sum, mut mass) = ([[0.0; 3]; 3], 0.0);
            for j in (0..particles.count()).filter(|&j| j != i) {
                let d = system.region.nearest_image(subtract(particles.position[j], particles.position[i]));
                let r = dot(d, d).sqrt();
                if r < cutoff {
                    let (m, weight) = (1.0 / particles.inverse_mass[j], (1.0 - r / cutoff).powf(exponent));
                    mass += m * weight;
                    for a in 0..3 {
                        for b in 0..3 {
                            sum[a][b] += d[a] * (particles.momentum[j][b] - m * particles.velocity(i)[b]) * weight;
                        }
                    }
                }
            }
            let Some(gradient) = found.0[i] else {
                lonely += 1;
                assert_eq!(mass, 0.0);
                continue;
            };
            for (found, sum) in gradient.0.as_flattened().iter().zip(sum.as_flattened()) {
                let expected = sum / (constant * mass);
                assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()), "{found} for {expected}");
            }
        }
        assert!(lonely < 10);
    }
}

#[test]
fn gradients_have_the_same_bits_for_any_number_of_threads() {
    let mut system = moving_fluid(6000);
    for normalization in [Normalization::Isotropic, Normalization::Local] {
        let strain_rate = estimator(1.0, 2.0, normalization);
        system.workers = Workers::One;
        let one = strain_rate.of(&mut system).unwrap();
        assert!(one.sum().count > 5990);
        system.workers = Workers::Pool;
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| strain_rate.of(&mut system).unwrap()) == one, "{threads} threads");
        }
    }
}

#[test]
fn too_few_neighbors_tell_nothing_and_too_long_a_cutoff_is_refused() {
    let mut system = ideal_fluid(20, 6.0, &[1.0], NoiseKey::new(&[3]));
    draw_free_momenta(&mut system.particles, 1.0, NoiseKey::new(&[3]));
    let [isotropic, local] = [Normalization::Isotropic, Normalization::Local]
        .map(|normalization| estimator(1.0, 0.0, normalization).of(&mut system).unwrap());
    assert!(isotropic.sum().count > 2 && isotropic.sum().count < 20, "those with a neighbor");
    assert_eq!((local.sum().count, local.sum().mean()), (0, None), "none has three");
    let error = estimator(1.01, 0.0, Normalization::Local).of(&mut system).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the cutoff of the local strain rate is 1.01: must be at most 1, the largest cutoff of any pair law, because only \
         neighbors within that are known"
    );
    for (cutoff, exponent) in [(0.0, 0.0), (f64::NAN, 1.0), (1.0, -0.5), (1.0, f64::INFINITY)] {
        let error = StrainRate::new(cutoff, exponent, Normalization::Local).unwrap_err();
        assert!(matches!(error, StrainRateError::Parameter { .. }));
    }
}
