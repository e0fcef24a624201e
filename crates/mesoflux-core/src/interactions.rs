//! Which laws act between which species.

use crate::friction::{Dependence, Friction};
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

    /// The number of kinds of pairs, bonded or not.
    pub fn kinds(&self) -> usize {
        self.species * (self.species + 1) / 2
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

    /// The table with a further set of entries for each exclusion but none; see [`Interactions::with_exclusions`].
    fn extended(mut self, entry: impl Fn(Exclusion, &T) -> T) -> Self {
        let kinds = self.kinds();
        for exclusion in 1..Exclusion::COUNT {
            let further: Vec<T> = self.entries[..kinds].iter().map(|law| entry(Exclusion(exclusion), law)).collect();
            self.entries.extend(further);
        }
        self
    }

    /// All entries, in the order of their kinds.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }
}

/// Which pair laws two particles don't feel, because bonds join them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exclusion(u8);

impl Exclusion {
    const COUNT: u8 = 4;

    /// The exclusion of a potential, a friction, both or neither.
    pub fn new(potential: bool, friction: bool) -> Self {
        Self(u8::from(potential) + 2 * u8::from(friction))
    }

    /// Whether the potential is not felt.
    pub fn potential(self) -> bool {
        self.0 & 1 != 0
    }

    /// Whether the friction is not felt.
    pub fn friction(self) -> bool {
        self.0 & 2 != 0
    }

    /// The kind of a pair with this exclusion where there are `kinds` without.
    #[inline(always)]
    pub fn kind(self, kind: Kind, kinds: usize) -> Kind {
        kind + Kind::from(self.0) * kinds as Kind
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
            potentials: PairTable { species: 1, entries: vec![potential] },
            frictions: PairTable { species: 1, entries: vec![friction] },
            inverse_reduced_masses: PairTable::from_fn(1, |_, _| 2.0 / mass),
        }
    }

    /// The largest cutoff of any law.
    pub fn cutoff(&self) -> f64 {
        let potentials = self.potentials.entries().iter().flatten().map(Potential::cutoff);
        let frictions = self.frictions.entries().iter().flatten().map(Friction::cutoff);
        potentials.chain(frictions).fold(0.0, f64::max)
    }

    /// On what frictions depend beside the distance: that which depends on most.
    pub fn friction_dependence(&self) -> Dependence {
        let frictions = self.frictions.entries().iter().flatten();
        frictions.map(Friction::dependence).max().unwrap_or(Dependence::Distance)
    }

    /// Whether all pairs are of one kind.
    #[inline(always)]
    pub fn single_kind(&self) -> bool {
        self.potentials.entries().len() == 1
    }

    /// The laws where some pairs are excluded from some of them: every exclusion in `occurring` makes kinds of its own.
    ///
    /// An exclusion takes the whole law away, friction and noise together: the balance between the two can't be broken.
    #[must_use]
    pub fn with_exclusions(self, occurring: &[Exclusion]) -> Self {
        let felt = |exclusion: Exclusion, excluded: bool| !excluded && occurring.contains(&exclusion);
        Self {
            potentials: self.potentials.extended(|e, law| law.clone().filter(|_| felt(e, e.potential()))),
            frictions: self.frictions.extended(|e, law| law.clone().filter(|_| felt(e, e.friction()))),
            inverse_reduced_masses: self.inverse_reduced_masses.extended(|_, &mass| mass),
        }
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

    #[test]
    fn excluded_pairs_have_kinds_of_their_own() {
        use crate::potential::soft::Soft;
        let soft = |repulsion: f64| Some(Potential::Soft(Soft { repulsion, cutoff: 1.0 }));
        let laws = Interactions {
            potentials: PairTable::from_fn(2, |a, b| soft((a + b) as f64)),
            frictions: PairTable::from_fn(2, |_, _| None),
            inverse_reduced_masses: PairTable::from_fn(2, |_, _| 2.0),
        };
        let (no_potential, no_friction) = (Exclusion::new(true, false), Exclusion::new(false, true));
        let extended = laws.clone().with_exclusions(&[no_potential, no_friction]);
        let kind = |exclusion: Exclusion| usize::from(exclusion.kind(PairTable::<()>::kind(1, 0), 3));
        assert_eq!(extended.potentials.entries()[kind(Exclusion::default())], soft(1.0));
        assert_eq!(extended.potentials.entries()[kind(no_friction)], soft(1.0));
        assert_eq!(extended.potentials.entries()[kind(no_potential)], None);
        assert_eq!(extended.potentials.entries()[kind(Exclusion::new(true, true))], None);
        assert!(laws.with_exclusions(&[no_potential]).potentials.entries()[kind(no_friction)].is_none(), "never met");
    }
}
