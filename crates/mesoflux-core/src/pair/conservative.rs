//! Conservative forces of all particles.

use super::contacts::{CHUNK, Contacts};
use super::instruction_set::{InstructionSet, Kernel};
use super::scatter::Scatter;
use crate::domain::Workers;
use crate::interactions::Interactions;
use crate::neighbors::NeighborList;
use crate::vector::{Vector, ZERO};

/// −∇U for every particle: f_i = Σ_j f(r_ij) e_ij, f_ij = −f_ji.
pub fn conservative_forces(list: &NeighborList, interactions: &Interactions, force: &mut [Vector], workers: Workers) {
    force.fill(ZERO);
    let target = Scatter::new(force);
    let instructions = InstructionSet::detect();
    list.sweep(false, workers, |brick| {
        instructions.run(BrickForces { contacts: &brick.contacts, interactions, target: &target });
    });
}

/// The pairs of one brick.
struct BrickForces<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    target: &'a Scatter<'a, Vector>,
}

impl Kernel for BrickForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { contacts, interactions, target } = self;
        let mut magnitude = [0.0; CHUNK];
        for chunk in contacts.chunks(false) {
            contacts.forces(&interactions.potentials, &chunk, &mut magnitude);
            target.add_opposite(contacts, &chunk, &magnitude);
        }
    }
}
