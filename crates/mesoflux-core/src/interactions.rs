//! Which laws act between which species.

use crate::friction::Friction;
use crate::potential::Potential;

/// The number of an unordered pair of species.
pub type Kind = u16;

/// One entry for every unordered pair of species.
#[derive(Debug, Clone, PartialEq)]
pub struct PairTable<T> {
    species: usize,
    entries: Vec<T>,
}

impl<T> PairTable<T> {
    /// A table filled by a function of the two species' indices, the smaller first.
    pub fn from_fn(species: usize, mut entry: impl FnMut(usize, usize) -> T) -> Self {
        let entries = (0..species).flat_map(|b| (0..=b).map(move |a| (a, b))).map(|(a, b)| entry(a, b)).collect();
        Self { species, entries }
    }

    /// The number of species.
    pub fn species(&self) -> usize {
        self.species
    }

    /// The place of a pair of species in the table.
    #[inline(always)]
    pub fn kind(a: u8, b: u8) -> Kind {
        let (low, high) = (u16::from(a.min(b)), u16::from(a.max(b)));
        high * (high + 1) / 2 + low
    }

    /// The entry of a pair of species.
    pub fn get(&self, a: u8, b: u8) -> &T {
        &self.entries[usize::from(Self::kind(a, b))]
    }

    /// All entries, in the order of their kinds.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }
}

/// All pair laws of a system.
#[derive(Debug, Clone, PartialEq)]
pub struct Interactions {
    /// Conservative law of each pair of species.
    pub potentials: PairTable<Option<Potential>>,
    /// Friction law of each pair of species.
    pub frictions: PairTable<Option<Friction>>,
    /// 1/m_i + 1/m_j of each pair of species.
    pub inverse_reduced_masses: PairTable<f64>,
}

impl Interactions {
    /// One potential and one friction for all pairs of equal particles.
    pub fn uniform(potential: Option<Potential>, friction: Option<Friction>, mass: f64) -> Self {
        Self {
            potentials: PairTable::from_fn(1, |_, _| potential),
            frictions: PairTable::from_fn(1, |_, _| friction),
            inverse_reduced_masses: PairTable::from_fn(1, |_, _| 2.0 / mass),
        }
    }

    /// The largest cutoff of any law.
    pub fn cutoff(&self) -> f64 {
        let potentials = self.potentials.entries().iter().flatten().map(Potential::cutoff);
        let frictions = self.frictions.entries().iter().flatten().map(Friction::cutoff);
        potentials.chain(frictions).fold(0.0, f64::max)
    }

    /// Whether all pairs are of one kind.
    #[inline(always)]
    pub fn single_kind(&self) -> bool {
        self.potentials.species() == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_species_has_its_own_place_in_both_orders() {
        let table = PairTable::from_fn(4, |a, b| (a, b));
        for a in 0..4u8 {
            for b in 0..4u8 {
                let expected = (usize::from(a.min(b)), usize::from(a.max(b)));
                assert_eq!(*table.get(a, b), expected);
            }
        }
        assert_eq!(table.entries().len(), 10);
    }
}
