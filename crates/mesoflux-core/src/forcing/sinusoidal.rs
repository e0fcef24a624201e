//! A force that follows one period of a sine (Wu & Shang, section 4.2.2).

use super::ShearProfile;
use crate::elementary::sine_ahead;
use std::f64::consts::TAU;

/// F(y) = sin(2πy/L), F₁ = i/2.
#[derive(Debug, Clone, Copy)]
pub struct Sinusoidal;

impl ShearProfile for Sinusoidal {
    fn force(phase: f64) -> f64 {
        sine_ahead(TAU * phase, 0)
    }

    const FIRST_COEFFICIENT: f64 = 0.5;
    const QUARTERS: u64 = 0;
}
