//! Langevin's equation of one variable whose kinetic coefficient changes tenfold over a double well: Boltzmann's density, with both
//! corrections and not without, and the order of their errors, worked out without noise.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{check_scores, probit};
use mesoflux_analysis::chi_squared_p_value;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::scalar_langevin::{ScalarLangevin, Variable};

/// F = (x² − 1)², α = 0.55 + 0.45 tanh 2x, at kT = 1.
#[derive(Clone, Copy)]
struct DoubleWell {
    /// Whether ∂α/∂x is told.
    corrected: bool,
}

impl Variable for DoubleWell {
    fn force(&self, x: f64) -> f64 {
        -4.0 * x * (x * x - 1.0)
    }

    fn coefficient(&self, x: f64) -> f64 {
        0.55 + 0.45 * (2.0 * x).tanh()
    }

    fn slope(&self, x: f64) -> f64 {
        if self.corrected { 0.9 / (2.0 * x).cosh().powi(2) } else { 0.0 }
    }
}

/// e^(−F/kT).
fn boltzmann(x: f64) -> f64 {
    (-(x * x - 1.0).powi(2)).exp()
}

/// Nothing is beyond: F > 33 kT.
const REACH: f64 = 2.6;

/// Points between −REACH and REACH with the share of Boltzmann's density that lies below each.
fn distribution() -> Vec<(f64, f64)> {
    let points = 20_000;
    let h = 2.0 * REACH / f64::from(points);
    let mut sum = 0.0;
    let mut table: Vec<(f64, f64)> = (0..=points)
        .map(|k| {
            let x = f64::from(k) * h - REACH;
            let below = sum + 0.5 * h * boltzmann(x);
            sum += h * boltzmann(x);
            (x, below)
        })
        .collect();
    table.iter_mut().for_each(|(_, below)| *below /= sum);
    table
}

/// x where a share of the density lies below.
fn quantile(table: &[(f64, f64)], share: f64) -> f64 {
    let k = table.partition_point(|&(_, below)| below < share).clamp(1, table.len() - 1);
    let [(x, a), (y, b)] = [table[k - 1], table[k]];
    x + (y - x) * ((share - a) / (b - a)).clamp(0.0, 1.0)
}

/// The p-value of Boltzmann's density over 20 equally likely bins, after a time long enough to come from one well to the other, the copies
/// having begun with it.
fn p_value(dynamics: &ScalarLangevin<DoubleWell>, noise: NoiseKey) -> f64 {
    let (copies, bins, time) = (10_000, 20, 3.0);
    let start = noise.draw(Purpose::Start, 0, 0);
    let table = distribution();
    let mut x: Vec<f64> = (0..copies).map(|k| quantile(&table, start.uniform(k, 0))).collect();
    for step in 0..(time / TIME_STEP).round() as u64 {
        dynamics.advance(&mut x, noise, step).unwrap();
    }
    let edges: Vec<f64> = (1..bins).map(|bin| quantile(&table, bin as f64 / bins as f64)).collect();
    let mut observed = vec![0.0; bins];
    x.iter().for_each(|&x| observed[edges.partition_point(|&edge| edge < x)] += 1.0);
    chi_squared_p_value(&observed, &vec![copies as f64 / bins as f64; bins], 1).unwrap()
}

/// The time step of the histograms.
const TIME_STEP: f64 = 0.002;

fn dynamics(correction: Correction, corrected: bool, time_step: f64) -> ScalarLangevin<DoubleWell> {
    ScalarLangevin::new(DoubleWell { corrected }, 1.0, time_step, correction).unwrap()
}

#[test]
fn boltzmanns_density_is_stationary_with_either_correction() {
    check_scores(|seed| {
        let p = |correction, index| {
            let dynamics = dynamics(correction, true, TIME_STEP);
            p_value(&dynamics, NoiseKey::new(&[seed, index]))
        };
        let found = [p(Correction::Derivative, 0), p(Correction::TwoStep, 1)];
        println!("p = {found:.4?}");
        found.map(probit).to_vec()
    });
}

