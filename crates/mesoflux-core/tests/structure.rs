//! Pairs by distance and structure factors against their definitions, and against what is known of an ideal fluid.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, replicas};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::{RadialBins, Thermodynamics, pairs_of_species, shells, structure_factors};
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::lennard_jones::Truncation;
use mesoflux_core::potential::soft::Soft;
use mesoflux_core::start::{Start, positions};
use mesoflux_core::state::Particles;
use mesoflux_core::vector::{dot, subtract};
use std::f64::consts::TAU;

/// Particles in random places of a box, two species in turn.
fn random(count: usize, sides: [f64; 3], seed: u64) -> (Particles, PeriodicBox) {
    let region = PeriodicBox::new(sides).unwrap();
    let sites = positions(Start::Random, count, &region, NoiseKey::new(&[seed]));
    let species = (0..count).map(|k| (k % 2) as u8).collect();
    (Particles::at_rest(sites, species, &[1.0, 1.0]), region)
}

#[test]
fn every_pair_is_counted_once_in_its_bin() {
    // Boxes of few cells and of many, distances up to half the shortest side.
    for (count, sides, longest, bins) in [
        (40, [4.0, 5.0, 6.0], 2.0, 7),
        (500, [9.0, 8.0, 30.0], 1.0, 50),
        (2000, [12.0; 3], 3.3, 20),
        (2, [3.0; 3], 1.5, 3),
    ] {
        let (mut particles, region) = random(count, sides, 1);
        // Particles are in the box when the list is built, not between.
        particles.position.iter_mut().step_by(3).for_each(|position| position[1] += sides[1]);
        particles.position.iter_mut().skip(1).step_by(3).for_each(|position| position[2] -= 0.3);
        let bins = RadialBins { longest, count: bins };
        let mut expected = vec![0; 3 * bins.count];
        for i in 0..count {
            for j in 0..i {
                let d = region.nearest_image(subtract(particles.position[i], particles.position[j]));
                let bin = (dot(d, d).sqrt() / longest * bins.count as f64) as usize;
                if bin < bins.count {
                    expected[(particles.species[i] + particles.species[j]) as usize * bins.count + bin] += 1;
                }
            }
        }
        assert!(expected.iter().sum::<u64>() > 0 || count == 2);
        let found = bins.count_pairs(&particles, &region, 2, Workers::One);
        assert_eq!(found, expected, "{count} particles in {sides:?}");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| bins.count_pairs(&particles, &region, 2, Workers::Pool)), expected);
        particles.species.fill(0);
        let together = bins.count_pairs(&particles, &region, 1, Workers::One);
        let sum = |bin: usize| (0..3).map(|kind| expected[kind * bins.count + bin]).sum::<u64>();
        assert_eq!(together, (0..bins.count).map(sum).collect::<Vec<_>>());
    }
}

#[test]
fn pairs_of_species_are_all_pairs() {
    assert_eq!(pairs_of_species(&[4, 3]), [6.0, 12.0, 3.0]);
}

/// g(r) of particles in random places, configuration by configuration.
fn ideal(seed: u64, configurations: u64, bins: RadialBins) -> Vec<Blocking> {
    let mut profile = vec![Blocking::new(1).unwrap(); bins.count];
    for configuration in 0..configurations {
        let (particles, region) = random(100, [5.0, 4.0, 6.0], seed << 32 | configuration);
        let counts = bins.count_pairs(&particles, &region, 1, Workers::One);
        for (bin, (series, count)) in profile.iter_mut().zip(counts).enumerate() {
            series.record(&[count as f64 / (0.5 * 100.0 * 99.0 * bins.volume(bin) / region.volume())]).unwrap();
        }
    }
    profile
}

#[test]
fn independent_particles_have_no_structure() {
    check_scores(|seed| {
        let profile = ideal(seed, 2000, RadialBins { longest: 2.0, count: 10 });
        profile.iter().map(|series| series.estimate().z_score_against(1.0, 0.0).unwrap()).collect()
    });
}

/// The bins of 400 runs of 128 configurations: their intervals hold g = 1 as often as they promise.
#[test]
fn intervals_of_short_runs_hold_the_truth_as_often_as_they_promise() {
    let bins = RadialBins { longest: 2.0, count: 10 };
    let runs = replicas(400, |run| ideal(1000 + run, 128, bins));
    let holds = |estimate: Estimate| estimate.interval(0.95).is_some_and(|(low, high)| low <= 1.0 && 1.0 <= high);
    let covered = runs.iter().flatten().filter(|series| holds(series.estimate())).count() as f64 / 4000.0;
    println!("coverage {covered}");
    assert!((0.92..=0.9775).contains(&covered), "{covered}");
}

