//! The sequential sweep of the pair thermostat: an exact Ornstein–Uhlenbeck update of one pair after the other.

use super::contacts::{Block, Contacts};
use super::scatter::{BlockRows, Scatter};
use super::separations::Separations;
use super::stress::TensorLanes;
use super::velocity_dependent_thermostat::VelocityDependentSweep;
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::friction::Dependence;
use crate::friction::fluctuation_dissipation::ornstein_uhlenbeck;
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row, RowLanes, WIDTH, inner_product};
use crate::neighbors::NeighborList;
use crate::noise::Draw;
use crate::state::Particles;
use crate::tensor::SymmetricTensor;
use std::ops::Add;

/// What a sweep does, beside the state it acts on.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// kT.
    pub temperature: f64,
    /// The time over which the pairs are thermalized.
    pub time: f64,
    /// The noise of this sweep.
    pub noise: Draw,
    /// The random numbers of its Metropolis tests, where friction depends on the radial velocity.
    pub acceptance: Draw,
    /// From the last pair to the first.
    pub backward: bool,
    /// G of every particle, in storage order, where the flux G·p is to be followed.
    pub response: Option<&'a [Row]>,
    /// Whether the stress of the impulses is to be summed.
    pub book_stress: bool,
}

/// What a sweep did, as far as it was asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SweepSums {
    /// The expected change of the flux G·p, Σ_pairs μ Δv^D e·(G_i − G_j).
    pub flux: f64,
    /// Σ_pairs r μ Δv^D e_a e_b: the expected impulses.
    pub dissipative: SymmetricTensor,
    /// Σ_pairs r μ Δv^R e_a e_b: those of the noise.
    pub random: SymmetricTensor,
}

impl Add for SweepSums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            flux: self.flux + other.flux,
            dissipative: self.dissipative + other.dissipative,
            random: self.random + other.random,
        }
    }
}

/// Updates every pair with friction in turn: p_i += μ (Δv^D + Δv^R) e, p_j −= the same (Wu & Shang, eqs 27–29, 58–61); where friction
/// depends on velocity see `velocity_dependent_thermostat`.
///
/// Works on rows of velocities, which the caller took from the momenta and takes back to them.
/// Each term of the expected sums is given the state just before its pair is visited. What remains of a change is the martingale
/// of the noise.
pub fn thermostat_sweep(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    velocity: &mut [Row],
    sweep: &Sweep,
    workers: Workers,
) -> SweepSums {
    let (velocity, region, points) = (Scatter::new(velocity), list.region(), list.points());
    let instructions = InstructionSet::detect();
    let dependence = interactions.friction_dependence();
    let parts = list.sweep(sweep.backward, workers, |contacts| {
        let brick = BrickSweep { contacts, interactions, particles, region, sweep, velocity: &velocity, points };
        match dependence {
            Dependence::Distance => instructions.run(brick),
            Dependence::Transverse => instructions.run(VelocityDependentSweep::<false>(brick)),
            Dependence::Radial => instructions.run(VelocityDependentSweep::<true>(brick)),
        }
    });
    parts.into_iter().fold(SweepSums::default(), SweepSums::add)
}

/// The pairs of one brick.
pub(super) struct BrickSweep<'a> {
    pub contacts: &'a Contacts,
    pub interactions: &'a Interactions,
    pub particles: &'a Particles,
    pub region: &'a PeriodicBox,
    pub sweep: &'a Sweep<'a>,
    pub velocity: &'a Scatter<'a>,
    pub points: &'a [Row],
}

/// What the update of each contact of a block needs; none of it depends on velocities.
#[derive(Default)]
struct Updates {
    pairs: Separations,
    strength: BlockNumbers,
    normals: BlockNumbers,
    direction: BlockRows,
    decay: BlockNumbers,
    random: BlockNumbers,
    /// μ/m of each of the two particles.
    shares: [BlockNumbers; 2],
    /// μ e·(G_i − G_j) times the decay: what the flux is expected to change by, for each unit of u.
    flux: BlockNumbers,
    /// r times the impulse that goes with a unit of change.
    arm: BlockNumbers,
}

/// Entries in an order, and for each the streams in an order: loops, not closures, to stay part of the kernel.
macro_rules! visit {
    ($entries:expr, $streams:expr, |$s:ident, $k:ident| $body:expr) => {
        for $k in $entries {
            for $s in $streams {
                $body;
            }
        }
    };
}

impl Updates {
    /// The update of one contact; keeps u where flux or stress are followed.
    #[inline(always)]
    fn apply<L: Lanes, const FOLLOW: bool, const EQUAL: bool>(
        &self,
        velocity: &Scatter,
        s: usize,
        k: usize,
        relative: &mut BlockNumbers,
    ) {
        // SAFETY: the places were checked, and inside a sweep no other thread uses them.
        unsafe {
            let [v_i, v_j] = velocity.pair([self.pairs.places[0][s][k], self.pairs.places[1][s][k]]);
            let (mine, theirs) = (L::Row::load(v_i), L::Row::load(v_j));
            let e = L::Row::load(&raw const self.direction[s][k]);
            let u = mine.subtract(theirs).dot(e);
            if FOLLOW {
                relative[s][k] = u;
            }
            let change = self.decay[s][k].mul_add(u, self.random[s][k]);
            // Of equal masses each takes half, which decay and random part hold already.
            let [share_i, share_j] = if EQUAL { [1.0; 2] } else { [self.shares[0][s][k], self.shares[1][s][k]] };
            mine.add_scaled(change * share_i, e).store(v_i);
            theirs.add_scaled(-change * share_j, e).store(v_j);
        }
    }
}

