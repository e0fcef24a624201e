//! A constant force one way over one half of the wave, the other way over the other half (Wu & Shang, section 4.2.2).

use super::ShearProfile;
use std::f64::consts::FRAC_2_PI;

/// F(y) = 1 up to L/2, −1 beyond; F₁ = 2i/π.
#[derive(Debug, Clone, Copy)]
pub struct PiecewiseConstant;

impl ShearProfile for PiecewiseConstant {
    fn force(phase: f64) -> f64 {
        if phase <= 0.5 { 1.0 } else { -1.0 }
    }

    const FIRST_COEFFICIENT: f64 = FRAC_2_PI;
    const QUARTERS: u64 = 0;
}
