//! Sums over contacts that observables need; nothing here changes the state.

use crate::domain::Workers;
use crate::friction::Motion;
use crate::friction::fluctuation_dissipation::correction;
use crate::interactions::Interactions;
use crate::lanes::Row;
use crate::neighbors::NeighborList;
use crate::state::Particles;
use crate::vector::{dot, subtract};
use std::ops::Add;

/// Sums over all pairs of the conservative laws.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PairSums {
    /// U = Σ u(r).
    pub potential_energy: f64,
    /// W = Σ r f(r).
    pub virial: f64,
    /// ∇²U = Σ_i ∂²U/∂r_i² = −2 Σ_pairs [f'(r) + 2 f(r)/r].
    pub laplacian: f64,
}

impl Add for PairSums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            potential_energy: self.potential_energy + other.potential_energy,
            virial: self.virial + other.virial,
            laplacian: self.laplacian + other.laplacian,
        }
    }
}

/// Potential energy, virial and Laplacian at the positions of the contacts.
pub fn pair_sums(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    workers: Workers,
) -> PairSums {
    let parts = list.sweep(false, workers, |contacts| {
        let mut sums = PairSums::default();
        for k in 0..contacts.count() {
            if let Some(law) = &interactions.potentials.entries()[contacts.kind(k)] {
                let (r, _) = contacts.separation(k, &particles.position, list.region());
                if r < law.cutoff() {
                    let force = law.force(r);
                    sums.potential_energy += law.energy(r);
                    sums.virial += r * force;
                    sums.laplacian -= 2.0 * (law.force_derivative(r) + 2.0 * force / r);
                }
            }
        }
        sums
    });
    parts.into_iter().fold(PairSums::default(), PairSums::add)
}

/// G·(friction force) = Σ_pairs (−Γu + Λ) e·(G_i − G_j) for a response G given in storage order, Λ = kT (1/m_i + 1/m_j) ∂Γ/∂u.
pub fn dissipative_flux(
    list: &NeighborList,
    interactions: &Interactions,
    particles: &Particles,
    response: &[Row],
    temperature: f64,
    workers: Workers,
) -> f64 {
    let parts = list.sweep(false, workers, |contacts| {
        let mut sum = 0.0;
        for k in 0..contacts.count() {
            if let Some(law) = &interactions.frictions.entries()[contacts.kind(k)] {
                let (r, e) = contacts.separation(k, &particles.position, list.region());
                let [i, j] = contacts.pair(k);
                let motion = Motion::new(r, e, subtract(particles.velocity(i), particles.velocity(j)));
                let inverse_reduced_mass = particles.inverse_mass[i] + particles.inverse_mass[j];
                let noise = correction(law.slope(motion), inverse_reduced_mass, temperature);
                let force = noise - law.strength(motion) * motion.radial;
                sum += force * dot(e, subtract(response[i].vector(), response[j].vector()));
            }
        }
        sum
    });
    parts.into_iter().sum()
}
