//! `[bond.NAME]`, `[molecule.NAME]` and `[exclusions]`: chains of beads, made by the input.

use super::Input;
use super::validate::{Invalid, number};
use super::validate_system::MOST_PARTICLES;
use super::wording::one_of;
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The most bonds over which pair laws may be excluded.
const FARTHEST_EXCLUSION: u8 = 5;

/// The most species where there are exclusions: each pair of species then has up to four kinds.
const MOST_EXCLUDED_SPECIES: usize = 127;

/// `[bond.NAME]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BondInput {
    /// The law of such bonds.
    pub potential: BondLaw,
}

/// `[molecule.NAME]`: equal chains of beads, each bonded to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoleculeInput {
    /// How many of these molecules there are.
    pub count: u64,
    /// The beads along the chain, block after block.
    pub blocks: Vec<BlockInput>,
    /// The name of the bond between neighbors.
    pub bond: String,
}

/// One of `molecule.NAME.blocks`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockInput {
    /// The species of its beads.
    pub species: String,
    /// How many they are.
    pub beads: u64,
}

/// `[exclusions]`: up to how many bonds away particles don't feel each other's pair laws; 0, the default, excludes nothing, 1
/// those bonded to each other, 2 also those with one bead between them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExclusionsInput {
    /// For the potential.
    #[serde(default)]
    pub potential_within: u8,
    /// For the friction, with its noise.
    #[serde(default)]
    pub friction_within: u8,
}

impl ExclusionsInput {
    /// Whether nothing is excluded.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// One kind of molecules, ready to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    /// How many there are.
    pub count: u64,
    /// The species of each bead, as an index.
    pub species: Vec<u8>,
    /// The law of its bonds, as an index.
    pub bond: u16,
}

impl Input {
    /// The kinds of molecules in the order of their names; their particles come before all others, in this order.
    pub fn chains(&self) -> Vec<Chain> {
        let species: Vec<String> = self.species().into_iter().map(|(name, _)| name).collect();
        let index = |name: &str| species.iter().position(|known| known == name).unwrap_or(0) as u8;
        let bond = |name: &str| self.bond.keys().position(|known| known == name).unwrap_or(0) as u16;
        let chain = |molecule: &MoleculeInput| Chain {
            count: molecule.count,
            species: molecule
                .blocks
                .iter()
                .flat_map(|block| std::iter::repeat_n(index(&block.species), block.beads as usize))
                .collect(),
            bond: bond(&molecule.bond),
        };
        self.molecule.values().map(chain).collect()
    }

    /// The laws of the bonds, in the order of their names.
    pub fn bond_laws(&self) -> Vec<BondLaw> {
        self.bond.values().map(|bond| bond.potential).collect()
    }

    /// All bonds: those that a start from a file brings, else those of the molecules.
    pub fn bonds(&self) -> Vec<Bond> {
        if let Some(loaded) = self.system.loaded.as_ref().filter(|loaded| !loaded.configuration.bonds.is_empty()) {
            let bond = |bond: &crate::configuration::Bond| Bond {
                law: loaded.bonds[bond.kind as usize],
                first: bond.first as u32,
                second: bond.second as u32,
            };
            return loaded.configuration.bonds.iter().map(bond).collect();
        }
        let mut bonds = Vec::new();
        let mut first = 0;
        for Chain { count, species, bond: law } in self.chains() {
            for _ in 0..count {
                let end = first + species.len() as u32;
                bonds.extend((first + 1..end).map(|second| Bond { law, first: second - 1, second }));
                first = end;
            }
        }
        bonds
    }

    /// How far the exclusions reach.
    pub fn exclusion_range(&self) -> ExclusionRange {
        ExclusionRange { potential: self.exclusions.potential_within, friction: self.exclusions.friction_within }
    }

    /// How many beads of each species the molecules have, by its name.
    pub(super) fn beads(&self) -> BTreeMap<String, u64> {
        let mut beads = BTreeMap::new();
        for molecule in self.molecule.values() {
            for block in &molecule.blocks {
                let count: &mut u64 = beads.entry(block.species.clone()).or_default();
                *count = count.saturating_add(block.beads.saturating_mul(molecule.count));
            }
        }
        beads
    }

