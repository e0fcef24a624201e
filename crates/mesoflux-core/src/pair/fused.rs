//! Conservative, dissipative and random forces in one pass, for integrators that treat them alike.

use super::contacts::Contacts;
use super::dissipation::{Dissipation, PairNoise};
use super::scatter::{BlockRows, Scatter};
use super::separations::Separations;
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row, scaled};
use crate::neighbors::{KindOfPair, NeighborList};
use crate::state::Particles;

/// F_i = Σ_j [f(r) − Γu + √(2ΓkT/Δt) ξ_ij + Λξ_ij²] e_ij with the given velocities (Groot & Warren 1997, eqs 3–8; Naseri et al.,
/// eqs 5–13).
///
/// Finds the contacts at the present positions brick by brick; `kind` as for `NeighborList::build`.
#[allow(clippy::too_many_arguments, reason = "a force needs them all")]
pub fn velocity_dependent_forces(
    list: &mut NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    kind: Option<&KindOfPair>,
    velocity: &[Row],
    noise: &PairNoise,
    force: &mut [Row],
    workers: Workers,
) {
    workers.for_each_chunk(force, |_, chunk| chunk.fill(Row::default()));
    let target = Scatter::new(force);
    let instructions = InstructionSet::detect();
    list.sweep_once(particles, kind, workers, |list, contacts| {
        let (region, points) = (list.region(), list.points());
        instructions.run(BrickForces { contacts, interactions, points, region, velocity, noise, target: &target });
    });
}

/// The pairs of one brick.
struct BrickForces<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    points: &'a [Row],
    region: &'a PeriodicBox,
    velocity: &'a [Row],
    noise: &'a PairNoise,
    target: &'a Scatter<'a>,
}

impl Kernel for BrickForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { contacts, interactions, points, region, velocity, noise, target } = self;
        target.check(contacts);
        let (mut pairs, mut dissipation) = (Separations::default(), Dissipation::new(interactions));
        let (mut conservative, mut rows) = (BlockNumbers::default(), BlockRows::default());
        for block in contacts.blocks(false) {
            pairs.update::<L>(contacts, &block, points, region);
            contacts.by_kind::<L, _>(&block, &interactions.potentials, &pairs.distance, &mut conservative);
            dissipation.update::<L>(contacts, &block, interactions, &pairs, velocity);
            dissipation.draw::<L>(&block, interactions, &pairs, noise);
            for s in 0..block.streams {
                let (strength, random) = (L::load(&dissipation.strength[s]), L::load(&dissipation.random[s]));
                let undamped = L::load(&conservative[s]) + random;
                let force = (-strength).mul_add(dissipation.radial(s), undamped);
                L::rows(scaled(force, pairs.direction(s)), &mut rows[s]);
            }
            target.add_opposite::<L>(&block, &pairs, &rows);
        }
    }
}
