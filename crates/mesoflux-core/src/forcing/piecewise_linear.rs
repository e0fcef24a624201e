//! A force that rises linearly over one half of the wave and falls over the other (Wu & Shang, section 4.2.2).

use super::ShearProfile;
use std::f64::consts::PI;

/// F(y) = 4y/L − 1 up to L/2, 3 − 4y/L beyond; F₁ = −4/π².
#[derive(Debug, Clone, Copy)]
pub struct PiecewiseLinear;

impl ShearProfile for PiecewiseLinear {
    fn force(phase: f64) -> f64 {
        if phase <= 0.5 { 4.0 * phase - 1.0 } else { 3.0 - 4.0 * phase }
    }

    const FIRST_COEFFICIENT: f64 = 4.0 / (PI * PI);
    // sin(x + 3π/2) = −cos x.
    const QUARTERS: u64 = 3;
}
