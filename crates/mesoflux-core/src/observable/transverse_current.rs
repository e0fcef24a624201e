//! Transverse momentum currents: what a shear wave of the fluid is made of.

use crate::elementary::cos_two_pi;
use crate::system::System;

/// The flow and the gradient axis of each of the six transverse currents.
pub const TRANSVERSE: [[usize; 2]; 6] = [[0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1]];

/// j_a(k) = Σ_i p_a exp(i k r_b) with k = 2πn/L_b and b ≠ a, real and imaginary part.
///
/// In equilibrium, with a total momentum fixed at zero, ⟨|j|²⟩ = kT (M − ⟨|Σ_i m_i exp(i k r_b)|²⟩/M) with M = Σ_i m_i. For small k its
/// correlations decay as exp(−η k² t/ρ_m), ρ_m being the density of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct TransverseCurrents {
    /// For each n from 1 on, the currents of each pair of axes in `TRANSVERSE`.
    pub waves: Vec<[[f64; 2]; 6]>,
}

impl TransverseCurrents {
    /// Reads the currents of the smallest `count` wave numbers along each axis.
    pub fn of(system: &System, count: usize) -> Self {
        let (particles, sides) = (&system.particles, system.region.sides());
        let mut waves = vec![[[0.0; 2]; 6]; count];
        for (position, momentum) in particles.position.iter().zip(&particles.momentum) {
            let first: [[f64; 2]; 3] = std::array::from_fn(|axis| {
                let turns = position[axis] / sides[axis];
                // cos(x − π/2) = sin(x)
                [turns, turns - 0.25].map(|turns| cos_two_pi(turns - turns.floor()))
            });
            let mut phase = first;
            for wave in &mut waves {
                for (current, [a, b]) in wave.iter_mut().zip(TRANSVERSE) {
                    current[0] += momentum[a] * phase[b][0];
                    current[1] += momentum[a] * phase[b][1];
                }
                for (phase, [cos, sin]) in phase.iter_mut().zip(first) {
                    *phase = [phase[0] * cos - phase[1] * sin, phase[0] * sin + phase[1] * cos];
                }
            }
        }
        Self { waves }
    }
}
