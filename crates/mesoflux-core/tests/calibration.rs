//! Error bars that mean what they say: over many short runs of a fluid the 95 % interval holds the true mean as often as it should.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, friction, replicas, seeds};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;

const RUNS: u64 = 600;

/// Kinetic temperature and pressure of one short run of a soft fluid, sampled at every step.
fn short_run(seed: u64, run: u64) -> Blocking {
    let noise = NoiseKey::new(&[seed, run]);
    let fluid = Fluid { friction: friction(18.0, 1.0), skin: 0.5, ..Fluid::groot_warren(81) };
    let mut simulation = fluid.simulation("ABOBA", None, noise, 0.05);
    advance(&mut simulation, 3.0);
    let mut series = Blocking::new(2).unwrap();
    for _ in 0..1024 {
        simulation.step().unwrap();
        let now = Thermodynamics::of(&mut simulation.system);
        series.record(&[now.kinetic_temperature, now.pressure]).unwrap();
    }
    series
}

/// How many of the runs' 95 % intervals hold the mean of all runs.
fn coverage(runs: &[Blocking], component: usize) -> f64 {
    let estimates: Vec<Estimate> = runs.iter().map(|run| run.component(component)).collect();
    let truth = estimates.iter().map(|estimate| estimate.value.unwrap()).sum::<f64>() / runs.len() as f64;
    let holds = |estimate: &&Estimate| {
        let (low, high) = estimate.interval(0.95).unwrap();
        (low..=high).contains(&truth)
    };
    estimates.iter().filter(holds).count() as f64 / runs.len() as f64
}

#[test]
fn intervals_of_short_runs_hold_the_truth_as_often_as_they_promise() {
    let seeds = seeds();
    let mut mean = [0.0; 2];
    for seed in 1..=seeds {
        let runs = replicas(RUNS, |run| short_run(seed, run));
        let found = [0, 1].map(|component| coverage(&runs, component));
        let memory = [0, 1].map(|component| {
            let weights = if component == 0 { [1.0, 0.0] } else { [0.0, 1.0] };
            let mut all = Blocking::new(2).unwrap();
            runs.iter().for_each(|run| all.merge(run).unwrap());
            all.correlation_time(&weights).value.unwrap()
        });
        println!("coverage of kinetic temperature and pressure {found:?}, correlation times in steps {memory:.1?}");
        assert!(memory.iter().all(|&steps| steps > 2.0), "without correlation nothing is tested");
        for (mean, found) in mean.iter_mut().zip(found) {
            *mean += found / seeds as f64;
        }
        if seeds == 1 {
            assert!(found.iter().all(|covered| (0.92..=0.9775).contains(covered)), "{found:?}");
        }
    }
    assert!(mean.iter().all(|covered| (0.92..=0.9775).contains(covered)), "over {seeds} seeds: {mean:?}");
}
