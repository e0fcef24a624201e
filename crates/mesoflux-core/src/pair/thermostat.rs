//! The sequential sweep of the pair thermostat: an exact Ornstein–Uhlenbeck update of one pair after the other.

use super::contacts::{CHUNK, Contacts};
use super::instruction_set::{InstructionSet, Kernel};
use super::scatter::Scatter;
use crate::domain::Workers;
use crate::friction::fluctuation_dissipation::ornstein_uhlenbeck;
use crate::interactions::Interactions;
use crate::neighbors::NeighborList;
use crate::noise::Draw;
use crate::state::Particles;
use crate::vector::{Vector, add_scaled, dot, subtract};

/// What a sweep does, beside the state it acts on.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// kT.
    pub temperature: f64,
    /// The time over which the pairs are thermalized.
    pub time: f64,
    /// The noise of this sweep.
    pub noise: Draw,
    /// From the last pair to the first.
    pub backward: bool,
    /// G of every particle, in storage order, where the flux G·p is to be followed.
    pub response: Option<&'a [Vector]>,
}

/// Updates every pair with friction in turn: p_i += μ (Δv^D + Δv^R) e, p_j −= the same (Wu & Shang, eqs 27–29, 58–61).
///
/// Returns the expected change of the flux G·p, Σ_pairs μ Δv^D e·(G_i − G_j), each term given the state just before its pair
/// is visited (zero without `response`). What remains of the change is the martingale of the noise.
pub fn ornstein_uhlenbeck_sweep(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &mut Particles,
    sweep: &Sweep,
    workers: Workers,
) -> f64 {
    let (id, inverse_mass) = (&particles.id, &particles.inverse_mass);
    let momentum = Scatter::new(&mut particles.momentum);
    let instructions = InstructionSet::detect();
    let parts = list.sweep(sweep.backward, workers, |brick| {
        let contacts = &brick.contacts;
        instructions.run(BrickSweep { contacts, interactions, sweep, momentum: &momentum, id, inverse_mass })
    });
    parts.into_iter().sum()
}

/// The pairs of one brick.
struct BrickSweep<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    sweep: &'a Sweep<'a>,
    momentum: &'a Scatter<'a, Vector>,
    id: &'a [u64],
    inverse_mass: &'a [f64],
}

/// What the update of each contact of a chunk needs; none of it depends on momenta.
struct Updates {
    decay: [f64; CHUNK],
    random: [f64; CHUNK],
    inverse_reduced_mass: [f64; CHUNK],
}

impl Kernel for BrickSweep<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { contacts, sweep, momentum, inverse_mass, .. } = self;
        let mut updates = Updates { decay: [0.0; CHUNK], random: [0.0; CHUNK], inverse_reduced_mass: [0.0; CHUNK] };
        let mut expected = 0.0;
        for chunk in contacts.chunks(sweep.backward) {
            let count = chunk.len();
            self.prepare(&chunk, &mut updates);
            let (first, second) = (&contacts.first[chunk.clone()], &contacts.second[chunk.clone()]);
            let direction = &contacts.direction[chunk];
            for n in 0..count {
                let n = if sweep.backward { count - 1 - n } else { n };
                let (i, j, e) = (first[n], second[n], direction[n]);
                let (w_i, w_j) = (inverse_mass[i as usize], inverse_mass[j as usize]);
                // SAFETY: inside a sweep.
                let (p_i, p_j) = unsafe { momentum.pair(i, j) };
                let v_ij = [p_i[0] * w_i - p_j[0] * w_j, p_i[1] * w_i - p_j[1] * w_j, p_i[2] * w_i - p_j[2] * w_j];
                let reduced_mass = 1.0 / updates.inverse_reduced_mass[n];
                let dissipative = updates.decay[n] * dot(e, v_ij);
                let impulse = reduced_mass * (dissipative + updates.random[n]);
                add_scaled(p_i, impulse, e);
                add_scaled(p_j, -impulse, e);
                if let Some(response) = sweep.response {
                    let change = dot(e, subtract(response[i as usize], response[j as usize]));
                    expected += reduced_mass * dissipative * change;
                }
            }
        }
        expected
    }
}

impl BrickSweep<'_> {
    /// Decay and random velocity of a chunk's contacts, contact by contact, in any order.
    #[inline(always)]
    fn prepare(&self, chunk: &std::ops::Range<usize>, updates: &mut Updates) {
        let Self { contacts, interactions, sweep, id, .. } = self;
        let mut strength = [0.0; CHUNK];
        contacts.strengths(&interactions.frictions, chunk, &mut strength);
        contacts.value_by_kind(&interactions.inverse_reduced_masses, chunk, &mut updates.inverse_reduced_mass);
        let gaussians: [f64; CHUNK] =
            sweep.noise.pair_gaussians(id, &contacts.first[chunk.clone()], &contacts.second[chunk.clone()]);
        // A whole number of vectors, filled or not.
        for n in 0..chunk.len().next_multiple_of(8).min(CHUNK) {
            let update =
                ornstein_uhlenbeck(strength[n], updates.inverse_reduced_mass[n], sweep.temperature, sweep.time);
            updates.decay[n] = update.decay;
            updates.random[n] = update.amplitude * gaussians[n];
        }
    }
}
