//! What the tests of start configurations share: the files beside this one, and which reader each belongs to.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a test")]

use mesoflux_io::configuration::{Configuration, ConfigurationError, Format, Motion, extended_xyz, lammps_data};
use std::path::{Path, PathBuf};

/// The folder of this name beside this file.
pub fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/configuration").join(name)
}

/// The configurations in a folder, by name.
pub fn files(name: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder(name)).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = entries.filter(|path| !has_extension(path, "expected")).collect();
    paths.sort();
    paths
}

pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|end| end == extension)
}

/// The name without folders.
pub fn bare_name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap()
}

/// The format that a file's name says.
pub fn format_of(path: &Path) -> Format {
    if has_extension(path, "xyz") {
        return Format::ExtendedXyz;
    }
    assert!(has_extension(path, "data"), "{}: must be .xyz, .data or .expected", path.display());
    Format::LammpsData
}

/// Reads a text in a format.
pub fn parse(format: Format, name: &str, text: &[u8]) -> Result<Configuration, ConfigurationError> {
    match format {
        Format::ExtendedXyz => extended_xyz::parse(name, text),
        Format::LammpsData => lammps_data::parse(name, text),
        Format::Checkpoint => panic!("a checkpoint is no text"),
    }
}

/// Asserts what every configuration promises.
pub fn assert_consistent(configuration: &Configuration) {
    let Configuration { sides, species, kinds, positions, motion, masses, bonds, bond_kinds } = configuration;
    assert!(sides.iter().all(|side| side.is_finite() && *side > 0.0));
    assert!((1..=255).contains(&species.len()) && bond_kinds.len() <= 255);
    for names in [species, bond_kinds] {
        assert!(names.iter().all(|named| !named.name.is_empty() && named.line > 0));
        for (place, named) in names.iter().enumerate() {
            assert!(names[..place].iter().all(|other| other.name != named.name), "{named:?} comes twice");
        }
    }
    assert!(!kinds.is_empty() && kinds.len() == positions.len());
    assert!(kinds.iter().all(|kind| (*kind as usize) < species.len()));
    assert!(positions.as_flattened().iter().all(|x| x.is_finite()));
    if let Some(Motion::Velocities(vectors) | Motion::Momenta(vectors)) = motion {
        assert_eq!(vectors.len(), kinds.len());
        assert!(vectors.as_flattened().iter().all(|x| x.is_finite()));
    }
    assert_eq!(masses.len(), species.len());
    assert!(masses.iter().flatten().all(|mass| mass.is_finite() && *mass > 0.0));
    for bond in bonds {
        assert!((bond.kind as usize) < bond_kinds.len() && bond.first != bond.second);
        assert!(bond.first.max(bond.second) < kinds.len() as u64);
    }
}
