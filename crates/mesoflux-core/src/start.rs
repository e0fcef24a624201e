//! Where particles start: lattices for any number of them, random positions, chains, Maxwell's momenta, overlaps relaxed.

use crate::boundary::PeriodicBox;
use crate::elementary::cos_two_pi;
use crate::interactions::Interactions;
use crate::noise::{NoiseKey, Purpose};
use crate::potential::Potential;
use crate::state::Particles;
use crate::system::{SimulationError, System};
use crate::vector::{Vector, ZERO, add_scaled, dot};
use serde::{Deserialize, Serialize};

/// How positions are laid out at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// A simple cubic lattice.
    #[default]
    CubicLattice,
    /// A face-centered cubic lattice.
    FccLattice,
    /// Uniformly at random; overlaps are relaxed where a law has a hard core.
    Random,
}

// The places of the draws at the start; each kind of number has its own.
const POSITIONS: u64 = 0;
const MOMENTA: u64 = 1;
const SHUFFLE: u64 = 2;
const WALK: u64 = 3;
const CHAINS: u64 = 4;

/// Two particles that start too near to each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the particles {first} and {second} start {distance:.4} apart, where their potential is {energy:.3e}: \
     must be at most {limit}, a thousand kT"
)]
pub struct Overlap {
    /// The id of one.
    pub first: u64,
    /// The id of the other.
    pub second: u64,
    /// r.
    pub distance: f64,
    /// u(r).
    pub energy: f64,
    /// The largest energy that is no overlap.
    pub limit: f64,
}

/// Positions of `count` particles; where the lattice has more sites, the vacant ones are spread evenly.
pub fn positions(start: Start, count: usize, region: &PeriodicBox, noise: NoiseKey) -> Vec<Vector> {
    let basis: &[Vector] = match start {
        Start::CubicLattice => &[[0.5, 0.5, 0.5]],
        Start::FccLattice => &[[0.25, 0.25, 0.25], [0.25, 0.75, 0.75], [0.75, 0.25, 0.75], [0.75, 0.75, 0.25]],
        Start::Random => {
            let draw = noise.draw(Purpose::Start, 0, POSITIONS);
            let coordinate = |id: u64, axis: usize| draw.uniform(id, axis as u64) * region.sides()[axis];
            return (0..count as u64).map(|id| std::array::from_fn(|axis| coordinate(id, axis))).collect();
        }
    };
    let cells = lattice_cells(count.div_ceil(basis.len()), region.sides());
    let sites = cells.iter().product::<usize>() * basis.len();
    (0..count)
        .map(|k| {
            let site = (k as u128 * sites as u128 / count as u128) as usize;
            let (cell, atom) = (site / basis.len(), basis[site % basis.len()]);
            let place = [cell % cells[0], cell / cells[0] % cells[1], cell / (cells[0] * cells[1])];
            std::array::from_fn(|axis| (place[axis] as f64 + atom[axis]) * region.sides()[axis] / cells[axis] as f64)
        })
        .collect()
}

/// The smallest lattice of at least `count` cells whose cells are as nearly cubic as the box allows.
fn lattice_cells(count: usize, sides: Vector) -> [usize; 3] {
    let edge = (sides.iter().product::<f64>() / count as f64).cbrt();
    let mut cells = sides.map(|side| ((side / edge).floor() as usize).max(1));
    while cells.iter().product::<usize>() < count {
        let widest = (0..3).max_by(|&a, &b| (sides[a] / cells[a] as f64).total_cmp(&(sides[b] / cells[b] as f64)));
        cells[widest.unwrap_or(0)] += 1;
    }
    cells
}

/// Deals the species' numbers out to the particles at random (in order where there is but one species).
pub fn deal_species(counts: &[usize], noise: NoiseKey) -> Vec<u8> {
    let dealt = counts.iter().enumerate().flat_map(|(species, &count)| std::iter::repeat_n(species as u8, count));
    let mut species: Vec<u8> = dealt.collect();
    if counts.len() > 1 {
        let draw = noise.draw(Purpose::Start, 0, SHUFFLE);
        for k in (1..species.len()).rev() {
            let other = (draw.uniform(k as u64, 0) * (k + 1) as f64) as usize;
            species.swap(k, other);
        }
    }
    species
}

