//! The instantaneous stress, its parts apart, as the noise-free Green–Kubo formulas need it.

use crate::system::System;
use crate::tensor::SymmetricTensor;
use serde::{Deserialize, Serialize};

/// The momentum flux of one state, J_ab = Σ_i p_a p_b/m + Σ_pairs r F e_a e_b for a force F e on the first particle of a pair.
///
/// Extensive: V times the stress. Its sign is that of Wu & Shang's eq. 81b: a pressure is positive, and a flow u_x(y) makes
/// ⟨J_xy⟩ = −ηV ∂u_x/∂y. Bonds are part of the conservative stress. A driving force is no force of a pair: it has none.
///
/// The momenta count in the frame where the coordinates are: with a total momentum that isn't zero, J_K has a constant that
/// belongs to no correlation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Stress {
    /// J_K = Σ_i p_a p_b/m.
    pub kinetic: SymmetricTensor,
    /// J_C = Σ r f(r) e_a e_b over pairs and bonds.
    pub conservative: SymmetricTensor,
    /// J_D = Σ_pairs r (−Γ u) e_a e_b with u = e·v_ij: the friction's expected force.
    pub dissipative: SymmetricTensor,
    /// Σ_pairs Γ r² e_a² e_b²: what the random forces contribute at once.
    pub friction: SymmetricTensor,
}

/// The momentum flux that a time step made, divided by Δt: what the letters did, not what a state makes expect.
///
/// Free flight carries Σ p_a p_b/m, an impulse ΔP e of a pair r ΔP e_a e_b. The sum of the four parts, times Δt, is to rounding
/// what the step changed Σ_i x_a p_b by, where no pair looks across the faces of the box. Impulses of a driving are left out: they are no
/// forces of pairs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BookedStress {
    /// Of free flight.
    pub kinetic: SymmetricTensor,
    /// Of conservative forces, bonds with them.
    pub conservative: SymmetricTensor,
    /// Of the friction: the impulses expected given the state just before each pair was visited.
    pub dissipative: SymmetricTensor,
    /// Of the noise: the rest of these impulses, a martingale.
    pub random: SymmetricTensor,
}

impl BookedStress {
    /// The sum of all parts.
    pub fn total(&self) -> SymmetricTensor {
        self.kinetic + self.conservative + self.dissipative + self.random
    }

    /// Every part multiplied.
    #[must_use]
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            kinetic: factor * self.kinetic,
            conservative: factor * self.conservative,
            dissipative: factor * self.dissipative,
            random: factor * self.random,
        }
    }
}

impl Stress {
    /// Reads a system at its present positions and momenta.
    pub fn of(system: &mut System) -> Self {
        let pairs = system.pair_stress();
        Self {
            kinetic: system.particles.kinetic_stress(system.workers),
            conservative: pairs.conservative,
            dissipative: pairs.dissipative,
            friction: pairs.friction,
        }
    }

    /// J₊ = J_K + J_C + J_D: the momentum flux expected of the time that comes, given the state.
    pub fn forward(&self) -> SymmetricTensor {
        self.kinetic + self.conservative + self.dissipative
    }

    /// J₋ = J_K + J_C − J_D: the momentum flux expected of the time that has gone, given the state.
    pub fn backward(&self) -> SymmetricTensor {
        self.kinetic + self.conservative - self.dissipative
    }

    /// V η_∞ for each of the five components of `SymmetricTensor::shear`: Σ_pairs Γ r² T² with T = e_x e_y, e_x e_z, e_y e_z,
    /// (e_x² − e_y²)/2, (e_x² + e_y² − 2e_z²)/(2√3). The mean of the five is Σ_pairs Γ r²/15.
    pub fn instantaneous_shear(&self) -> [f64; 5] {
        let [xx, yy, zz, xy, xz, yz] = self.friction.0;
        [xy, xz, yz, (xx + yy - 2.0 * xy) / 4.0, (xx + yy + 4.0 * zz + 2.0 * xy - 4.0 * (xz + yz)) / 12.0]
    }

    /// V ζ_∞ = Σ_pairs Γ r²/9.
    pub fn instantaneous_bulk(&self) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.friction.0;
        (xx + yy + zz + 2.0 * (xy + xz + yz)) / 9.0
    }
}
