//! Green and Kubo's viscosities: the noise-free form against the booked stress, part by part, and what wrong signs would give.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, check_scores, friction};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Stress;
use mesoflux_core::tensor::SymmetricTensor;
use std::ops::Range;

/// The five components of `shear`, and a third of the trace.
type Components = [f64; 6];
const SHEAR: Range<usize> = 0..5;
const BULK: Range<usize> = 5..6;

fn components(tensor: &SymmetricTensor) -> Components {
    let [a, b, c, d, e] = tensor.shear();
    [a, b, c, d, e, tensor.trace() / 3.0]
}

/// What is recorded after every step.
#[derive(Default)]
struct Series {
    /// J_K + J_C, which a reversal of time leaves as it is, and J_D, which it turns round: at the end of the step.
    state: [Vec<Components>; 2],
    /// The booked flux of the step: kinetic and conservative, dissipative and random.
    booked: [Vec<Components>; 2],
    /// V η_∞ and V ζ_∞.
    instantaneous: Vec<Components>,
}

impl Series {
    fn record(fluid: &Fluid, noise: NoiseKey, dt: f64, steps: usize) -> Self {
        let mut simulation = fluid.simulation("ABOBA", None, noise, dt);
        advance(&mut simulation, 5.0);
        simulation.book_stress(true);
        let mut series = Self::default();
        for _ in 0..steps {
            simulation.step().unwrap();
            let booked = *simulation.booked_stress().unwrap();
            series.booked[0].push(components(&(booked.kinetic + booked.conservative)));
            series.booked[1].push(components(&(booked.dissipative + booked.random)));
            let stress = Stress::of(&mut simulation.system);
            series.state[0].push(components(&(stress.kinetic + stress.conservative)));
            series.state[1].push(components(&stress.dissipative));
            let [a, b, c, d, e] = stress.instantaneous_shear();
            series.instantaneous.push([a, b, c, d, e, stress.instantaneous_bulk()]);
        }
        // The mean of the trace is three times pressure times volume.
        for column in series.state.iter_mut().chain(&mut series.booked) {
            let mean = column.iter().map(|sample| sample[5]).sum::<f64>() / steps as f64;
            column.iter_mut().for_each(|sample| sample[5] -= mean);
        }
        series
    }

    /// The viscosities' parts for the origins in each of consecutive blocks, per volume (kT = 1).
    fn blocks(&self, components: &Range<usize>, lags: usize, dt: f64, volume: f64) -> Vec<Parts> {
        let block = 10 * lags;
        let factor = 1.0 / (volume * (components.len() * block) as f64);
        let mut blocks = vec![Parts::default(); (self.instantaneous.len() - lags) / block];
        for c in components.clone() {
            let state = self.state.each_ref().map(|column| Running::new(column, c));
            let booked = self.booked.each_ref().map(|column| Running::new(column, c));
            for (number, parts) in blocks.iter_mut().enumerate() {
                for origin in number * block..(number + 1) * block {
                    parts.instantaneous += factor * self.instantaneous[origin][c];
                    for later in 0..2 {
                        for earlier in 0..2 {
                            parts.state[later][earlier] +=
                                factor * dt * state[later].after(origin, lags) * state[earlier].values[origin];
                            parts.booked[later][earlier] +=
                                factor * dt * booked[later].after(origin, lags) * booked[earlier].values[origin];
                        }
                    }
                }
            }
        }
        blocks
    }
}

/// One component of a series and the sums of its first so many values.
struct Running {
    values: Vec<f64>,
    sums: Vec<f64>,
}

impl Running {
    fn new(column: &[Components], component: usize) -> Self {
        let values: Vec<f64> = column.iter().map(|sample| sample[component]).collect();
        let mut sums = vec![0.0];
        values.iter().for_each(|value| sums.push(sums[sums.len() - 1] + value));
        Self { values, sums }
    }

    /// The values from an origin to so many steps later, half of the first and of the last.
    fn after(&self, origin: usize, lags: usize) -> f64 {
        self.sums[origin + lags] - self.sums[origin + 1] + 0.5 * (self.values[origin] + self.values[origin + lags])
    }
}

/// Integrals of ⟨later(t) earlier(0)⟩/(V kT), each of the even (0) or the odd (1) part, from the states and from what was booked.
#[derive(Clone, Copy, Default)]
struct Parts {
    state: [[f64; 2]; 2],
    booked: [[f64; 2]; 2],
    instantaneous: f64,
}

impl Parts {
    /// η_∞ + ∫⟨J₊(t) J₋(0)⟩/(V kT).
    fn noise_free(&self) -> f64 {
        let [[even, even_odd], [odd_even, odd]] = self.state;
        self.instantaneous + even - even_odd + odd_even - odd
    }