/// Draws momenta from Maxwell's distribution at kT, given that their sum is zero.
///
/// Each momentum is normal with variance m kT; taking away the velocity of the center of mass is the exact condition.
pub fn draw_momenta(particles: &mut Particles, temperature: f64, noise: NoiseKey) {
    draw_free_momenta(particles, temperature, noise);
    remove_drift(particles, [true; 3]);
}

/// Draws momenta from Maxwell's distribution at kT, whatever their sum.
pub fn draw_free_momenta(particles: &mut Particles, temperature: f64, noise: NoiseKey) {
    let draw = noise.draw(Purpose::Start, 0, MOMENTA);
    for k in 0..particles.count() {
        let deviation = (temperature / particles.inverse_mass[k]).sqrt();
        let id = particles.id[k];
        particles.momentum[k] = std::array::from_fn(|axis| deviation * draw.gaussian(id, axis as u64));
    }
}

/// Takes away the velocity of the center of mass along the axes that are named.
pub fn remove_drift(particles: &mut Particles, along: [bool; 3]) {
    let workers = crate::domain::Workers::One;
    let (total, mass) = (particles.total_momentum(workers), particles.total_mass(workers));
    for k in 0..particles.count() {
        let share = 1.0 / (particles.inverse_mass[k] * mass);
        for axis in (0..3).filter(|&axis| along[axis]) {
            particles.momentum[k][axis] -= share * total[axis];
        }
    }
}

/// A chain of beads as a random walk from a random place: bond k is `lengths[k]` long and never turns back sharply.
///
/// The beads have the ids from `first` on. A turn by more than 120 degrees is drawn again, so that beads two bonds apart are
/// farther from each other than bonded ones.
pub fn chain(lengths: &[f64], first: u64, region: &PeriodicBox, noise: NoiseKey) -> Vec<Vector> {
    let (place, walk) = (noise.draw(Purpose::Start, 0, CHAINS), noise.draw(Purpose::Start, 0, WALK));
    let mut position: Vector = std::array::from_fn(|axis| place.uniform(first, axis as u64) * region.sides()[axis]);
    let mut beads = vec![position];
    let mut before: Option<Vector> = None;
    for (id, &length) in (first + 1..).zip(lengths) {
        let mut tries =
            (0..64).map(|attempt| direction(walk.uniform(id, 2 * attempt), walk.uniform(id, 2 * attempt + 1)));
        let onward = |e: &Vector| before.is_none_or(|before| dot(before, *e) > -0.5);
        let e = tries.find(onward).or(before).unwrap_or([1.0, 0.0, 0.0]);
        add_scaled(&mut position, length, e);
        beads.push(position);
        before = Some(e);
    }
    beads
}

/// The direction on the unit sphere that belongs to two uniform numbers.
fn direction(u: f64, v: f64) -> Vector {
    let z = 2.0 * u - 1.0;
    let across = (1.0 - z * z).max(0.0).sqrt();
    [across * cos_two_pi(v), across * cos_two_pi((v + 0.75).fract()), z]
}

