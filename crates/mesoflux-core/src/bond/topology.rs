//! Who is bonded to whom, the forces of the bonds, and which pairs the bonds exclude from the pair laws.

use super::BondLaw;
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::interactions::Exclusion;
use crate::lanes::Row;
use crate::pair::PairSums;
use crate::state::Particles;
use crate::tensor::SymmetricTensor;
use crate::vector::{Vector, add_scaled, dot, subtract};
use serde::{Deserialize, Serialize};

/// A bond between two particles, by their ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bond {
    /// Index of its law.
    pub law: u16,
    /// The id of one particle.
    pub first: u32,
    /// The id of the other.
    pub second: u32,
}

/// Up to how many bonds away particles don't feel each other's pair laws; 0 excludes nobody, 1 those that are bonded, and so on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExclusionRange {
    /// For the potential.
    pub potential: u8,
    /// For the friction with its noise.
    pub friction: u8,
}

/// Bonds that can't be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TopologyError {
    /// A particle that isn't there.
    #[error("bond {bond} joins the particles {first} and {second}: must be two different ones below {count}")]
    Particle {
        /// Which bond.
        bond: usize,
        /// One id.
        first: u32,
        /// The other.
        second: u32,
        /// N.
        count: usize,
    },
    /// A law that isn't there.
    #[error("bond {bond} follows the law {law}: must be below {count}")]
    Law {
        /// Which bond.
        bond: usize,
        /// Its law.
        law: u16,
        /// How many there are.
        count: usize,
    },
    /// The same two particles again.
    #[error("the particles {first} and {second} are bonded twice: must be bonded once at most")]
    Twice {
        /// One id.
        first: u32,
        /// The other.
        second: u32,
    },
}

/// A bond as one of its particles sees it.
#[derive(Debug, Clone, Copy)]
struct End {
    partner: u32,
    law: u16,
}

/// Lists of different lengths, one for each particle by id, stored one after the other.
#[derive(Debug, Clone)]
struct Lists<T> {
    starts: Vec<u32>,
    entries: Vec<T>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { starts: Vec::new(), entries: Vec::new() }
    }
}

impl<T> Lists<T> {
    fn new(lists: Vec<Vec<T>>) -> Self {
        let mut starts = vec![0];
        let mut entries = Vec::new();
        for list in lists {
            entries.extend(list);
            starts.push(entries.len() as u32);
        }
        Self { starts, entries }
    }

    #[inline(always)]
    fn of(&self, id: u64) -> &[T] {
        let id = id as usize;
        &self.entries[self.starts[id] as usize..self.starts[id + 1] as usize]
    }
}

/// A bond that came too long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Broken {
    pub first: u64,
    pub second: u64,
    pub length: f64,
    pub longest: f64,
}

/// All bonds of a system.
#[derive(Debug, Clone, Default)]
pub struct Topology {
    laws: Vec<BondLaw>,
    bonds: Vec<Bond>,
    range: ExclusionRange,
    ends: Lists<End>,
    excluded: Lists<(u32, Exclusion)>,
    occurring: Vec<Exclusion>,
    /// The place in storage of every particle, by id.
    place: Vec<u32>,
}

impl Topology {
    /// The bonds of `count` particles.
    ///
    /// # Errors
    /// Bonds of particles or laws that aren't there, a particle bonded to itself, two bonds between the same particles.
    pub fn new(
        count: usize,
        laws: Vec<BondLaw>,
        bonds: Vec<Bond>,
        range: ExclusionRange,
    ) -> Result<Self, TopologyError> {
        let mut ends = vec![Vec::new(); if bonds.is_empty() { 0 } else { count }];
        for (number, &Bond { law, first, second }) in bonds.iter().enumerate() {
            if first == second || first.max(second) as usize >= count {
                return Err(TopologyError::Particle { bond: number, first, second, count });
            }
            if usize::from(law) >= laws.len() {
                return Err(TopologyError::Law { bond: number, law, count: laws.len() });
            }
            if ends[first as usize].iter().any(|end: &End| end.partner == second) {
                return Err(TopologyError::Twice { first, second });
            }
            ends[first as usize].push(End { partner: second, law });
            ends[second as usize].push(End { partner: first, law });
        }
        let ends = Lists::new(ends);
        let farthest = range.potential.max(range.friction);
        let excluded = if farthest == 0 || bonds.is_empty() {
            Lists::default()
        } else {
            let exclusion = |bonds: u8| Exclusion::new(bonds <= range.potential, bonds <= range.friction);
            let within = |id: usize| within_bonds(&ends, id as u64, farthest).into_iter();
            Lists::new(
                (0..count).map(|id| within(id).map(|(other, bonds)| (other, exclusion(bonds))).collect()).collect(),
            )
        };
        let mut occurring: Vec<Exclusion> = Vec::new();
        for &(_, exclusion) in &excluded.entries {
            if !occurring.contains(&exclusion) {
                occurring.push(exclusion);
            }
        }
        Ok(Self { laws, bonds, range, ends, excluded, occurring, place: Vec::new() })
    }

