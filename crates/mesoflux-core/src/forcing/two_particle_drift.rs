//! Two-particle drift: the first particle pushed along x, the second against it (Wu & Shang, eq. 76).

use super::{Forcing, ForcingError};
use crate::state::Particles;
use crate::vector::Vector;

/// F_0 = e_x/√2, F_1 = −e_x/√2 by id, G = M⁻¹F.
///
/// Holding the relative velocity of two particles is no bulk flux: under constant flux its mobility need not agree with βD.
#[derive(Debug, Clone, Copy)]
pub struct TwoParticleDrift;

impl Forcing for TwoParticleDrift {
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2] {
        let magnitude = std::f64::consts::FRAC_1_SQRT_2;
        let force = [magnitude, -magnitude].get(particles.id[k] as usize).copied().unwrap_or(0.0);
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
        Ok(())
    }
}
