//! Conservative, dissipative and random forces in one pass, for integrators that treat them alike.

use super::contacts::{CHUNK, Contacts};
use super::instruction_set::{InstructionSet, Kernel};
use super::scatter::Scatter;
use crate::domain::Workers;
use crate::friction::fluctuation_dissipation::random_force_amplitude;
use crate::interactions::Interactions;
use crate::neighbors::NeighborList;
use crate::noise::Draw;
use crate::state::Particles;
use crate::vector::{Vector, ZERO, dot, subtract};

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
    let instructions = InstructionSet::detect();
    list.sweep(false, workers, |brick| {
        let contacts = &brick.contacts;
        instructions.run(BrickForces { contacts, interactions, id: &particles.id, velocity, noise, target: &target });
    });
}

/// The pairs of one brick.
struct BrickForces<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    id: &'a [u64],
    velocity: &'a [Vector],
    noise: &'a PairNoise,
    target: &'a Scatter<'a, Vector>,
}

impl Kernel for BrickForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { contacts, interactions, id, velocity, noise, target } = self;
        let (mut magnitude, mut strength) = ([0.0; CHUNK], [0.0; CHUNK]);
        for chunk in contacts.chunks(false) {
            contacts.forces(&interactions.potentials, &chunk, &mut magnitude);
            contacts.strengths(&interactions.frictions, &chunk, &mut strength);
            let (first, second) = (&contacts.first[chunk.clone()], &contacts.second[chunk.clone()]);
            let gaussians: [f64; CHUNK] = noise.draw.pair_gaussians(id, first, second);
            for n in 0..chunk.len() {
                magnitude[n] += random_force_amplitude(strength[n], noise.temperature, noise.time_step) * gaussians[n];
            }
            for (n, &e) in contacts.direction[chunk.clone()].iter().enumerate() {
                let v_ij = subtract(velocity[first[n] as usize], velocity[second[n] as usize]);
                magnitude[n] -= strength[n] * dot(e, v_ij);
            }
            target.add_opposite(contacts, &chunk, &magnitude);
        }
    }
}
