//! `system.start`: a lattice, random places, or the particles of a file.

use super::document::InputError;
use super::validate::{Invalid, rounded};
use super::wording::one_of;
use super::{Input, SpeciesInput};
use crate::configuration::{Configuration, ConfigurationError, Format, Named};
use mesoflux_core::start::Start;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Masses and sides of a file that differ by less are equal: files round.
const ROUNDING: f64 = 1e-6;

/// Where the particles start.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartInput {
    /// A simple cubic lattice.
    #[default]
    CubicLattice,
    /// A face-centered cubic lattice.
    FccLattice,
    /// Uniformly at random; overlaps are relaxed where a law has a hard core.
    Random,
    /// The last frame of an extended XYZ file.
    ExtendedXyz(FileStart),
    /// A data file of LAMMPS.
    LammpsData(FileStart),
    /// A checkpoint of an earlier run.
    Checkpoint(FileStart),
}

/// A start from a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileStart {
    /// The file, as seen from the input file.
    pub path: String,
    /// Whether the momenta are the file's.
    #[serde(default)]
    pub momenta: MomentaStart,
    /// Whether overlapping particles are moved apart.
    #[serde(default)]
    pub relax: bool,
    /// The names that the file's species have here, where they have another one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub species: BTreeMap<String, String>,
    /// The names that the file's kinds of bonds have here, where they have another one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub bonds: BTreeMap<String, String>,
}

/// Where the momenta come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MomentaStart {
    /// From the file, without the motion of the center of mass; drawn from Maxwell's distribution if the file has none.
    #[default]
    Keep,
    /// From Maxwell's distribution, other ones in every run.
    Draw,
}

/// The particles of a file, with its names translated into those of the input.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The file, as the input names it.
    pub path: String,
    /// What the file says.
    pub configuration: Arc<Configuration>,
    /// The input's species, as an index, of each of the file's.
    pub species: Vec<u8>,
    /// The input's bond, as an index, of each of the file's kinds of bonds.
    pub bonds: Vec<u16>,
}

/// Where the files that an input names are found; each is read once.
#[derive(Debug, Default)]
pub struct Files {
    directory: PathBuf,
    kept: bool,
    read: Mutex<BTreeMap<PathBuf, Arc<Configuration>>>,
}

impl Files {
    /// Paths are relative to a directory, that of the input file.
    pub fn beside(directory: &Path) -> Self {
        Self { directory: directory.to_owned(), ..Self::default() }
    }

    /// The files are copies that a run keeps in a directory, under the names that [`Files::kept_name`] gives.
    pub fn kept_in(directory: &Path) -> Self {
        Self { directory: directory.to_owned(), kept: true, ..Self::default() }
    }

    /// The name under which a run keeps its copy of the file at a path: files of one name from different places don't meet.
    pub fn kept_name(path: &str) -> String {
        let name = Path::new(path).file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        format!("{:08x}-{name}", crc32fast::hash(path.as_bytes()))
    }

    /// Where the file of a path is.
    pub fn locate(&self, path: &str) -> PathBuf {
        if self.kept { self.directory.join(Self::kept_name(path)) } else { self.directory.join(path) }
    }

    fn read(&self, format: Format, path: &str) -> Result<Arc<Configuration>, ConfigurationError> {
        let place = self.locate(path);
        let mut read = self.read.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(configuration) = read.get(&place) {
            return Ok(Arc::clone(configuration));
        }
        let configuration = Arc::new(Configuration::read_as(path, &place, format)?);
        read.insert(place, Arc::clone(&configuration));
        Ok(configuration)
    }
}

impl StartInput {
    /// The arrangement, where no file gives the positions.
    pub fn arrangement(&self) -> Option<Start> {
        match self {
            Self::CubicLattice => Some(Start::CubicLattice),
            Self::FccLattice => Some(Start::FccLattice),
            Self::Random => Some(Start::Random),
            Self::ExtendedXyz(_) | Self::LammpsData(_) | Self::Checkpoint(_) => None,
        }
    }

    /// The file, its format, and the name of the key.
    pub fn file(&self) -> Option<(&FileStart, Format, &'static str)> {
        match self {
            Self::CubicLattice | Self::FccLattice | Self::Random => None,
            Self::ExtendedXyz(file) => Some((file, Format::ExtendedXyz, "extended_xyz")),
            Self::LammpsData(file) => Some((file, Format::LammpsData, "lammps_data")),
            Self::Checkpoint(file) => Some((file, Format::Checkpoint, "checkpoint")),
        }
    }
}

/// A start that can't be: the file can't be read, or it doesn't fit the input.
pub(super) enum Unusable {
    File(InputError),
    Wrong(Invalid),
}

impl From<Invalid> for Unusable {
    fn from(invalid: Invalid) -> Self {
        Self::Wrong(invalid)
    }
}