impl Kernel for BrickSweep<'_> {
    type Output = SweepSums;

    #[inline(always)]
    fn run<L: Lanes>(self) -> SweepSums {
        match (self.sweep.response.is_some() || self.sweep.book_stress, self.interactions.single_kind()) {
            (true, true) => self.sweep::<L, true, true>(),
            (true, false) => self.sweep::<L, true, false>(),
            (false, true) => self.sweep::<L, false, true>(),
            (false, false) => self.sweep::<L, false, false>(),
        }
    }
}

impl BrickSweep<'_> {
    /// The sweep, with or without flux and stress, of equal particles or others.
    #[inline(always)]
    fn sweep<L: Lanes, const FOLLOW: bool, const EQUAL: bool>(&self) -> SweepSums {
        let Self { contacts, sweep, velocity, .. } = self;
        velocity.check(contacts);
        let mut updates = Updates::default();
        let mut u = BlockNumbers::default();
        let mut expected = L::splat(0.0);
        let (mut dissipative, mut random) = (TensorLanes::<L>::zero(), TensorLanes::<L>::zero());
        for block in contacts.blocks(sweep.backward) {
            self.prepare::<L, EQUAL>(&block, &mut updates);
            let (depth, streams) = (block.depth.min(WIDTH), block.streams.min(WIDTH));
            match (streams == WIDTH, sweep.backward) {
                (true, false) => {
                    visit!(0..depth, 0..WIDTH, |s, k| updates.apply::<L, FOLLOW, EQUAL>(velocity, s, k, &mut u))
                }
                (true, true) => {
                    visit!((0..depth).rev(), (0..WIDTH).rev(), |s, k| updates
                        .apply::<L, FOLLOW, EQUAL>(velocity, s, k, &mut u));
                }
                (false, false) => {
                    visit!(0..depth, 0..streams, |s, k| updates.apply::<L, FOLLOW, EQUAL>(velocity, s, k, &mut u))
                }
                (false, true) => {
                    visit!((0..depth).rev(), (0..streams).rev(), |s, k| updates
                        .apply::<L, FOLLOW, EQUAL>(velocity, s, k, &mut u));
                }
            }
            if FOLLOW {
                for s in 0..block.streams {
                    u[s][block.depth..].fill(0.0);
                    expected = L::load(&u[s]).mul_add(L::load(&updates.flux[s]), expected);
                    if sweep.book_stress {
                        updates.arm[s][block.depth..].fill(0.0);
                        let (arm, direction) =
                            (L::load(&updates.arm[s]), TensorLanes::square(updates.pairs.direction(s)));
                        dissipative.add_scaled(arm * L::load(&updates.decay[s]) * L::load(&u[s]), &direction);
                        random.add_scaled(arm * L::load(&updates.random[s]), &direction);
                    }
                }
            }
        }
        SweepSums { flux: expected.sum(), dissipative: dissipative.sum(), random: random.sum() }
    }

    /// What the updates of a block's contacts need.
    #[inline(always)]
    fn prepare<L: Lanes, const EQUAL: bool>(&self, block: &Block, updates: &mut Updates) {
        let Self { contacts, interactions, particles, sweep, .. } = self;
        let Updates { pairs, strength, normals, direction, decay, random, shares, flux, arm } = updates;
        pairs.update::<L>(contacts, block, self.points, self.region);
        contacts.by_kind::<L, _>(block, &interactions.frictions, &pairs.distance, strength);
        sweep.noise.pair_normals::<L>(block.streams, &pairs.ids, normals);
        let equal = interactions.inverse_reduced_masses.entries()[0];
        for s in 0..block.streams {
            let [first, second] = contacts.places(block.stream(s));
            let (strength, normal) = (L::load(&strength[s]), L::load(&normals[s]));
            let (update, reduced_mass) = if EQUAL {
                let update = ornstein_uhlenbeck(strength, L::splat(equal), sweep.temperature, sweep.time);
                let half = L::splat(0.5);
                (half * update.variance.sqrt() * normal).store(&mut random[s]);
                (half * update.decay).store(&mut decay[s]);
                (update, L::splat(1.0 / equal))
            } else {
                let (w_i, w_j) =
                    (L::gather(&particles.inverse_mass, first), L::gather(&particles.inverse_mass, second));
                let update = ornstein_uhlenbeck(strength, w_i + w_j, sweep.temperature, sweep.time);
                (update.variance.sqrt() * normal).store(&mut random[s]);
                update.decay.store(&mut decay[s]);
                let reduced_mass = L::splat(1.0) / (w_i + w_j);
                (w_i * reduced_mass).store(&mut shares[0][s]);
                (w_j * reduced_mass).store(&mut shares[1][s]);
                (update, reduced_mass)
            };
            // Of equal masses decay and random part hold half of each change already.
            let whole = if EQUAL { reduced_mass + reduced_mass } else { reduced_mass };
            (L::load(&pairs.distance[s]) * whole).store(&mut arm[s]);
            let e = pairs.direction(s);
            L::rows(e, &mut direction[s]);
            if let Some(response) = sweep.response {
                assert!(contacts.places_below() <= response.len(), "contacts of other particles");
                // SAFETY: all places of the contacts are below the number of responses.
                let (g_i, g_j) =
                    unsafe { (L::load_rows(response.as_ptr(), first), L::load_rows(response.as_ptr(), second)) };
                let g = inner_product(e, [g_i[0] - g_j[0], g_i[1] - g_j[1], g_i[2] - g_j[2]]);
                (reduced_mass * update.decay * g).store(&mut flux[s]);
            }
        }
    }
}
