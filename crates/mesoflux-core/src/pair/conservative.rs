//! Conservative forces of all particles.

use super::contacts::CHUNK;
use super::scatter::Scatter;
use crate::domain::Workers;
use crate::interactions::Interactions;
use crate::neighbors::NeighborList;
use crate::vector::{Vector, ZERO, add_scaled};

/// −∇U for every particle: f_i = Σ_j f(r_ij) e_ij, f_ij = −f_ji.
pub fn conservative_forces(list: &NeighborList, interactions: &Interactions, force: &mut [Vector], workers: Workers) {
    force.fill(ZERO);
    let target = Scatter::new(force);
    list.sweep(false, workers, |brick| {
        let contacts = &brick.contacts;
        let mut magnitude = [0.0; CHUNK];
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
            for (k, &f) in chunk.clone().zip(&magnitude) {
                // SAFETY: inside a sweep.
                let (first, second) = unsafe { target.pair(contacts.first[k], contacts.second[k]) };
                add_scaled(first, f, contacts.direction[k]);
                add_scaled(second, -f, contacts.direction[k]);
            }
        }
    });
}
