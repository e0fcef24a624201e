//! Conservative, dissipative and random forces in one pass, for integrators that treat them alike.

use super::contacts::Contacts;
use super::scatter::{BlockRows, Scatter};
use super::separations::Separations;
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::friction::fluctuation_dissipation::random_force_variance;
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row, inner_product, scaled};
use crate::neighbors::{KindOfPair, NeighborList};
use crate::noise::Draw;
use crate::state::Particles;

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
        assert!(contacts.places_below() <= velocity.len(), "contacts of other particles");
        target.check(contacts);
        let (mut pairs, mut normals) = (Separations::default(), BlockNumbers::default());
        let (mut conservative, mut strength) = (BlockNumbers::default(), BlockNumbers::default());
        let mut rows = BlockRows::default();
        for block in contacts.blocks(false) {
            pairs.update::<L>(contacts, &block, points, region);
            contacts.by_kind::<L, _>(&block, &interactions.potentials, &pairs.distance, &mut conservative);
            contacts.by_kind::<L, _>(&block, &interactions.frictions, &pairs.distance, &mut strength);
            noise.draw.pair_normals::<L>(block.streams, &pairs.ids, &mut normals);
            for s in 0..block.streams {
                let [first, second] = contacts.places(block.stream(s));
                // SAFETY: all places of the contacts are below the number of velocities.
                let (v_i, v_j) = unsafe { (L::load_rows(velocity, first), L::load_rows(velocity, second)) };
                let e = pairs.direction(s);
                let u = inner_product(e, [v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]]);
                let strength = L::load(&strength[s]);
                let variance = random_force_variance(strength, noise.temperature, noise.time_step);
                let random = variance.sqrt() * L::load(&normals[s]);
                let force = (-strength).mul_add(u, L::load(&conservative[s]) + random);
                L::rows(scaled(force, e), &mut rows[s]);
            }
            target.add_opposite::<L>(&block, &pairs, &rows);
        }
    }
}
