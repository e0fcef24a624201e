//! The sweep of the pair thermostat where friction depends on velocity: one pair after the other, those together that can be.

use super::contacts::{Block, Contacts};
use super::factors::{Kinds, fill_factors, friction};
use super::scatter::Scatter;
use super::separations::Separations;
use super::stress::TensorLanes;
use super::thermostat::{Sweep, SweepSums};
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::friction::fluctuation_dissipation::PairStep;
use crate::friction::{Dependence, Factors, Motions};
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row, RowLanes, WIDTH, inner_product, scaled};
use crate::neighbors::NeighborList;
use crate::state::Particles;
use std::ops::Add;

/// Updates every pair with friction in turn, p_i += μ Δ e, p_j −= the same, with Δ of [`PairStep`].
///
/// Where the friction depends on the transverse velocity alone, the update is the exact Ornstein–Uhlenbeck one; where it depends on
/// the radial one, a Metropolis test makes the Maxwell distribution invariant. In the sums, what is expected is ⟨Δ⟩ before the test:
/// rejections change it by Δt^(3/2) times the noise.
pub fn velocity_dependent_sweep(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    velocity: &mut [Row],
    sweep: &Sweep,
    workers: Workers,
) -> SweepSums {
    let (velocity, region, points) = (Scatter::new(velocity), list.region(), list.points());
    let instructions = InstructionSet::detect();
    let (radial, equal) = (interactions.friction_dependence() == Dependence::Radial, interactions.single_kind());
    let parts = list.sweep(sweep.backward, workers, |contacts| {
        instructions.run(BrickSweep {
            contacts,
            interactions,
            particles,
            region,
            sweep,
            velocity: &velocity,
            points,
            radial,
            equal,
        })
    });
    parts.into_iter().fold(SweepSums::default(), SweepSums::add)
}

/// The pairs of one brick.
struct BrickSweep<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    particles: &'a Particles,
    region: &'a PeriodicBox,
    sweep: &'a Sweep<'a>,
    velocity: &'a Scatter<'a>,
    points: &'a [Row],
    /// Whether a friction depends on the radial velocity: only then are there Metropolis tests.
    radial: bool,
    /// Whether all particles are equal.
    equal: bool,
}

/// What the updates of a block's contacts need and did, in the order of their visits.
#[derive(Default)]
struct Updates {
    contacts: Contacts,
    pairs: Separations,
    kinds: Kinds,
    amplitude: BlockNumbers,
    normals: BlockNumbers,
    uniforms: BlockNumbers,
    /// 1/m of each of the two particles.
    inverse_masses: [BlockNumbers; 2],
    met: Met,
    /// The motions and factors of the row that is worked on.
    motions: Motions,
    factors: Factors,
    /// ⟨Δ⟩.
    expected: BlockNumbers,
    /// Δ.
    change: BlockNumbers,
}

/// Which particles a row has met, by the last bits of their places.
struct Met {
    last_row: [u32; Self::SLOTS],
    row: u32,
}

impl Met {
    const SLOTS: usize = 2048;

    /// Whether two of the first so many pairs of a new row may share a particle; if not, none can matter to another.
    #[inline(always)]
    fn may_share(&mut self, [first, second]: [&[u32; WIDTH]; 2], count: usize) -> bool {
        self.row += 1;
        let mut shared = false;
        for k in 0..count.min(WIDTH) {
            for place in [first[k], second[k]] {
                let last = &mut self.last_row[place as usize % Self::SLOTS];
                shared |= *last == self.row;
                *last = self.row;
            }
        }
        shared
    }
}

impl Default for Met {
    fn default() -> Self {
        Self { last_row: [0; Self::SLOTS], row: 0 }
    }
}

/// Where, from one pair of a row on, the first stands that shares a particle with one before it.
fn first_to_wait([first, second]: [&[u32; WIDTH]; 2], start: usize, count: usize) -> usize {
    let joined = |a: usize, b: usize| [first[a], second[a]].iter().any(|place| [first[b], second[b]].contains(place));
    (start + 1..count).find(|&a| (start..a).any(|b| joined(a, b))).unwrap_or(count)
}