impl Input {
    /// Reads the file of the start, if there is one, and takes over what it decides: particles, box, how many of each species.
    pub(super) fn load(&mut self, files: &Files) -> Result<(), Unusable> {
        let Some((start, format, key)) = self.system.start.file() else { return Ok(()) };
        let key = format!("system.start.{key}");
        let (start, path) = (start.clone(), format!("{key}.path"));
        if start.path.is_empty() {
            return Err(Invalid::new(path, "\"\"", "must be the name of a file").into());
        }
        let configuration = match files.read(format, &start.path) {
            Ok(configuration) => configuration,
            Err(ConfigurationError::Read { path: name, source }) => {
                let name = format!("{name}, named by {path}");
                return Err(Unusable::File(InputError::Read { name, source }));
            }
            Err(ConfigurationError::Wrong { line, reason, .. }) => {
                let reason = format!("line {line}: {reason}");
                return Err(Invalid::new(path, format!("{:?}", start.path), reason).into());
            }
            Err(ConfigurationError::Checkpoint { reason, .. }) => {
                return Err(Invalid::new(path, format!("{:?}", start.path), reason).into());
            }
        };
        let place = Place { key: &key, file: &start.path };
        let known: Vec<String> = self.species().into_iter().map(|(name, _)| name).collect();
        if self.species.is_empty() && configuration.species.len() > 1 {
            let names: Vec<&str> = configuration.species.iter().map(|named| named.name.as_str()).collect();
            let requirement = format!("must be named in [species.NAME]: {} has {}", start.path, names.join(", "));
            return Err(Invalid::new("species", "", requirement).into());
        }
        let species = place.translate("species", &configuration.species, &start.species, &known)?;
        let bonds: Vec<String> = self.bond.keys().cloned().collect();
        let bonds = place.translate("bonds", &configuration.bond_kinds, &start.bonds, &bonds)?;
        self.take_box(&place, &configuration)?;
        self.take_species(&place, &configuration, &species)?;
        self.system.loaded = Some(Arc::new(Loaded {
            path: start.path.clone(),
            species: species.into_iter().map(|index| index as u8).collect(),
            bonds: bonds.into_iter().map(|index| index as u16).collect(),
            configuration,
        }));
        Ok(())
    }

    /// The box of the file, which the input may repeat.
    fn take_box(&mut self, place: &Place, configuration: &Configuration) -> Result<(), Invalid> {
        if let Some(sides) = self.system.sides {
            for (axis, (given, found)) in sides.into_iter().zip(configuration.sides).enumerate() {
                if !((given - found).abs() <= ROUNDING * found) {
                    let requirement = format!("must be left out or be {}, as {} says", rounded(found), place.file);
                    return Err(Invalid::new(format!("system.box.{axis}"), given, requirement));
                }
            }
        }
        self.system.sides = Some(configuration.sides);
        let count = configuration.kinds.len() as u64;
        if let Some(particles) = self.system.particles.filter(|&particles| particles != count) {
            let requirement = format!("must be left out or be {count}, as {} says", place.file);
            return Err(Invalid::new("system.particles", particles, requirement));
        }
        self.system.particles = Some(count);
        Ok(())
    }

    /// How many particles each species has, and masses that agree.
    fn take_species(&mut self, place: &Place, configuration: &Configuration, species: &[usize]) -> Result<(), Invalid> {
        let mut counts = vec![0u64; self.species().len()];
        for &kind in &configuration.kinds {
            counts[species[kind as usize]] += 1;
        }
        for (index, (name, input)) in self.species().into_iter().enumerate() {
            for (from, mass) in configuration.masses.iter().enumerate().filter(|&(from, _)| species[from] == index) {
                if let Some(mass) = mass.filter(|mass| !((mass - input.mass).abs() <= ROUNDING * mass)) {
                    let Named { name: found, line } = &configuration.species[from];
                    let requirement =
                        format!("must be {mass}, the mass of the species {found} in {} (line {line})", place.file);
                    return Err(Invalid::new(format!("species.{name}.mass"), input.mass, requirement));
                }
            }
            if let Some(particles) = input.particles.filter(|&particles| particles != counts[index]) {
                let requirement = format!("must be left out or be {}, as {} says", counts[index], place.file);
                return Err(Invalid::new(format!("species.{name}.particles"), particles, requirement));
            }
        }
        let species = self.species.values_mut().zip(counts);
        species.for_each(|(species, count): (&mut SpeciesInput, u64)| species.particles = Some(count));
        Ok(())
    }
}

/// Where the start stands in the input, and which file it names.
struct Place<'a> {
    key: &'a str,
    file: &'a str,
}

impl Place<'_> {
    /// For each of the file's names its place among the known ones; `given` translates those that differ.
    fn translate(
        &self,
        what: &str,
        found: &[Named],
        given: &BTreeMap<String, String>,
        known: &[String],
    ) -> Result<Vec<usize>, Invalid> {
        let path = format!("{}.{what}", self.key);
        let all: Vec<&str> = known.iter().map(String::as_str).collect();
        for (from, to) in given {
            if !found.iter().any(|named| named.name == *from) {
                let names: Vec<&str> = found.iter().map(|named| named.name.as_str()).collect();
                let requirement = if names.is_empty() {
                    format!("{} has no {what}", self.file)
                } else {
                    format!("must be {} of {}", one_of(&names), self.file)
                };
                return Err(Invalid::new(format!("{path}.{from}"), "", requirement));
            }
            if !known.contains(to) {
                let requirement =
                    format!("must be {}", if all.is_empty() { "named here".into() } else { one_of(&all) });
                return Err(Invalid::new(format!("{path}.{from}"), format!("{to:?}"), requirement));
            }
        }
        let translate = |named: &Named| {
            // A single name of each can only mean the same.
            if let ([_], [_], true) = (found, known, given.is_empty()) {
                return Ok(0);
            }
            let name = given.get(&named.name).unwrap_or(&named.name);
            known.iter().position(|known| known == name).ok_or_else(|| {
                let requirement = format!(
                    "line {} has {what} called {name}: must be {}, or be given such a name by {path}",
                    named.line,
                    if all.is_empty() {
                        format!("named in [{}.NAME]", what.trim_end_matches('s'))
                    } else {
                        one_of(&all)
                    }
                );
                Invalid::new(format!("{}.path", self.key), format!("{:?}", self.file), requirement)
            })
        };
        found.iter().map(translate).collect()
    }
}
