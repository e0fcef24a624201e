//! The sweep of the pair thermostat where friction depends on velocity: group after group of pairs that share no particle.

use super::contacts::{Block, Contacts};
use super::factors::{Kinds, fill_factors, friction};
use super::groups::{Groups, MEMBERS, ROWS, portions};
use super::separations::Separations;
use super::stress::TensorLanes;
use super::thermostat::{BrickSweep, SweepSums};
use crate::friction::fluctuation_dissipation::PairStep;
use crate::friction::{Factors, Motions};
use crate::lanes::{BlockNumbers, Kernel, Lanes, Row, RowLanes, WIDTH, inner_product, scaled};

/// The pairs of one brick, p_i += μ Δ e, p_j −= the same, with Δ of [`PairStep`].
///
/// Where the friction depends on the transverse velocity alone, the update is the exact Ornstein–Uhlenbeck one; where it depends on
/// the radial one (`RADIAL`), a Metropolis test makes the Maxwell distribution invariant. In the sums, what is expected is ⟨Δ⟩ before
/// the test: rejections change it by Δt^(3/2) times the noise.
pub(super) struct VelocityDependentSweep<'a, const RADIAL: bool>(pub BrickSweep<'a>);

/// What the updates of a block's contacts need and did, in the order of their visits.
#[derive(Default)]
struct Updates {
    pairs: Separations,
    kinds: Kinds,
    amplitude: BlockNumbers,
    normals: BlockNumbers,
    uniforms: BlockNumbers,
    /// 1/m of each of the two particles, where not all are equal.
    inverse_masses: [BlockNumbers; 2],
    /// The motions and factors of the group that is worked on.
    motions: Motions,
    factors: Factors,
    /// ⟨Δ⟩.
    expected: BlockNumbers,
    /// Δ.
    change: BlockNumbers,
}

/// Groups in a block.
const GROUPS: usize = WIDTH / ROWS;

