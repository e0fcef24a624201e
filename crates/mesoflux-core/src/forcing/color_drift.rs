//! Color drift: one half of the particles pushed along x, the other half against it (Wu & Shang, eq. 77).

use super::{Forcing, ForcingError};
use crate::state::Particles;
use crate::vector::Vector;

/// F_i = (−1)^i e_x/√N by the parity of the id, G = M⁻¹F: R is the color current, |F| = 1, and the forces sum to zero.
#[derive(Debug, Clone, Copy)]
pub struct ColorDrift;

impl Forcing for ColorDrift {
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2] {
        let magnitude = 1.0 / (particles.count() as f64).sqrt();
        let force = if particles.id[k].is_multiple_of(2) { magnitude } else { -magnitude };
        [[force, 0.0, 0.0], [force * particles.inverse_mass[k], 0.0, 0.0]]
    }

    fn depends_on_positions(&self) -> bool {
        false
    }

    fn is_balanced(&self) -> bool {
        true
    }

    fn check(&self, particles: usize) -> Result<(), ForcingError> {
        if particles < 2 {
            return Err(ForcingError::TooFewParticles { needed: 2, found: particles });
        }
        if particles % 2 == 1 {
            return Err(ForcingError::OddParticles(particles));
        }
        Ok(())
    }
}
