//! Conservative forces of all particles.

use super::contacts::Contacts;
use super::scatter::{BlockRows, Scatter};
use super::separations::Separations;
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row, scaled};
use crate::neighbors::NeighborList;
use crate::{boundary::PeriodicBox, domain::Workers};

/// −∇U for every particle: f_i = Σ_j f(r_ij) e_ij, f_ij = −f_ji.
pub fn conservative_forces(list: &NeighborList, interactions: &Interactions, force: &mut [Row], workers: Workers) {
    workers.for_each_chunk(force, |_, chunk| chunk.fill(Row::default()));
    if interactions.potentials.entries().iter().all(Option::is_none) {
        return;
    }
    let (target, region, points) = (Scatter::new(force), list.region(), list.points());
    let instructions = InstructionSet::detect();
    list.sweep(false, workers, |contacts| {
        instructions.run(BrickForces { contacts, interactions, points, region, target: &target });
    });
}

/// The pairs of one brick.
struct BrickForces<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    points: &'a [Row],
    region: &'a PeriodicBox,
    target: &'a Scatter<'a>,
}

impl Kernel for BrickForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { contacts, interactions, points, region, target } = self;
        target.check(contacts);
        let mut pairs = Separations::default();
        let mut magnitude = BlockNumbers::default();
        let mut rows = BlockRows::default();
        for block in contacts.blocks(false) {
            pairs.update::<L>(contacts, &block, points, region);
            contacts.by_kind::<L, _>(&block, &interactions.potentials, &pairs.distance, &mut magnitude);
            for s in 0..block.streams {
                L::rows(scaled(L::load(&magnitude[s]), pairs.direction(s)), &mut rows[s]);
            }
            target.add_opposite::<L>(&block, &pairs, &rows);
        }
    }
}
