//! Start configurations: particles read from the files of other programs, or from a checkpoint of an earlier run.
//!
//! Extended XYZ (`extended_xyz`) and LAMMPS data files (`lammps_data`) are read. Whatever would be lost on the way into
//! mesoflux (charges, angles, boxes that aren't orthorhombic or periodic) is refused; coefficients of laws are passed over,
//! for laws come from the input file.

mod checkpoint;
pub mod extended_xyz;
pub mod lammps_data;
mod text;

use mesoflux_core::vector::Vector;
use std::path::Path;

/// A configuration that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigurationError {
    /// The file can't be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file says something that it must not.
    #[error("{path}: line {line}: {reason}")]
    Wrong {
        /// The file.
        path: String,
        /// The line, numbered from 1; where something is missing, the last one before its place.
        line: u64,
        /// What is there, and what must be.
        reason: String,
    },
    /// The file is no whole checkpoint.
    #[error("{path}: {reason}")]
    Checkpoint {
        /// The file.
        path: String,
        /// What gave it away.
        reason: String,
    },
}

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Extended XYZ, as OVITO and ASE write it.
    ExtendedXyz,
    /// The data file of LAMMPS, as `write_data` writes it.
    LammpsData,
    /// A checkpoint of mesoflux.
    Checkpoint,
}

/// A name, and where it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// The name.
    pub name: String,
    /// The line of the file.
    pub line: u64,
}

/// A bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bond {
    /// Which kind of bond, from 0.
    pub kind: u32,
    /// One particle, from 0.
    pub first: u64,
    /// The other.
    pub second: u64,
}

/// How the particles move.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// v, one a particle.
    Velocities(Vec<Vector>),
    /// p = m v, one a particle.
    Momenta(Vec<Vector>),
}

/// Particles as a file gives them.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// L_x, L_y, L_z.
    pub sides: Vector,
    /// The species in the order of the numbers below: their names, and the line where each is first met.
    pub species: Vec<Named>,
    /// Which of them each particle is.
    pub kinds: Vec<u32>,
    /// Positions relative to the lower corner of the box; may lie outside it (periodic images).
    pub positions: Vec<Vector>,
    /// Velocities or momenta, where the file has them.
    pub motion: Option<Motion>,
    /// Masses by species, where the file has them.
    pub masses: Vec<Option<f64>>,
    /// Bonds: which kind, and which two particles (numbers from 0).
    pub bonds: Vec<Bond>,
    /// The kinds of bonds.
    pub bond_kinds: Vec<Named>,
}

impl Configuration {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that can't be read, or that isn't a whole configuration in this format.
    pub fn read(path: &Path, format: Format) -> Result<Self, ConfigurationError> {
        Self::read_as(&path.display().to_string(), path, format)
    }

    /// Reads the file at `path`, which messages call `name`.
    ///
    /// # Errors
    /// A file that can't be read, or that isn't a whole configuration in this format.
    pub fn read_as(name: &str, path: &Path, format: Format) -> Result<Self, ConfigurationError> {
        // A device or a pipe might never end.
        let is_file = std::fs::metadata(path).map(|metadata| metadata.is_file());
        let refused = || std::io::Error::new(std::io::ErrorKind::InvalidInput, "must be a file");
        let is_file = is_file.and_then(|is_file| if is_file { Ok(()) } else { Err(refused()) });
        let unreadable = |source| ConfigurationError::Read { path: name.to_owned(), source };
        is_file.map_err(unreadable)?;
        let contents = || std::fs::read(path).map_err(unreadable);
        match format {
            Format::ExtendedXyz => extended_xyz::parse(name, &contents()?),
            Format::LammpsData => lammps_data::parse(name, &contents()?),
            Format::Checkpoint => checkpoint::read(name, path),
        }
    }
}