    /// Δt [½C₀ + Σ C_k]/(V kT) of the total stress.
    fn total(&self) -> f64 {
        self.booked.iter().flatten().sum()
    }
}

/// Mean over blocks and its standard error.
fn estimate(blocks: &[Parts], value: impl Fn(&Parts) -> f64) -> (f64, f64) {
    let n = blocks.len() as f64;
    let mean = blocks.iter().map(&value).sum::<f64>() / n;
    let spread = blocks.iter().map(|block| (value(block) - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (spread / n).sqrt())
}

struct Case {
    name: &'static str,
    fluid: Fluid,
    dt: f64,
    /// To where the integrals go.
    time: f64,
}

fn cases() -> [Case; 2] {
    let viscous = Fluid { friction: friction(40.5, 1.0), ..Fluid::groot_warren(60) };
    [
        Case { name: "Groot–Warren, γ = 40.5", fluid: viscous, dt: 0.0025, time: 0.2 },
        Case { name: "ideal, γ = 40.5", fluid: Fluid::ideal(60, 40.5), dt: 0.002, time: 0.25 },
    ]
}

/// The noise that a step books correlates with what comes after it as twice the friction's stress would, with the sign turned:
/// so of the booked stress ⟨S D⟩ turns its sign, ⟨D S⟩ keeps it, and ⟨D D⟩ turns it and gains η_∞.
#[test]
fn the_noise_free_form_is_the_total_stress_part_by_part() {
    check_scores(|seed| {
        let mut scores = Vec::new();
        for (number, Case { name, fluid, dt, time }) in cases().into_iter().enumerate() {
            let volume = fluid.count() as f64 / fluid.density;
            let series = Series::record(&fluid, NoiseKey::new(&[seed, number as u64]), dt, 160_000);
            for (what, components) in [("shear", SHEAR), ("bulk", BULK)] {
                let blocks = series.blocks(&components, (time / dt).round() as usize, dt, volume);
                let part = |label: &str, value: &dyn Fn(&Parts) -> f64| {
                    let (mean, error) = estimate(&blocks, value);
                    println!("{name}, {what}: {label} {mean:.4}({error:.4})");
                    (mean, error)
                };
                let difference = |label: &str, value: &dyn Fn(&Parts) -> f64| {
                    let (mean, error) = part(label, value);
                    mean / error
                };
                part("instantaneous", &|parts| parts.instantaneous);
                let (even, _) = part("SS", &|parts| parts.state[0][0]);
                // Nothing but the quadrature differs, sample by sample: that is no question of statistics.
                let (off, _) = part("booked SS − SS", &|parts| parts.booked[0][0] - parts.state[0][0]);
                assert!(off.abs() < 1e-3 * even, "{name}, {what}: {off} of {even}");
                part("SD", &|parts| parts.state[0][1]);
                part("DS", &|parts| parts.state[1][0]);
                part("DD", &|parts| parts.state[1][1]);
                let (_, error) = part("noise-free", &Parts::noise_free);
                let (_, total_error) = part("total", &Parts::total);
                println!("{name}, {what}: ratio of variances {:.1}", (total_error / error).powi(2));
                // The sum of what follows: printed, but no score of its own.
                part("total − noise-free", &|parts| parts.total() - parts.noise_free());
                scores.extend([
                    difference("booked SD + SD", &|parts| parts.booked[0][1] + parts.state[0][1]),
                    difference("booked DS − DS", &|parts| parts.booked[1][0] - parts.state[1][0]),
                    difference("booked DD − (η∞ − DD)", &|parts| {
                        parts.booked[1][1] - (parts.instantaneous - parts.state[1][1])
                    }),
                    difference("SD + DS", &|parts| parts.state[0][1] + parts.state[1][0]),
                ]);
                // What mistakes would give: each must be far off.
                let wrong = [
                    difference("total − without η∞", &|parts| {
                        parts.total() - parts.noise_free() + parts.instantaneous
                    }),
                    difference("total − with +DD", &|parts| {
                        parts.total() - parts.noise_free() - 2.0 * parts.state[1][1]
                    }),
                    difference("total − with SD and DS exchanged", &|parts| {
                        parts.total() - parts.noise_free() + 2.0 * (parts.state[1][0] - parts.state[0][1])
                    }),
                ];
                println!("{name}, {what}: z of the wrong ones {wrong:.1?}");
                assert!(wrong[0].abs() > 6.0, "{name}, {what}: η∞ makes no difference");
                // In the ideal fluid ⟨D D⟩ is large and ⟨S D⟩ is hardly there; with a potential both tell, of the shear.
                assert!(components != SHEAR || wrong[1].abs() > 4.0, "{name}: the sign of DD makes no difference");
                let tells = number == 0 && components == SHEAR;
                assert!(!tells || wrong[2].abs() > 4.0, "{name}: the order of S and D makes no difference");
            }
        }
        scores
    });
}
