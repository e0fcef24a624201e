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
use std::ops::{Add, Range};

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
    /// The motions and factors of the rows that are worked on.
    motions: Motions,
    factors: Factors,
    /// ⟨Δ⟩.
    expected: BlockNumbers,
    /// Δ.
    change: BlockNumbers,
}

/// Rows that are worked on together.
const ROWS: usize = 2;

/// Which particles have been met together, by the last bits of their places.
struct Met {
    last_turn: [u32; Self::SLOTS],
    turn: u32,
}

impl Met {
    const SLOTS: usize = 4096;

    /// Whether two of some pairs may share a particle; if not, none can matter to another.
    #[inline(always)]
    fn may_share(&mut self, [first, second]: [&[u32]; 2]) -> bool {
        self.turn += 1;
        let mut shared = false;
        for (&i, &j) in first.iter().zip(second) {
            for place in [i, j] {
                let last = &mut self.last_turn[place as usize % Self::SLOTS];
                shared |= *last == self.turn;
                *last = self.turn;
            }
        }
        shared
    }
}

impl Default for Met {
    fn default() -> Self {
        Self { last_turn: [0; Self::SLOTS], turn: 0 }
    }
}

/// How many of some pairs, from the first on, share no particle.
fn without_sharing([first, second]: [&[u32]; 2]) -> usize {
    let joined = |a: usize, b: usize| [first[a], second[a]].iter().any(|place| [first[b], second[b]].contains(place));
    (1..first.len()).find(|&a| (0..a).any(|b| joined(a, b))).unwrap_or(first.len())
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
        for from in (0..contacts.count()).step_by(WIDTH * WIDTH) {
            let (count, block) = updates.contacts.take_rows(contacts, from, sweep.backward);
            self.prepare::<L>(&block, &mut updates);
            self.update::<L>(count, &mut updates);
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

    /// Updates the first so many pairs of a block, two rows or one at once where no two pairs share a particle.
    #[inline(always)]
    fn update<L: Lanes>(&self, count: usize, updates: &mut Updates) {
        let mut from = 0;
        while from < count {
            let all = (from + ROWS * WIDTH).min(count);
            if all > from + WIDTH && !updates.met.may_share(updates.contacts.pairs(from..all)) {
                self.change::<L>(from / WIDTH, ROWS, 0..all - from, updates);
                from = all;
                continue;
            }
            let row_end = (from + WIDTH).min(count);
            let (row, start) = (from / WIDTH, from);
            while from < row_end {
                let rest = updates.contacts.pairs(from..row_end);
                let together = if updates.met.may_share(rest) { without_sharing(rest) } else { row_end - from };
                self.change::<L>(row, 1, from - start..from - start + together, updates);
                from += together;
            }
        }
    }

    /// Gives some pairs of one or two rows their new velocities, by those of the moment.
    ///
    /// Each stage is done for both rows before the next, so that the processor works on two chains at a time.
    #[inline(always)]
    fn change<L: Lanes>(&self, row: usize, rows: usize, chosen: Range<usize>, updates: &mut Updates) {
        let frictions = &self.interactions.frictions;
        let (temperature, time, zero) = (self.sweep.temperature, self.sweep.time, L::splat(0.0));
        let rows = rows.min(ROWS);
        let [first, second] = updates.contacts.row_places(row);
        let (mut u, mut inverse_reduced_mass) = ([zero; ROWS], [zero; ROWS]);
        for n in 0..rows {
            // SAFETY: the places were checked, and inside a sweep no other thread uses them.
            let (v_i, v_j) = unsafe { (self.velocity.load::<L>(&first[n]), self.velocity.load::<L>(&second[n])) };
            let v = [v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]];
            u[n] = inner_product(updates.pairs.direction(row + n), v);
            let squared = (-u[n]).mul_add(u[n], inner_product(v, v));
            L::select(zero.below(squared), squared, zero).store(&mut updates.motions.transverse_squared[n]);
            updates.motions.distance[n] = updates.pairs.distance[row + n];
            inverse_reduced_mass[n] = self.inverse_reduced_mass(&updates.inverse_masses, row + n);
        }
        let kinds = updates.kinds.rows(row);
        let mut there = [PairStep { decay: zero, spread: zero, skew: zero }; ROWS];
        let mut here = there;
        // Once for the friction at u and, where a step has to be tested, once for that at u + Δ.
        for end in 0..=usize::from(self.radial) {
            here = there;
            for n in 0..rows {
                let normal = L::load(&updates.normals[row + n]);
                let radial = if end == 0 { u[n] } else { u[n] + here[n].change(u[n], normal) };
                radial.store(&mut updates.motions.radial[n]);
            }
            fill_factors::<L>(frictions, &kinds, rows, &updates.motions, &mut updates.factors);
            for n in 0..rows {
                let [strength, slope] = friction(L::load(&updates.amplitude[row + n]), updates.factors.row(n));
                there[n] = PairStep::new(strength, slope, inverse_reduced_mass[n], temperature, time);
            }
        }
        let mut gain = [[Row::default(); WIDTH]; ROWS];
        let mut loss = gain;
        for n in 0..rows {
            let normal = L::load(&updates.normals[row + n]);
            let (change, expected) = if self.radial {
                let variance = L::splat(temperature) * inverse_reduced_mass[n];
                let uniform = L::load(&updates.uniforms[row + n]);
                (here[n].accepted(&there[n], u[n], normal, uniform, variance), here[n].expected(u[n]))
            } else {
                (there[n].change(u[n], normal), there[n].expected(u[n]))
            };
            let e = updates.pairs.direction(row + n);
            if self.equal {
                L::rows(scaled(change * L::splat(0.5), e), &mut gain[n]);
            } else {
                let reduced_mass = change / inverse_reduced_mass[n];
                let w_i = L::load(&updates.inverse_masses[0][row + n]);
                let w_j = L::load(&updates.inverse_masses[1][row + n]);
                L::rows(scaled(reduced_mass * w_i, e), &mut gain[n]);
                L::rows(scaled(reduced_mass * w_j, e), &mut loss[n]);
            }
            updates.keep(row + n, change, expected, n * WIDTH, &chosen);
        }
        for k in chosen {
            let (n, lane) = (k / WIDTH % ROWS, k % WIDTH);
            // SAFETY: the places were checked, and inside a sweep no other thread uses them.
            unsafe {
                let [v_i, v_j] = self.velocity.pair([first[n][lane], second[n][lane]]);
                let gain = L::Row::load(&raw const gain[n][lane]);
                let loss = if self.equal { gain } else { L::Row::load(&raw const loss[n][lane]) };
                L::Row::load(v_i).add(gain).store(v_i);
                L::Row::load(v_j).subtract(loss).store(v_j);
            }
        }
    }
}

impl Updates {
    /// Keeps Δ and ⟨Δ⟩ of those pairs of a row that were chosen, `from` being the number of the row's first.
    #[inline(always)]
    fn keep<L: Lanes>(&mut self, row: usize, change: L, expected: L, from: usize, chosen: &Range<usize>) {
        if chosen.start <= from {
            // What stands behind the chosen is written again with theirs.
            change.store(&mut self.change[row]);
            expected.store(&mut self.expected[row]);
            return;
        }
        let mut numbers = [[0.0; WIDTH]; 2];
        change.store(&mut numbers[0]);
        expected.store(&mut numbers[1]);
        for lane in chosen.start - from..(chosen.end - from).min(WIDTH) {
            self.change[row][lane] = numbers[0][lane];
            self.expected[row][lane] = numbers[1][lane];
        }
    }
}