/// Moves overlapping particles apart, down the forces, until no force exceeds 100 kT per contact distance.
///
/// Does nothing where no law has a hard core. Bonds hold: near its longest length one pulls harder than any overlap may push.
///
/// # Errors
/// Positions that are no numbers; a bond that is too long in the end.
pub fn relax_overlaps(system: &mut System, temperature: f64) -> Result<(), SimulationError> {
    let contact = contact_distance(&system.interactions);
    if contact == 0.0 {
        return Ok(());
    }
    let norm = |f: Vector| dot(f, f).sqrt();
    let tolerated = 100.0 * temperature / contact;
    let mut push = vec![ZERO; system.particles.count()];
    // A gentle push at first lets chains that were drawn across each other pass through; only then do cores become hard.
    let (mut limit, hardening) = (0.1 * tolerated, if system.topology().bonds().is_empty() { 1.05 } else { 1.004 });
    for _ in 0..5000 {
        system.update_forces();
        if system.forces().iter().all(|f| norm(f.vector()) <= tolerated) {
            break;
        }
        limited_forces(system, limit, &mut push);
        limit = (hardening * limit).min(10.0 * tolerated);
        // Nobody moves farther than a hundredth of the contact distance at a time, however hard the overlap pushes.
        let (longest, rate) = (0.01 * contact, 0.01 * contact / tolerated);
        for (position, &force) in system.particles.position.iter_mut().zip(&push) {
            let length = (rate * norm(force)).min(longest);
            add_scaled(position, if norm(force) > 0.0 { length / norm(force) } else { 0.0 }, force);
        }
        system.follow_positions()?;
    }
    system.positions_moved()
}

/// The forces with no pair's above a limit; a bond near its longest length pulls a hundred times harder.
fn limited_forces(system: &mut System, limit: f64, force: &mut [Vector]) {
    force.fill(ZERO);
    let region = system.region;
    let (list, interactions, particles) = system.with_contacts();
    for contacts in list.contacts() {
        for k in 0..contacts.count() {
            if let Some(law) = &interactions.potentials.entries()[contacts.kind(k)] {
                let ([i, j], (r, e)) = (contacts.pair(k), contacts.separation(k, &particles.position, &region));
                // Two particles in one place have no direction of their own, nor every law a force there.
                let e = if r > 0.0 { e } else { [1.0, 0.0, 0.0] };
                let force_of_law = law.force(r);
                let magnitude = if force_of_law.is_nan() { limit } else { force_of_law.clamp(-limit, limit) };
                add_scaled(&mut force[i], magnitude, e);
                add_scaled(&mut force[j], -magnitude, e);
            }
        }
    }
    let topology = system.topology();
    topology.for_each_bond(&system.particles, &system.region, |bond, [i, j], d| {
        let (r, law) = (dot(d, d).sqrt(), topology.laws()[usize::from(bond.law)]);
        let pull = 100.0 * limit;
        let magnitude = if r < 0.99 * law.longest() { law.force(r).clamp(-pull, pull) } else { -pull };
        let scale = if r > 0.0 { magnitude / r } else { 0.0 };
        add_scaled(&mut force[i], scale, d);
        add_scaled(&mut force[j], -scale, d);
    });
}

/// Whether no two particles with a hard core start so near that their potential is above a thousand kT.
///
/// # Errors
/// The pair with the highest potential.
pub fn check_overlaps(system: &mut System, temperature: f64) -> Result<(), Overlap> {
    // Contacts of all pairs take much memory.
    if contact_distance(&system.interactions) == 0.0 {
        return Ok(());
    }
    let limit = 1000.0 * temperature;
    let mut worst: Option<Overlap> = None;
    let region = system.region;
    let (list, interactions, particles) = system.with_contacts();
    for contacts in list.contacts() {
        for k in 0..contacts.count() {
            let Some(law) = &interactions.potentials.entries()[contacts.kind(k)] else { continue };
            let (distance, _) = contacts.separation(k, &particles.position, &region);
            let energy = law.energy(distance);
            let energy = if energy.is_nan() { f64::INFINITY } else { energy };
            if law.contact_distance() > 0.0 && energy > worst.as_ref().map_or(limit, |worst| worst.energy) {
                let [a, b] = contacts.pair(k).map(|place| particles.id[place]);
                worst = Some(Overlap { first: a.min(b), second: a.max(b), distance, energy, limit });
            }
        }
    }
    worst.map_or(Ok(()), Err)
}