#[test]
fn boltzmanns_density_is_lost_without_the_correction() {
    let uncorrected = dynamics(Correction::Derivative, false, TIME_STEP);
    let p = p_value(&uncorrected, NoiseKey::new(&[1, 2]));
    println!("p = {p:.1e}");
    assert!(p < 1e-6);
}

/// A scheme as an operator on functions of x, f ↦ ⟨f(x')⟩: a matrix over points, by the trapezoidal rule over ξ and cubics between
/// the points.
struct Transitions {
    rows: Vec<Vec<f64>>,
}

impl Transitions {
    const POINTS: usize = 417;
    const STEP: f64 = 2.0 * REACH / (Self::POINTS as f64 - 1.0);

    fn place(k: usize) -> f64 {
        k as f64 * Self::STEP - REACH
    }

    fn of(dynamics: &ScalarLangevin<DoubleWell>) -> Self {
        let (normals, spacing) = (56, 14.0 / 56.0);
        let row = |k: usize| {
            let mut row = vec![0.0; Self::POINTS];
            for n in 0..=normals {
                let normal = f64::from(n) * spacing - 7.0;
                let weight = spacing * (-0.5 * normal * normal).exp() / std::f64::consts::TAU.sqrt();
                Self::add_cubic(&mut row, dynamics.step(Self::place(k), normal).unwrap(), weight);
            }
            row
        };
        Self { rows: (0..Self::POINTS).map(row).collect() }
    }

    /// Adds the weights with which the four points around x make up f(x).
    fn add_cubic(row: &mut [f64], x: f64, weight: f64) {
        let s = ((x + REACH) / Self::STEP).clamp(0.0, Self::POINTS as f64 - 1.0);
        let k = (s as usize).clamp(1, Self::POINTS - 3);
        let t = s - k as f64;
        row[k - 1] -= weight * t * (t - 1.0) * (t - 2.0) / 6.0;
        row[k] += weight * (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0;
        row[k + 1] -= weight * (t + 1.0) * t * (t - 2.0) / 2.0;
        row[k + 2] += weight * (t + 1.0) * t * (t - 1.0) / 6.0;
    }

    fn apply(&self, values: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|row| row.iter().zip(values).map(|(weight, value)| weight * value).sum()).collect()
    }
}

/// ⟨x²⟩ after a time of some relaxation times, begun with Boltzmann's density, less Boltzmann's ⟨x²⟩.
fn error_of_the_second_moment(correction: Correction, corrected: bool, time_step: f64) -> f64 {
    let transitions = Transitions::of(&dynamics(correction, corrected, time_step));
    let square: Vec<f64> = (0..Transitions::POINTS).map(|k| Transitions::place(k).powi(2)).collect();
    let steps = (10.0 / time_step).round() as usize;
    let after = (0..steps).fold(square.clone(), |values, _| transitions.apply(&values));
    let mean = |values: &[f64]| {
        let weights = (0..Transitions::POINTS).map(|k| boltzmann(Transitions::place(k)));
        weights.clone().zip(values).map(|(weight, value)| weight * value).sum::<f64>() / weights.sum::<f64>()
    };
    mean(&after) - mean(&square)
}

/// Halving the time step halves the error of the stationary ⟨x²⟩, of both; without Λ it stays.
#[test]
fn errors_of_averages_are_of_first_order() {
    let steps = [0.02, 0.01, 0.005];
    for correction in [Correction::Derivative, Correction::TwoStep] {
        let errors = steps.map(|step| error_of_the_second_moment(correction, true, step));
        println!("{correction:?}: {errors:?}");
        assert!(errors[0].abs() > 1e-4, "too small to tell");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).abs().log2();
            assert!(order > 0.9, "order {order}");
        }
    }
    let uncorrected = error_of_the_second_moment(Correction::Derivative, false, 0.01);
    println!("uncorrected: {uncorrected}");
    assert!(uncorrected.abs() > 0.05);
}