/// The virial of one configuration from its pairs by distance, each taken for the mean of its bin: what it then lacks is how
/// pairs scatter within their bins, evenly to lowest order.
#[test]
fn the_virial_by_bins_is_the_virial() {
    for (fluid, law) in [
        (Fluid::groot_warren(192), Potential::Soft(Soft { repulsion: 25.0, cutoff: 1.0 })),
        (Fluid::lennard_jones(216), common::lennard_jones(2.5, Truncation::ForceShifted)),
    ] {
        let mut simulation = fluid.simulation("ABOBA", None, NoiseKey::new(&[1]), 0.004);
        advance(&mut simulation, 1.0);
        let system = &mut simulation.system;
        let bins = RadialBins { longest: law.cutoff(), count: 2000 };
        let counts = bins.count_pairs(&system.particles, &system.region, 1, Workers::One);
        let (mut virial, mut variance) = (0.0, 0.0);
        for (bin, &count) in counts.iter().enumerate() {
            let spread = bins.edges(bin).map(|r| r * law.force(r));
            virial += count as f64 * bins.mean_virial(bin, &law);
            variance += count as f64 * if count > 0 { (spread[1] - spread[0]).powi(2) / 12.0 } else { 0.0 };
        }
        let now = Thermodynamics::of(system);
        let volume = system.region.volume();
        let direct = 3.0 * volume * (now.pressure - fluid.density * now.kinetic_temperature);
        println!("{direct} directly, {virial} by bins, scatter {}", variance.sqrt());
        assert!((virial - direct).abs() < 4.0 * variance.sqrt(), "{virial} against {direct} ± {}", variance.sqrt());
        assert!(variance.sqrt() < 2e-3 * direct, "the test can't tell");
    }
}

#[test]
fn the_mean_virial_of_a_bin_is_its_integral() {
    // ∫ r³ a(1 − r) dr / ∫ r² dr.
    let bins = RadialBins { longest: 1.0, count: 4 };
    let law = Potential::Soft(Soft { repulsion: 25.0, cutoff: 1.0 });
    for bin in 0..4 {
        let [from, to] = bins.edges(bin);
        let integral = |r: f64| 25.0 * (r.powi(4) / 4.0 - r.powi(5) / 5.0);
        let expected = (integral(to) - integral(from)) / ((to.powi(3) - from.powi(3)) / 3.0);
        assert!((bins.mean_virial(bin, &law) / expected - 1.0).abs() < 1e-3);
    }
}

#[test]
fn shells_hold_every_wave_vector_once() {
    let region = PeriodicBox::new([5.0; 3]).unwrap();
    let found = shells(&region, 2.0 * TAU / 5.0);
    assert_eq!(found.iter().map(|shell| shell.waves.len()).collect::<Vec<_>>(), [3, 6, 4, 3]);
    for (shell, squared) in found.iter().zip([1.0f64, 2.0, 3.0, 4.0]) {
        assert!((shell.wave_number / (TAU / 5.0) - squared.sqrt()).abs() < 1e-12);
        for waves in &shell.waves {
            assert!(!shell.waves.contains(&waves.map(|n| -n)));
        }
    }
    let elongated = PeriodicBox::new([5.0, 10.0, 5.0]).unwrap();
    assert_eq!(shells(&elongated, TAU / 10.0)[0].waves, [[0, 1, 0]]);
    assert!(shells(&elongated, 0.99 * TAU / 10.0).is_empty());
}

#[test]
fn structure_factors_are_those_of_the_definition() {
    let (mut particles, region) = random(300, [5.0, 4.0, 6.0], 1);
    particles.position.iter_mut().step_by(3).for_each(|position| position[2] -= 7.0);
    let shells = shells(&region, 3.5);
    assert!(shells.len() > 4);
    let found = structure_factors(&particles, &region, &shells, Workers::One);
    for (shell, found) in shells.iter().zip(&found) {
        let mut sum = 0.0;
        for waves in &shell.waves {
            let k: [f64; 3] = std::array::from_fn(|axis| f64::from(waves[axis]) * TAU / region.sides()[axis]);
            let parts = particles.position.iter().map(|&r| dot(k, r));
            let (re, im) = parts.fold((0.0, 0.0), |(re, im), phase| (re + phase.cos(), im - phase.sin()));
            sum += (re * re + im * im) / 300.0;
        }
        let expected = sum / shell.waves.len() as f64;
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected), "|k| = {}: {found}, {expected}", shell.wave_number);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| structure_factors(&particles, &region, &shells, Workers::Pool)), found);
}

/// S(k) = 1 for independent particles.
#[test]
fn independent_particles_have_a_structure_factor_of_one() {
    check_scores(|seed| {
        let shells = shells(&PeriodicBox::new([5.0, 4.0, 6.0]).unwrap(), 2.3);
        let mut series = Blocking::new(shells.len()).unwrap();
        for configuration in 0..2000 {
            let (particles, region) = random(50, [5.0, 4.0, 6.0], seed << 32 | configuration);
            series.record(&structure_factors(&particles, &region, &shells, Workers::One)).unwrap();
        }
        (0..shells.len()).map(|shell| series.component(shell).z_score_against(1.0, 0.0).unwrap()).collect()
    });
}
