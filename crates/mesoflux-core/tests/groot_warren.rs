//! Groot and Warren's fluid (ρ = 3, a = 25, γ = 4.5): its published pressure, its temperatures, and the order of ABOBA.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, replicas, seeds};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::integrate::{FluxChange, Integrator, Schedule, Stroke};
use mesoflux_core::lanes::Row;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, dot};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

fn fluid(count: usize) -> Fluid {
    Fluid { skin: 0.7, ..Fluid::groot_warren(count) }
}

fn merged(parts: &[Blocking]) -> Blocking {
    let mut all = Blocking::new(parts[0].components()).unwrap();
    parts.iter().for_each(|part| all.merge(part).unwrap());
    all
}

fn known(estimate: &Estimate) -> (f64, f64) {
    (estimate.value.unwrap(), estimate.standard_error.unwrap())
}

/// Allen and Tildesley's 23.635(2), at a step so small that ABOBA's error, about 50 Δt², doesn't count.
#[test]
fn pressure_is_the_published_one() {
    check_scores(|seed| {
        let parts = replicas(2, |replica| {
            let mut simulation = fluid(648).simulation("ABOBA", None, NoiseKey::new(&[seed, replica]), 0.005);
            advance(&mut simulation, 5.0);
            let mut series = Blocking::new(1).unwrap();
            for _ in 0..900 {
                advance(&mut simulation, 0.05);
                series.record(&[Thermodynamics::of(&mut simulation.system).pressure]).unwrap();
            }
            series
        });
        let pressure = merged(&parts).estimate();
        println!("pressure {:?}", known(&pressure));
        assert!(pressure.relative_error().unwrap() < 1e-3);
        vec![pressure.z_score_against(23.635, 0.002).unwrap()]
    });
}

/// One step; returns the work that the noise does on the velocities as they are before each sweep.
///
/// Its mean is zero, exactly and at any step size; all that the temperatures do beyond a few correlation times follows from it.
fn step_with_noise_work(system: &mut System, schedule: &Schedule, noise: NoiseKey, dt: f64) -> f64 {
    let mut work = 0.0;
    for (place, (letter, share)) in schedule.entries().iter().enumerate() {
        let velocity: Vec<Vector> = (0..system.particles.count()).map(|k| system.particles.velocity(k)).collect();
        let product = |system: &System| -> f64 {
            system.particles.momentum.iter().zip(&velocity).map(|(&p, &v)| dot(p, v)).sum()
        };
        let rows: Vec<Row> = velocity.iter().map(|&v| Row::new(v, 0.0)).collect();
        let before = product(system);
        let stroke = Stroke {
            time: share * dt,
            place: place as u64,
            noise,
            backward: schedule.backward(system.step),
            constraint: None,
            response: (letter.symbol() == 'O').then_some(&rows),
        };
        if let FluxChange::Expected(expected) = letter.apply(system, &stroke).unwrap().flux {
            work += product(system) - before - expected;
        }
    }
    system.step += 1;
    work
}

/// Kinetic temperature, |∇U|², ∇²U and noise power per particle, over two replicas of a run.
fn temperatures(dt: f64, time: f64, seed: u64) -> Blocking {
    let parts = replicas(2, |replica| {
        let noise = NoiseKey::new(&[seed, dt.to_bits(), replica]);
        let mut simulation = fluid(375).simulation("ABOBA", None, noise, dt);
        advance(&mut simulation, 5.0);
        let Integrator::Splitting(schedule) = common::splitting("ABOBA") else { unreachable!() };
        let (mut system, mut series) = (simulation.system, Blocking::new(4).unwrap());
        let every = (0.06 / dt).round() as u64;
        for _ in 0..(0.5 * time / dt) as u64 / every {
            let work: f64 = (0..every).map(|_| step_with_noise_work(&mut system, &schedule, noise, dt)).sum();
            let power = work / (375.0 * dt * every as f64);
            let now = Thermodynamics::of(&mut system);
            series.record(&[now.kinetic_temperature, now.force_squared, now.laplacian, power]).unwrap();
        }
        series
    });
    merged(&parts)
}