impl Kernel for BrickSweep<'_> {
    type Output = SweepSums;

    #[inline(always)]
    fn run<L: Lanes>(self) -> SweepSums {
        let Self { contacts, sweep, velocity, .. } = self;
        velocity.check(contacts);
        let mut updates = Updates::default();
        let mut flux = L::splat(0.0);
        let (mut dissipative, mut random) = (TensorLanes::<L>::zero(), TensorLanes::<L>::zero());
        for block in contacts.blocks(sweep.backward) {
            let count = updates.contacts.take_in_order(contacts, &block, sweep.backward);
            let block = Contacts::rows(count);
            self.prepare::<L>(&block, &mut updates);
            for row in 0..block.streams {
                self.update::<L>(row, WIDTH.min(count - row * WIDTH), &mut updates);
            }
            if sweep.response.is_some() || sweep.book_stress {
                for row in 0..block.streams {
                    let here = WIDTH.min(count - row * WIDTH);
                    updates.expected[row][here..].fill(0.0);
                    updates.change[row][here..].fill(0.0);
                    let expected = L::load(&updates.expected[row]);
                    let noise = L::load(&updates.change[row]) - expected;
                    let e = updates.pairs.direction(row);
                    let inverse_reduced_mass = self.inverse_reduced_mass::<L>(&updates.inverse_masses, row);
                    let reduced_mass = L::splat(1.0) / inverse_reduced_mass;
                    if let Some(response) = sweep.response {
                        assert!(contacts.places_below() <= response.len(), "contacts of other particles");
                        let [first, second] = updates.contacts.places(block.stream(row));
                        // SAFETY: all places of the contacts are below the number of responses.
                        let (g_i, g_j) = unsafe {
                            (L::load_rows(response.as_ptr(), first), L::load_rows(response.as_ptr(), second))
                        };
                        let g = inner_product(e, [g_i[0] - g_j[0], g_i[1] - g_j[1], g_i[2] - g_j[2]]);
                        flux = (reduced_mass * expected).mul_add(g, flux);
                    }
                    let arm = L::load(&updates.pairs.distance[row]) * reduced_mass;
                    let direction = TensorLanes::square(e);
                    dissipative.add_scaled(arm * expected, &direction);
                    random.add_scaled(arm * noise, &direction);
                }
            }
        }
        SweepSums { flux: flux.sum(), dissipative: dissipative.sum(), random: random.sum() }
    }
}

