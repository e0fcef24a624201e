//! The sequential sweep of the pair thermostat: an exact Ornstein–Uhlenbeck update of one pair after the other.

use super::contacts::{CHUNK, Contacts};
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

/// Decay and random velocity of each contact of a chunk.
struct Updates {
    decay: [f64; CHUNK],
    random: [f64; CHUNK],
    inverse_reduced_mass: [f64; CHUNK],
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
    let parts = list.sweep(sweep.backward, workers, |brick| {
        let contacts = &brick.contacts;
        let mut updates = Updates {
            decay: [0.0; CHUNK],
            random: [0.0; CHUNK],
            inverse_reduced_mass: [0.0; CHUNK],
        };
        let mut expected = 0.0;
        for chunk in contacts.chunks(sweep.backward) {
            let (start, count) = (chunk.start, chunk.len());
            prepare(contacts, chunk, interactions, id, sweep, &mut updates);
            for n in 0..count {
                let n = if sweep.backward { count - 1 - n } else { n };
                let k = start + n;
                let (i, j, e) = (contacts.first[k], contacts.second[k], contacts.direction[k]);
                let (w_i, w_j) = (inverse_mass[i as usize], inverse_mass[j as usize]);
                // SAFETY: inside a sweep.
                let (p_i, p_j) = unsafe { momentum.pair(i, j) };
                let u = dot(
                    e,
                    [
                        p_i[0] * w_i - p_j[0] * w_j,
                        p_i[1] * w_i - p_j[1] * w_j,
                        p_i[2] * w_i - p_j[2] * w_j,
                    ],
                );
                let reduced_mass = 1.0 / updates.inverse_reduced_mass[n];
                let dissipative = updates.decay[n] * u;
                let impulse = reduced_mass * (dissipative + updates.random[n]);
                add_scaled(p_i, impulse, e);
                add_scaled(p_j, -impulse, e);
                if let Some(response) = sweep.response {
                    expected +=
                        reduced_mass * dissipative * dot(e, subtract(response[i as usize], response[j as usize]));
                }
            }
        }
        expected
    });
    parts.into_iter().sum()
}

/// Everything about a chunk's updates that doesn't depend on momenta: contact by contact, in any order.
#[inline(always)]
fn prepare(
    contacts: &Contacts,
    chunk: std::ops::Range<usize>,
    interactions: &Interactions,
    id: &[u64],
    sweep: &Sweep,
    updates: &mut Updates,
) {
    let mut strength = [0.0; CHUNK];
    contacts.add_by_kind(
        &interactions.frictions,
        &chunk,
        &mut strength,
        |law, r, kinds, column| match kinds {
            None => law.add_strengths(r, |_| true, column),
            Some((kinds, kind)) => law.add_strengths(r, |k| kinds[k] == kind, column),
        },
    );
    let (mut a, mut b) = ([0; CHUNK], [0; CHUNK]);
    for (n, k) in chunk.enumerate() {
        let (i, j) = (id[contacts.first[k] as usize], id[contacts.second[k] as usize]);
        (a[n], b[n]) = (i.min(j), i.max(j));
        updates.inverse_reduced_mass[n] = interactions.inverse_reduced_masses.entries()[contacts.kind(k)];
    }
    for n in 0..CHUNK {
        let update = ornstein_uhlenbeck(
            strength[n],
            updates.inverse_reduced_mass[n],
            sweep.temperature,
            sweep.time,
        );
        updates.decay[n] = update.decay;
        updates.random[n] = update.amplitude * sweep.noise.gaussian(a[n], b[n]);
    }
}