/// The largest distance below which a law calls two particles overlapping.
fn contact_distance(interactions: &Interactions) -> f64 {
    interactions.potentials.entries().iter().flatten().map(Potential::contact_distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Workers;
    use crate::potential::lennard_jones::{LennardJones, Truncation};
    use crate::vector::subtract;

    const NOISE: fn() -> NoiseKey = || NoiseKey::new(&[1]);

    #[test]
    fn lattices_hold_any_number_without_coincidences() {
        let region = PeriodicBox::new([4.0, 5.0, 9.0]).unwrap();
        for start in [Start::CubicLattice, Start::FccLattice] {
            for count in [1, 2, 7, 64, 100, 500, 503] {
                let sites = positions(start, count, &region, NOISE());
                assert_eq!(sites.len(), count);
                let spacing = (region.volume() / count as f64).cbrt();
                for i in 0..count {
                    for j in 0..i {
                        let d = subtract(sites[i], sites[j]);
                        assert!(dot(d, d).sqrt() > 0.5 * spacing, "{start:?} with {count} particles");
                    }
                    assert!((0..3).all(|axis| sites[i][axis] >= 0.0 && sites[i][axis] < region.sides()[axis]));
                }
            }
        }
    }

    #[test]
    fn no_chain_begins_where_a_free_particle_is_placed() {
        let region = PeriodicBox::new([5.0; 3]).unwrap();
        let free = positions(Start::Random, 50, &region, NOISE());
        let firsts = (0..50).map(|first| chain(&[0.7], first, &region, NOISE())[0]);
        assert!(firsts.zip(&free).all(|(bead, particle)| bead != *particle), "both draw the same numbers");
    }

    #[test]
    fn a_full_fcc_lattice_has_twelve_nearest_neighbors() {
        let region = PeriodicBox::new([3.0; 3]).unwrap();
        let sites = positions(Start::FccLattice, 108, &region, NOISE());
        let near = |a: Vector, b: Vector| {
            let d = subtract(a, b).map(|d| d - 3.0 * (d / 3.0).round());
            dot(d, d) < 0.51
        };
        for &site in &sites {
            assert_eq!(sites.iter().filter(|&&other| other != site && near(site, other)).count(), 12);
        }
    }

    #[test]
    fn momenta_are_maxwellian_with_zero_sum() {
        let masses = [1.0, 4.0];
        let species = deal_species(&[3000, 1000], NOISE());
        assert_eq!(species.iter().map(|&s| usize::from(s)).sum::<usize>(), 1000);
        let mut particles = Particles::at_rest(vec![[0.0; 3]; 4000], species, &masses);
        draw_momenta(&mut particles, 0.7, NOISE());
        let total = particles.total_momentum(Workers::One);
        assert!(total.iter().all(|p| p.abs() < 1e-10));
        // 3(N − 1) degrees of freedom: the sum of squares has a relative deviation √(2/(3N − 3)).
        let degrees = 3.0 * 3999.0;
        let z = (particles.twice_kinetic_energy(Workers::One) / (0.7 * degrees) - 1.0) / (2.0 / degrees).sqrt();
        assert!(z.abs() < 3.0, "z = {z}");
    }

    #[test]
    fn random_starts_of_hard_cores_are_relaxed() {
        let region = PeriodicBox::new([8.4; 3]).unwrap();
        let law = LennardJones { epsilon: 1.0, sigma: 1.0, cutoff: 2.5, truncation: Truncation::ForceShifted };
        let interactions = Interactions::uniform(Some(Potential::LennardJones(law)), None, 1.0);
        let sites = positions(Start::Random, 500, &region, NOISE());
        let particles = Particles::at_rest(sites, vec![0; 500], &[1.0]);
        let mut system = System::new(particles, region, interactions, 0.3, Workers::One).unwrap();
        relax_overlaps(&mut system, 1.0).unwrap();
        system.update_forces();
        let largest = system.forces().iter().map(|f| dot(f.vector(), f.vector()).sqrt()).fold(0.0, f64::max);
        assert!(largest <= 100.0, "largest force {largest}");
    }
}