    /// The laws.
    pub fn laws(&self) -> &[BondLaw] {
        &self.laws
    }

    /// The bonds, as they were given.
    pub fn bonds(&self) -> &[Bond] {
        &self.bonds
    }

    /// How far exclusions reach.
    pub fn range(&self) -> ExclusionRange {
        self.range
    }

    /// The kinds of exclusions that occur.
    pub fn exclusions(&self) -> &[Exclusion] {
        &self.occurring
    }

    /// What the particles of two ids don't feel of each other.
    #[inline(always)]
    pub fn exclusion(&self, first: u64, second: u64) -> Exclusion {
        if self.occurring.is_empty() {
            return Exclusion::default();
        }
        let entry = self.excluded.of(first).iter().find(|&&(partner, _)| u64::from(partner) == second);
        entry.map_or(Exclusion::default(), |&(_, exclusion)| exclusion)
    }

    /// Must be called whenever the particles' places in storage change.
    pub(crate) fn follow(&mut self, id: &[u64]) {
        if !self.bonds.is_empty() {
            self.place.resize(id.len(), 0);
            for (place, &id) in id.iter().enumerate() {
                self.place[id as usize] = place as u32;
            }
        }
    }

    /// Adds f_i = Σ_bonds f(r_ij) e_ij for every particle, r_ij being the nearest image.
    ///
    /// Each end works out its own half, which is exactly the opposite of the other's: no two particles write to one place.
    pub(crate) fn add_forces(&self, particles: &Particles, region: &PeriodicBox, force: &mut [Row], workers: Workers) {
        if self.bonds.is_empty() {
            return;
        }
        workers.for_each_chunk(force, |offset, forces| {
            for (k, row) in forces.iter_mut().enumerate() {
                let mut force = row.vector();
                let place = offset + k;
                for end in self.ends.of(particles.id[place]) {
                    let d = self.separation(particles, region, place, end.partner);
                    let r = dot(d, d).sqrt();
                    let magnitude = self.laws[usize::from(end.law)].force(r);
                    add_scaled(&mut force, if r > 0.0 { magnitude / r } else { 0.0 }, d);
                }
                *row = Row::new(force, 0.0);
            }
        });
    }

    /// Calls `visit` with every bond, the places in storage of its two particles, and r_first − r_second.
    pub(crate) fn for_each_bond(
        &self,
        particles: &Particles,
        region: &PeriodicBox,
        mut visit: impl FnMut(&Bond, [usize; 2], Vector),
    ) {
        for bond in &self.bonds {
            let places = [bond.first, bond.second].map(|id| self.place[id as usize] as usize);
            visit(bond, places, self.separation(particles, region, places[0], bond.second));
        }
    }

    /// Calls `visit` with every bond and its length.
    pub fn for_each_length(&self, particles: &Particles, region: &PeriodicBox, mut visit: impl FnMut(&Bond, f64)) {
        self.for_each_bond(particles, region, |bond, _, d| visit(bond, dot(d, d).sqrt()));
    }

    /// Energy, virial and Laplacian of all bonds.
    pub(crate) fn sums(&self, particles: &Particles, region: &PeriodicBox) -> PairSums {
        let mut sums = PairSums::default();
        self.for_each_length(particles, region, |bond, r| {
            let law = &self.laws[usize::from(bond.law)];
            let force = law.force(r);
            sums.potential_energy += law.energy(r);
            sums.virial += r * force;
            sums.laplacian -= 2.0 * (law.force_derivative(r) + 2.0 * force / r);
        });
        sums
    }

    /// Σ r f(r) e_a e_b over all bonds.
    pub(crate) fn stress(&self, particles: &Particles, region: &PeriodicBox) -> SymmetricTensor {
        let mut stress = SymmetricTensor::default();
        self.for_each_bond(particles, region, |bond, _, d| {
            let r = dot(d, d).sqrt();
            if r > 0.0 {
                stress += (self.laws[usize::from(bond.law)].force(r) / r) * SymmetricTensor::square(d);
            }
        });
        stress
    }