/// Time step, kinetic and configurational temperature.
type Series = Vec<(f64, Estimate, Estimate)>;

/// Both temperatures at six steps, measured once a seed.
///
/// A control variate, the noise power times its regression coefficient (any coefficient is without bias), takes away most of the
/// slow fluctuation.
fn series(seed: u64) -> Arc<Series> {
    static DONE: Mutex<Option<HashMap<u64, Arc<Series>>>> = Mutex::new(None);
    const POWER: f64 = 0.28;
    let mut done = DONE.lock().unwrap();
    let measured = done.get_or_insert_with(HashMap::new).entry(seed).or_insert_with(|| {
        let plan = [(0.02, 850.0), (0.03, 1800.0), (0.04, 2400.0), (0.05, 1200.0), (0.06, 700.0), (0.07, 1000.0)];
        let measure = |(dt, time)| {
            let all = temperatures(dt, time, seed);
            let kinetic = all.linear(&[1.0, 0.0, 0.0, -POWER]);
            let configurational =
                all.function(|m| m[1] / m[2] - POWER * m[3], |m| vec![0.0, 1.0 / m[2], -m[1] / (m[2] * m[2]), -POWER]);
            println!(
                "Δt = {dt}: kinetic {:?}, configurational {:?}, uncontrolled errors {:?} {:?}",
                known(&kinetic),
                known(&configurational),
                all.component(0).standard_error,
                all.ratio(1, 2).standard_error
            );
            (dt, kinetic, configurational)
        };
        Arc::new(plan.into_iter().map(measure).collect())
    });
    Arc::clone(measured)
}

/// The line a + b x through points (x, y, σ): a, b and their standard errors.
fn line(points: &[(f64, f64, f64)]) -> [(f64, f64); 2] {
    let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 { points.iter().map(|&(x, y, s)| term(x, y) / (s * s)).sum() };
    let (s, sx, sy) = (sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|_, y| y));
    let (sxx, sxy) = (sum(&|x, _| x * x), sum(&|x, y| x * y));
    let determinant = s * sxx - sx * sx;
    [
        ((sxx * sy - sx * sxy) / determinant, (sxx / determinant).sqrt()),
        ((s * sxy - sx * sy) / determinant, (s / determinant).sqrt()),
    ]
}

/// The intercept of a + b Δt² must be kT.
fn score_of_intercept(points: impl Iterator<Item = (f64, Estimate)>) -> f64 {
    let points: Vec<_> = points.map(|(dt, estimate)| (dt * dt, known(&estimate).0, known(&estimate).1)).collect();
    let [(intercept, error), (curvature, _)] = line(&points);
    println!("kT = {intercept:.5}({error:.5}) + {curvature:.2} Δt²");
    assert!(error < 1e-3 * intercept);
    (intercept - 1.0) / error
}

#[test]
fn kinetic_temperature_extrapolates_to_the_set_one() {
    check_scores(|seed| {
        vec![score_of_intercept(series(seed).iter().take(3).map(|(dt, kinetic, _)| (*dt, kinetic.clone())))]
    });
}

#[test]
fn configurational_temperature_extrapolates_to_the_set_one() {
    check_scores(|seed| {
        vec![score_of_intercept(
            series(seed).iter().take(5).map(|(dt, _, configurational)| (*dt, configurational.clone())),
        )]
    });
}

#[test]
fn configurational_temperature_of_aboba_is_of_second_order() {
    let mut sum = 0.0;
    for seed in 1..=seeds() {
        let points: Vec<_> = series(seed)
            .iter()
            .skip(1)
            .map(|(dt, _, configurational)| {
                let (value, error) = known(configurational);
                (dt.ln(), (value - 1.0).abs().ln(), error / (value - 1.0).abs())
            })
            .collect();
        let [_, (slope, error)] = line(&points);
        println!("slope {slope:.3}({error:.3})");
        assert!(error <= 0.15, "the test can't tell");
        sum += slope;
        assert!(seeds() > 1 || (slope - 2.0).abs() <= 0.3);
    }
    assert!((sum / seeds() as f64 - 2.0).abs() <= 0.3);
}
