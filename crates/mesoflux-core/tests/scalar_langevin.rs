//! Langevin's equation of one variable whose kinetic coefficient changes tenfold over a double well: Boltzmann's density, with both
//! corrections and not without, and the order of their errors, worked out without noise.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

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

/// e^(−F/kT)/α: what noise in the sense of Itô leaves stationary without Λ.
fn without_correction(x: f64) -> f64 {
    boltzmann(x) / DoubleWell { corrected: false }.coefficient(x)
}

/// Nothing is beyond: F > 33 kT.
const REACH: f64 = 2.6;

/// Points between −REACH and REACH with the share of a density that lies below each.
fn distribution(density: fn(f64) -> f64) -> Vec<(f64, f64)> {
    let points = 20_000;
    let h = 2.0 * REACH / f64::from(points);
    let mut sum = 0.0;
    let mut table: Vec<(f64, f64)> = (0..=points)
        .map(|k| {
            let x = f64::from(k) * h - REACH;
            let below = sum + 0.5 * h * density(x);
            sum += h * density(x);
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

/// The p-values of 20 equally likely bins of two densities, after a time long enough to come from one well to the other, the
/// copies having begun with Boltzmann's density.
fn p_values(correction: Correction, corrected: bool, densities: [fn(f64) -> f64; 2]) -> [f64; 2] {
    let (copies, bins, time_step, steps) = (20_000, 20, 0.002, 2000);
    let noise = NoiseKey::new(&[3]);
    let dynamics = ScalarLangevin::new(DoubleWell { corrected }, 1.0, time_step, correction).unwrap();
    let start = noise.draw(Purpose::Start, 0, 0);
    let table = distribution(boltzmann);
    let mut x: Vec<f64> = (0..copies).map(|k| quantile(&table, start.uniform(k, 0))).collect();
    for step in 0..steps {
        dynamics.advance(&mut x, noise, step).unwrap();
    }
    densities.map(|density| {
        let table = distribution(density);
        let edges: Vec<f64> = (1..bins).map(|bin| quantile(&table, f64::from(bin) / f64::from(bins))).collect();
        let mut observed = vec![0.0; bins as usize];
        x.iter().for_each(|&x| observed[edges.partition_point(|&edge| edge < x)] += 1.0);
        chi_squared_p_value(&observed, &vec![copies as f64 / f64::from(bins); bins as usize], 1).unwrap()
    })
}

#[test]
fn boltzmanns_density_is_stationary_with_either_correction_and_not_without() {
    for correction in [Correction::Derivative, Correction::TwoStep] {
        let [right, wrong] = p_values(correction, true, [boltzmann, without_correction]);
        println!("{correction:?}: p = {right:.3}; {wrong:.1e} without Λ");
        assert!(right > 1e-3 && wrong < 1e-6);
    }
    let [right, wrong] = p_values(Correction::Derivative, false, [boltzmann, without_correction]);
    println!("uncorrected: p = {right:.1e}");
    assert!(right < 1e-6 && wrong < 1e-6, "on its way from one density to the other");
}

/// A scheme as an operator on functions of x: f ↦ ⟨f(x')⟩, by the trapezoidal rule over ξ and cubics between points.
struct Transitions {
    steps: Vec<Vec<(f64, f64)>>,
}

impl Transitions {
    const POINTS: usize = 417;
    const STEP: f64 = 2.0 * REACH / (Self::POINTS as f64 - 1.0);

    fn place(k: usize) -> f64 {
        k as f64 * Self::STEP - REACH
    }

    fn of(dynamics: &ScalarLangevin<DoubleWell>) -> Self {
        let (normals, spacing) = (56, 14.0 / 56.0);
        let step = |x: f64, n: usize| {
            let normal = n as f64 * spacing - 7.0;
            let weight = spacing * (-0.5 * normal * normal).exp() / std::f64::consts::TAU.sqrt();
            (dynamics.step(x, normal).unwrap(), weight)
        };
        let steps = |k: usize| (0..=normals).map(|n| step(Self::place(k), n)).collect();
        Self { steps: (0..Self::POINTS).map(steps).collect() }
    }

    /// f(x) by the cubic through four points.
    fn at(values: &[f64], x: f64) -> f64 {
        let s = ((x + REACH) / Self::STEP).clamp(0.0, Self::POINTS as f64 - 1.0);
        let k = (s as usize).clamp(1, Self::POINTS - 3);
        let t = s - k as f64;
        let [a, b, c, d] = [k - 1, k, k + 1, k + 2].map(|k| values[k]);
        -t * (t - 1.0) * (t - 2.0) / 6.0 * a + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * b
            - (t + 1.0) * t * (t - 2.0) / 2.0 * c
            + (t + 1.0) * t * (t - 1.0) / 6.0 * d
    }

    fn apply(&self, values: &[f64]) -> Vec<f64> {
        self.steps.iter().map(|steps| steps.iter().map(|&(x, weight)| weight * Self::at(values, x)).sum()).collect()
    }
}

/// ⟨x²⟩ after a time many relaxation times long, begun with Boltzmann's density, less Boltzmann's ⟨x²⟩.
fn error_of_the_second_moment(correction: Correction, corrected: bool, time_step: f64) -> f64 {
    let dynamics = ScalarLangevin::new(DoubleWell { corrected }, 1.0, time_step, correction).unwrap();
    let transitions = Transitions::of(&dynamics);
    let square: Vec<f64> = (0..Transitions::POINTS).map(|k| Transitions::place(k).powi(2)).collect();
    let steps = (16.0 / time_step).round() as usize;
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