    /// The first bond as long as it must not be: beyond its law, or so long that its nearest image is another.
    pub(crate) fn broken(&self, particles: &Particles, region: &PeriodicBox) -> Option<Broken> {
        let half = 0.5 * region.shortest_side();
        let mut broken = None;
        self.for_each_length(particles, region, |bond, length| {
            let longest = self.laws[usize::from(bond.law)].longest().min(half);
            if broken.is_none() && !(length < longest) {
                broken = Some(Broken { first: bond.first.into(), second: bond.second.into(), length, longest });
            }
        });
        broken
    }

    /// r_ij of the particle in a place and its partner.
    #[inline(always)]
    fn separation(&self, particles: &Particles, region: &PeriodicBox, place: usize, partner: u32) -> Vector {
        let other = self.place[partner as usize] as usize;
        region.nearest_image(subtract(particles.position[place], particles.position[other]))
    }
}

/// Everybody within so many bonds of a particle, and how many bonds away.
fn within_bonds(ends: &Lists<End>, id: u64, farthest: u8) -> Vec<(u32, u8)> {
    let mut found: Vec<(u32, u8)> = Vec::new();
    let mut shell = vec![id as u32];
    for bonds in 1..=farthest {
        let mut next = Vec::new();
        for &member in &shell {
            for end in ends.of(u64::from(member)) {
                let new = u64::from(end.partner) != id && found.iter().all(|&(other, _)| other != end.partner);
                if new {
                    found.push((end.partner, bonds));
                    next.push(end.partner);
                }
            }
        }
        shell = next;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::harmonic::Harmonic;

    fn chain(length: u32, range: ExclusionRange) -> Topology {
        let law = BondLaw::Harmonic(Harmonic { stiffness: 1.0, length: 1.0 });
        let bonds = (1..length).map(|k| Bond { law: 0, first: k - 1, second: k }).collect();
        Topology::new(length as usize + 1, vec![law], bonds, range).unwrap()
    }

    #[test]
    fn exclusions_reach_as_many_bonds_as_they_should() {
        let topology = chain(6, ExclusionRange { potential: 2, friction: 1 });
        for a in 0..7u64 {
            for b in (0..7).filter(|&b| b != a) {
                let bonds = if a.max(b) < 6 { a.abs_diff(b) } else { 99 };
                assert_eq!(topology.exclusion(a, b), Exclusion::new(bonds <= 2, bonds <= 1), "{a} and {b}");
            }
        }
        let none = chain(6, ExclusionRange::default());
        assert!(none.exclusions().is_empty());
        assert_eq!(none.exclusion(0, 1), Exclusion::default());
    }

    #[test]
    fn a_ring_is_excluded_by_the_shorter_way() {
        let law = BondLaw::Harmonic(Harmonic { stiffness: 1.0, length: 1.0 });
        let bonds = (0..4u32).map(|k| Bond { law: 0, first: k, second: (k + 1) % 4 }).collect();
        let topology = Topology::new(4, vec![law], bonds, ExclusionRange { potential: 1, friction: 0 }).unwrap();
        assert!(topology.exclusion(3, 0).potential() && !topology.exclusion(0, 2).potential());
        assert!(!topology.exclusion(3, 0).friction());
    }

    #[test]
    fn bonds_that_cannot_be_are_refused() {
        let law = BondLaw::Harmonic(Harmonic { stiffness: 1.0, length: 1.0 });
        let refused = |bonds: &[(u16, u32, u32)]| {
            let bonds = bonds.iter().map(|&(law, first, second)| Bond { law, first, second }).collect();
            Topology::new(5, vec![law], bonds, ExclusionRange::default()).unwrap_err()
        };
        assert_eq!(refused(&[(0, 1, 1)]), TopologyError::Particle { bond: 0, first: 1, second: 1, count: 5 });
        assert_eq!(
            refused(&[(0, 0, 1), (0, 2, 5)]),
            TopologyError::Particle { bond: 1, first: 2, second: 5, count: 5 }
        );
        assert_eq!(refused(&[(1, 0, 1)]), TopologyError::Law { bond: 0, law: 1, count: 1 });
        assert_eq!(refused(&[(0, 0, 1), (0, 1, 0)]), TopologyError::Twice { first: 1, second: 0 });
    }
}