impl BrickSweep<'_> {
    /// 1/m_i + 1/m_j of eight pairs.
    #[inline(always)]
    fn inverse_reduced_mass<L: Lanes>(&self, inverse_masses: &[BlockNumbers; 2], row: usize) -> L {
        if self.equal {
            L::splat(self.interactions.inverse_reduced_masses.entries()[0])
        } else {
            L::load(&inverse_masses[0][row]) + L::load(&inverse_masses[1][row])
        }
    }

    /// What doesn't depend on velocities.
    #[inline(always)]
    fn prepare<L: Lanes>(&self, block: &Block, updates: &mut Updates) {
        let Self { interactions, particles, sweep, .. } = self;
        let Updates { contacts, pairs, kinds, amplitude, normals, uniforms, inverse_masses, .. } = updates;
        pairs.update::<L>(contacts, block, self.points, self.region);
        kinds.update(contacts, block);
        contacts.by_kind::<L, _>(block, &interactions.frictions, &pairs.distance, amplitude);
        sweep.noise.pair_normals::<L>(block.streams, &pairs.ids, normals);
        if self.radial {
            sweep.acceptance.pair_uniforms::<L>(block.streams, &pairs.ids, uniforms);
        }
        if !self.equal {
            for row in 0..block.streams {
                let [first, second] = contacts.places(block.stream(row));
                L::gather(&particles.inverse_mass, first).store(&mut inverse_masses[0][row]);
                L::gather(&particles.inverse_mass, second).store(&mut inverse_masses[1][row]);
            }
        }
    }

    /// Updates the first so many pairs of a row, all at once where no two share a particle.
    #[inline(always)]
    fn update<L: Lanes>(&self, row: usize, count: usize, updates: &mut Updates) {
        let [first, second] = updates.contacts.places(row * WIDTH);
        let places = [*first, *second];
        let places = [&places[0], &places[1]];
        let mut start = 0;
        let mut end = if updates.met.may_share(places, count) { first_to_wait(places, 0, count) } else { count };
        loop {
            let [change, expected] = self.changes::<L>(row, places, updates);
            if start == 0 {
                change.store(&mut updates.change[row]);
                expected.store(&mut updates.expected[row]);
            } else {
                let mut numbers = [0.0; WIDTH];
                change.store(&mut numbers);
                updates.change[row][start..end].copy_from_slice(&numbers[start..end]);
                expected.store(&mut numbers);
                updates.expected[row][start..end].copy_from_slice(&numbers[start..end]);
            }
            self.apply::<L>(row, places, start, end, change, updates);
            if end == count {
                return;
            }
            start = end;
            end = first_to_wait(places, start, count);
        }
    }

    /// Δ and ⟨Δ⟩ of a row's pairs with the present velocities.
    #[inline(always)]
    fn changes<L: Lanes>(&self, row: usize, [first, second]: [&[u32; WIDTH]; 2], updates: &mut Updates) -> [L; 2] {
        let frictions = &self.interactions.frictions;
        // SAFETY: the places were checked, and inside a sweep no other thread uses them.
        let (v_i, v_j) = unsafe { (self.velocity.load::<L>(first), self.velocity.load::<L>(second)) };
        let v = [v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]];
        let (u, zero) = (inner_product(updates.pairs.direction(row), v), L::splat(0.0));
        let squared = (-u).mul_add(u, inner_product(v, v));
        updates.motions.distance[0] = updates.pairs.distance[row];
        L::select(zero.below(squared), squared, zero).store(&mut updates.motions.transverse_squared[0]);
        let (kinds, normal) = (updates.kinds.row(row), L::load(&updates.normals[row]));
        let inverse_reduced_mass = self.inverse_reduced_mass::<L>(&updates.inverse_masses, row);
        let (temperature, time) = (self.sweep.temperature, self.sweep.time);
        let mut there = PairStep { decay: zero, spread: zero, skew: zero };
        let mut here = there;
        // Once for the friction at u and, where a step has to be tested, once for that at u + Δ.
        for end in 0..=usize::from(self.radial) {
            here = there;
            let radial = if end == 0 { u } else { u + here.change(u, normal) };
            radial.store(&mut updates.motions.radial[0]);
            fill_factors::<L>(frictions, &kinds, 1, &updates.motions, &mut updates.factors);
            let [strength, slope] = friction(L::load(&updates.amplitude[row]), updates.factors.row(0));
            there = PairStep::new(strength, slope, inverse_reduced_mass, temperature, time);
        }
        if !self.radial {
            return [there.change(u, normal), there.expected(u)];
        }
        let variance = L::splat(temperature) * inverse_reduced_mass;
        let uniform = L::load(&updates.uniforms[row]);
        [here.accepted(&there, u, normal, uniform, variance), here.expected(u)]
    }

    /// Gives the pairs from `start` to `end` of a row their new velocities.
    #[inline(always)]
    fn apply<L: Lanes>(
        &self,
        row: usize,
        [first, second]: [&[u32; WIDTH]; 2],
        start: usize,
        end: usize,
        change: L,
        updates: &Updates,
    ) {
        let e = updates.pairs.direction(row);
        let (share_i, share_j) = if self.equal {
            (L::splat(0.5), L::splat(0.5))
        } else {
            let (w_i, w_j) = (L::load(&updates.inverse_masses[0][row]), L::load(&updates.inverse_masses[1][row]));
            (w_i / (w_i + w_j), w_j / (w_i + w_j))
        };
        let (mut gain, mut loss) = ([Row::default(); WIDTH], [Row::default(); WIDTH]);
        L::rows(scaled(change * share_i, e), &mut gain);
        if !self.equal {
            L::rows(scaled(change * share_j, e), &mut loss);
        }
        for k in start..end {
            // SAFETY: the places were checked, and inside a sweep no other thread uses them.
            unsafe {
                let [v_i, v_j] = self.velocity.pair([first[k], second[k]]);
                let gain = L::Row::load(&raw const gain[k]);
                let loss = if self.equal { gain } else { L::Row::load(&raw const loss[k]) };
                L::Row::load(v_i).add(gain).store(v_i);
                L::Row::load(v_j).subtract(loss).store(v_j);
            }
        }
    }
}
