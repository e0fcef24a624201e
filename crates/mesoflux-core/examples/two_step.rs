//! A double well in which the mobility changes tenfold: the stationary density by the derivative of the mobility, by two steps with
//! the same random number, and without a correction, against Boltzmann's.
//!
//! ```text
//! cargo run --release -p mesoflux-core --example two_step
//! ```

use mesoflux_analysis::chi_squared_p_value;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::scalar_langevin::{ScalarLangevin, Variable};

/// F = (x² − 1)², α = 0.55 + 0.45 tanh 2x: 0.1 far to the left, 1 far to the right.
#[derive(Clone, Copy)]
struct DoubleWell {
    /// Whether ∂α/∂x is told; without, the noise is left uncorrected.
    corrected: bool,
}

impl DoubleWell {
    fn free_energy(x: f64) -> f64 {
        (x * x - 1.0).powi(2)
    }
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

const TEMPERATURE: f64 = 1.0;
const TIME_STEP: f64 = 0.002;
/// Some four times what it takes to come from one well to the other.
const TIME: f64 = 12.0;
const COPIES: usize = 5_000;
const BINS: usize = 24;
/// Half the range of the bins.
const REACH: f64 = 2.4;

/// What falls into each bin of all copies, if `density` is that of x up to a factor.
fn expected(density: impl Fn(f64) -> f64) -> Vec<f64> {
    let points = 200;
    let width = 2.0 * REACH / BINS as f64;
    let weight = |bin: usize| -> f64 {
        let place = |k: usize| (bin as f64 + (k as f64 + 0.5) / points as f64) * width - REACH;
        (0..points).map(|k| density(place(k))).sum()
    };
    let weights: Vec<f64> = (0..BINS).map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / total * COPIES as f64).collect()
}

/// Where the copies are after the whole time, all of them having begun in the left well.
fn histogram(correction: Correction, corrected: bool) -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    let dynamics = ScalarLangevin::new(DoubleWell { corrected }, TEMPERATURE, TIME_STEP, correction)?;
    let mut copies = vec![-1.0; COPIES];
    for step in 0..(TIME / TIME_STEP).round() as u64 {
        dynamics.advance(&mut copies, NoiseKey::new(&[1]), step)?;
    }
    let mut counts = vec![0.0; BINS];
    for x in copies {
        let bin = ((x + REACH) / (2.0 * REACH) * BINS as f64).clamp(0.0, BINS as f64 - 1.0);
        counts[bin as usize] += 1.0;
    }
    Ok(counts)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let boltzmann = expected(|x| (-DoubleWell::free_energy(x) / TEMPERATURE).exp());
    let schemes = [
        ("by the derivative", Correction::Derivative, true),
        ("by two steps", Correction::TwoStep, true),
        ("uncorrected", Correction::Derivative, false),
    ];
    let found = schemes
        .iter()
        .map(|&(_, correction, corrected)| histogram(correction, corrected))
        .collect::<Result<Vec<_>, _>>()?;
    println!("{:>6} {:>10} {:>18} {:>14} {:>12}", "x", "Boltzmann", schemes[0].0, schemes[1].0, schemes[2].0);
    for bin in 0..BINS {
        let x = (bin as f64 + 0.5) * 2.0 * REACH / BINS as f64 - REACH;
        let [derivative, two_step, uncorrected] = [0, 1, 2].map(|scheme: usize| found[scheme][bin]);
        println!("{x:>6.1} {:>10.1} {derivative:>18} {two_step:>14} {uncorrected:>12}", boltzmann[bin]);
    }
    for ((name, ..), counts) in schemes.iter().zip(&found) {
        let squared: f64 =
            counts.iter().zip(&boltzmann).map(|(found, expected)| (found - expected).powi(2) / expected).sum();
        println!("{name}: χ² = {squared:.1} over {BINS} bins, p = {:.3e}", chi_squared_p_value(counts, &boltzmann, 1)?);
    }
    // Itô's noise without Λ has the stationary density e^(−F/kT)/α.
    let wrong = expected(|x| {
        (-DoubleWell::free_energy(x) / TEMPERATURE).exp() / DoubleWell { corrected: false }.coefficient(x)
    });
    println!("uncorrected against e^(−F/kT)/α: p = {:.3e}", chi_squared_p_value(&found[2], &wrong, 1)?);
    Ok(())
}