    /// Checks bonds, molecules and exclusions, each on its own.
    pub(super) fn validate_molecules(&self) -> Result<(), Invalid> {
        for (name, bond) in &self.bond {
            let law = match bond.potential {
                BondLaw::Harmonic(_) => "harmonic",
                BondLaw::Fene(_) => "fene",
            };
            for (parameter, value, requirement) in bond.potential.parameters() {
                number(&format!("bond.{name}.potential.{law}.{parameter}"), value, requirement)?;
            }
        }
        for (name, molecule) in &self.molecule {
            self.validate_molecule(&format!("molecule.{name}"), molecule)?;
        }
        let exclusions = self.exclusions;
        for (key, within) in
            [("potential_within", exclusions.potential_within), ("friction_within", exclusions.friction_within)]
        {
            if within > FARTHEST_EXCLUSION {
                let requirement = format!("must be at most {FARTHEST_EXCLUSION} bonds");
                return Err(Invalid::new(format!("exclusions.{key}"), within, requirement));
            }
        }
        if !exclusions.is_none() && self.species.len() > MOST_EXCLUDED_SPECIES {
            let requirement =
                format!("needs at most {MOST_EXCLUDED_SPECIES} species: there are {}", self.species.len());
            return Err(Invalid::new("exclusions", "", requirement));
        }
        Ok(())
    }

    /// Whether there are as many particles as the molecules have beads.
    pub(super) fn validate_beads(&self) -> Result<(), Invalid> {
        for (species, beads) in self.beads() {
            let given = self.species.get(&species).and_then(|species| species.particles);
            if let Some(particles) = given.filter(|&particles| particles < beads) {
                let requirement = format!("must be at least {beads}, the beads of this species in molecules");
                return Err(Invalid::new(format!("species.{species}.particles"), particles, requirement));
            }
        }
        let beads = self.beads().values().copied().fold(0, u64::saturating_add);
        if beads > self.particles() {
            let requirement = format!("must be at least {beads}, the beads of the molecules");
            return Err(Invalid::new("system.particles", self.particles(), requirement));
        }
        Ok(())
    }

    fn validate_molecule(&self, path: &str, molecule: &MoleculeInput) -> Result<(), Invalid> {
        if molecule.count == 0 {
            return Err(Invalid::new(format!("{path}.count"), 0, "must be at least 1"));
        }
        if !self.bond.contains_key(&molecule.bond) {
            let names: Vec<&str> = self.bond.keys().map(String::as_str).collect();
            let requirement = match names.as_slice() {
                [] => "must be the name of a bond: give its law in [bond.NAME]".to_owned(),
                names => format!("must be the name of a bond, {}", one_of(names)),
            };
            return Err(Invalid::new(format!("{path}.bond"), format!("{:?}", molecule.bond), requirement));
        }
        let species = self.species();
        for (index, block) in molecule.blocks.iter().enumerate() {
            let path = format!("{path}.blocks.{index}");
            if !species.iter().any(|(name, _)| *name == block.species) {
                let names: Vec<&str> = species.iter().map(|(name, _)| name.as_str()).collect();
                let requirement = format!("must be the name of a species, {}", one_of(&names));
                return Err(Invalid::new(format!("{path}.species"), format!("{:?}", block.species), requirement));
            }
            if block.beads == 0 {
                return Err(Invalid::new(format!("{path}.beads"), 0, "must be at least 1"));
            }
        }
        let beads = molecule.blocks.iter().map(|block| block.beads).fold(0, u64::saturating_add);
        if beads < 2 {
            let requirement = "must hold at least two beads in all: a single one has no bonds";
            return Err(Invalid::new(format!("{path}.blocks"), "", requirement));
        }
        if beads.saturating_mul(molecule.count) > MOST_PARTICLES {
            let requirement = format!("must be at most {}: {MOST_PARTICLES} beads", MOST_PARTICLES / beads);
            return Err(Invalid::new(format!("{path}.count"), molecule.count, requirement));
        }
        Ok(())
    }

    /// Whether the particles of a start from a file are those that the molecules say.
    pub(super) fn validate_molecules_of_start(&self) -> Result<(), Invalid> {
        let (Some(loaded), false) = (&self.system.loaded, self.molecule.is_empty()) else { return Ok(()) };
        if !loaded.configuration.bonds.is_empty() {
            let requirement = format!("must be left out: {} brings its own bonds", loaded.path);
            return Err(Invalid::new("molecule", "", requirement));
        }
        let expected = self.chains().into_iter().zip(self.molecule.keys()).flat_map(|(chain, name)| {
            let beads = chain.species.len();
            let all = (0..chain.count).flat_map(move |_| chain.species.clone());
            all.zip((0..beads).cycle()).map(move |(species, bead)| (species, name, bead))
        });
        let names = self.species();
        for (particle, ((species, molecule, bead), &kind)) in expected.zip(&loaded.configuration.kinds).enumerate() {
            let found = loaded.species[kind as usize];
            if found != species {
                let name = |index: u8| &names[usize::from(index)].0;
                let requirement = format!(
                    "particle {} of {} is of the species {}: must be {}, bead {} of molecule.{molecule} (molecules come first, \
                     in the order of their names)",
                    particle + 1,
                    loaded.path,
                    name(found),
                    name(species),
                    bead + 1
                );
                return Err(Invalid::new(format!("molecule.{molecule}"), "", requirement));
            }
        }
        Ok(())
    }
}