impl<const RADIAL: bool> Kernel for VelocityDependentSweep<'_, RADIAL> {
    type Output = SweepSums;

    #[inline(always)]
    fn run<L: Lanes>(self) -> SweepSums {
        let BrickSweep { contacts, sweep, velocity, .. } = self.0;
        velocity.check(contacts);
        let (mut groups, mut updates) = (Groups::default(), Updates::default());
        let mut flux = L::splat(0.0);
        let (mut dissipative, mut random) = (TensorLanes::<L>::zero(), TensorLanes::<L>::zero());
        for portion in portions(contacts.count(), sweep.backward) {
            groups.arrange(contacts, portion);
            let blocks = groups.count().div_ceil(GROUPS);
            for block in 0..blocks {
                let first = GROUPS * if sweep.backward { blocks - 1 - block } else { block };
                let count = GROUPS.min(groups.count() - first);
                let block = Groups::block(first..first + count);
                self.prepare::<L>(&groups.contacts, &block, &mut updates);
                for group in 0..count {
                    let group = if sweep.backward { count - 1 - group } else { group };
                    self.change::<L>(group * ROWS, groups.size(first + group), &mut updates);
                }
                if sweep.response.is_none() && !sweep.book_stress {
                    continue;
                }
                for row in 0..block.streams {
                    let members = groups.size(first + row / ROWS).saturating_sub(row % ROWS * WIDTH).min(WIDTH);
                    updates.expected[row][members..].fill(0.0);
                    updates.change[row][members..].fill(0.0);
                    let expected = L::load(&updates.expected[row]);
                    let noise = L::load(&updates.change[row]) - expected;
                    let e = updates.pairs.direction(row);
                    let reduced_mass = L::splat(1.0) / self.inverse_reduced_mass::<L>(&updates, row);
                    if let Some(response) = sweep.response {
                        assert!(contacts.places_below() <= response.len(), "contacts of other particles");
                        let [first, second] = groups.contacts.places(block.stream(row));
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

impl<const RADIAL: bool> VelocityDependentSweep<'_, RADIAL> {
    /// Whether all particles are equal.
    #[inline(always)]
    fn equal(&self) -> bool {
        self.0.interactions.single_kind()
    }

    /// 1/m_i + 1/m_j of eight pairs.
    #[inline(always)]
    fn inverse_reduced_mass<L: Lanes>(&self, updates: &Updates, row: usize) -> L {
        if self.equal() {
            L::splat(self.0.interactions.inverse_reduced_masses.entries()[0])
        } else {
            L::load(&updates.inverse_masses[0][row]) + L::load(&updates.inverse_masses[1][row])
        }
    }

    /// What doesn't depend on velocities.
    #[inline(always)]
    fn prepare<L: Lanes>(&self, contacts: &Contacts, block: &Block, updates: &mut Updates) {
        let BrickSweep { interactions, particles, sweep, points, region, .. } = &self.0;
        let Updates { pairs, kinds, amplitude, normals, uniforms, inverse_masses, .. } = updates;
        pairs.update::<L>(contacts, block, points, region);
        kinds.update(contacts, block);
        contacts.by_kind::<L, _>(block, &interactions.frictions, &pairs.distance, amplitude);
        sweep.noise.pair_normals::<L>(block.streams, &pairs.ids, normals);
        if RADIAL {
            sweep.acceptance.pair_uniforms::<L>(block.streams, &pairs.ids, uniforms);
        }
        if !self.equal() {
            for row in 0..block.streams {
                let [first, second] = contacts.places(block.stream(row));
                L::gather(&particles.inverse_mass, first).store(&mut inverse_masses[0][row]);
                L::gather(&particles.inverse_mass, second).store(&mut inverse_masses[1][row]);
            }
        }
    }

    /// Γ and its consequences at the motions of a group whose first row is this one.
    #[inline(always)]
    fn steps<L: Lanes>(&self, row: usize, updates: &mut Updates) -> [PairStep<L>; ROWS] {
        let Updates { kinds, motions, factors, .. } = updates;
        fill_factors::<L>(&self.0.interactions.frictions, kinds, row, ROWS, motions, factors);
        let (temperature, time) = (self.0.sweep.temperature, self.0.sweep.time);
        let mut steps = [PairStep { decay: L::splat(0.0), spread: L::splat(0.0), skew: L::splat(0.0) }; ROWS];
        for n in 0..ROWS {
            let [strength, slope] = friction(L::load(&updates.amplitude[row + n]), updates.factors.row(n));
            let inverse_reduced_mass = self.inverse_reduced_mass(updates, row + n);
            steps[n] = PairStep::new(strength, slope, inverse_reduced_mass, temperature, time);
        }
        steps
    }

    /// Gives the members of a group, whose first row is this one, their new velocities.
    ///
    /// Each stage is done for all rows before the next, so that the processor works on several chains at a time.
    #[inline(always)]
    fn change<L: Lanes>(&self, row: usize, members: usize, updates: &mut Updates) {
        let BrickSweep { sweep, velocity, .. } = self.0;
        let [first, second] =
            [0, 1].map(|end| std::array::from_fn::<_, ROWS, _>(|n| updates.pairs.places[end][row + n]));
        let mut u = [L::splat(0.0); ROWS];
        for n in 0..ROWS {
            // SAFETY: the places were checked, and inside a sweep no other thread uses them.
            let (v_i, v_j) = unsafe { (velocity.load::<L>(&first[n]), velocity.load::<L>(&second[n])) };
            let v = [v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]];
            u[n] = inner_product(updates.pairs.direction(row + n), v);
            let (squared, zero) = ((-u[n]).mul_add(u[n], inner_product(v, v)), L::splat(0.0));
            L::select(zero.below(squared), squared, zero).store(&mut updates.motions.transverse_squared[n]);
            updates.motions.distance[n] = updates.pairs.distance[row + n];
            u[n].store(&mut updates.motions.radial[n]);
        }
        let steps = self.steps::<L>(row, updates);
        let mut change = [L::splat(0.0); ROWS];
        for n in 0..ROWS {
            change[n] = steps[n].change(u[n], L::load(&updates.normals[row + n]));
            steps[n].expected(u[n]).store(&mut updates.expected[row + n]);
        }
        if RADIAL {
            for n in 0..ROWS {
                (u[n] + change[n]).store(&mut updates.motions.radial[n]);
            }
            let back = self.steps::<L>(row, updates);
            for n in 0..ROWS {
                let normal = L::load(&updates.normals[row + n]);
                let uniform = L::load(&updates.uniforms[row + n]);
                let variance = L::splat(sweep.temperature) * self.inverse_reduced_mass(updates, row + n);
                change[n] = steps[n].accepted(&back[n], u[n], normal, uniform, variance);
            }
        }
        let mut gain = [[Row::default(); WIDTH]; ROWS];
        let mut loss = gain;
        for n in 0..ROWS {
            change[n].store(&mut updates.change[row + n]);
            let e = updates.pairs.direction(row + n);
            if self.equal() {
                L::rows(scaled(change[n] * L::splat(0.5), e), &mut gain[n]);
            } else {
                let reduced_mass = change[n] / self.inverse_reduced_mass(updates, row + n);
                L::rows(scaled(reduced_mass * L::load(&updates.inverse_masses[0][row + n]), e), &mut gain[n]);
                L::rows(scaled(reduced_mass * L::load(&updates.inverse_masses[1][row + n]), e), &mut loss[n]);
            }
        }
        for k in 0..members.min(MEMBERS) {
            let (n, lane) = (k / WIDTH, k % WIDTH);
            // SAFETY: the places were checked, and inside a sweep no other thread uses them.
            unsafe {
                let [v_i, v_j] = velocity.pair([first[n][lane], second[n][lane]]);
                let gain = L::Row::load(&raw const gain[n][lane]);
                let loss = if self.equal() { gain } else { L::Row::load(&raw const loss[n][lane]) };
                L::Row::load(v_i).add(gain).store(v_i);
                L::Row::load(v_j).subtract(loss).store(v_j);
            }
        }
    }
}
