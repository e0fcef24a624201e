//! Conservative, dissipative and random forces in one pass, for integrators that treat them alike.

use super::contacts::CHUNK;
use super::scatter::Scatter;
use crate::domain::Workers;
use crate::friction::fluctuation_dissipation::random_force_amplitude;
use crate::interactions::Interactions;
use crate::neighbors::NeighborList;
use crate::noise::Draw;
use crate::state::Particles;
use crate::vector::{Vector, ZERO, add_scaled, dot, subtract};

/// The noise of one force evaluation.
#[derive(Debug, Clone, Copy)]
pub struct PairNoise {
    /// kT.
    pub temperature: f64,
    /// Δt, over which the random force is constant.
    pub time_step: f64,
    /// The random numbers.
    pub draw: Draw,
}

/// F_i = Σ_j [f(r) − Γ(r) e·(v_i − v_j) + √(2ΓkT/Δt) ξ_ij] e_ij with the given velocities (Groot & Warren 1997, eqs 3–8).
pub fn velocity_dependent_forces(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    velocity: &[Vector],
    noise: &PairNoise,
    force: &mut [Vector],
    workers: Workers,
) {
    force.fill(ZERO);
    let target = Scatter::new(force);
    list.sweep(false, workers, |brick| {
        let contacts = &brick.contacts;
        let (mut magnitude, mut strength) = ([0.0; CHUNK], [0.0; CHUNK]);
        for chunk in contacts.chunks(false) {
            contacts.add_by_kind(
                &interactions.potentials,
                &chunk,
                &mut magnitude,
                |law, r, kinds, column| match kinds {
                    None => law.add_forces(r, |_| true, column),
                    Some((kinds, kind)) => law.add_forces(r, |k| kinds[k] == kind, column),
                },
            );
            contacts.add_by_kind(
                &interactions.frictions,
                &chunk,
                &mut strength,
                |law, r, kinds, column| match kinds {
                    None => law.add_strengths(r, |_| true, column),
                    Some((kinds, kind)) => law.add_strengths(r, |k| kinds[k] == kind, column),
                },
            );
            for (n, k) in chunk.clone().enumerate() {
                let (i, j) = (contacts.first[k] as usize, contacts.second[k] as usize);
                let random = random_force_amplitude(strength[n], noise.temperature, noise.time_step);
                magnitude[n] += random * noise.draw.pair_gaussian(particles.id[i], particles.id[j]);
                magnitude[n] -= strength[n] * dot(contacts.direction[k], subtract(velocity[i], velocity[j]));
            }
            for (k, &f) in chunk.clone().zip(&magnitude) {
                // SAFETY: inside a sweep.
                let (first, second) = unsafe { target.pair(contacts.first[k], contacts.second[k]) };
                add_scaled(first, f, contacts.direction[k]);
                add_scaled(second, -f, contacts.direction[k]);
            }
        }
    });
}
