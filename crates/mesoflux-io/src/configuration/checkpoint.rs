//! The particles of a checkpoint of an earlier run, as the start of a new one.

use super::{Bond, Configuration, ConfigurationError, Motion, Named};
use crate::checkpoint::{CheckpointError, WholeState};
use crate::state::Head;
use mesoflux_core::simulation::SimulationSnapshot;
use mesoflux_core::snapshot::Snapshot;
use std::path::Path;

/// Reads the checkpoint at `path`, which messages call `name`.
///
/// # Errors
/// A file that is damaged, or of another version of the program.
pub(super) fn read(name: &str, path: &Path) -> Result<Configuration, ConfigurationError> {
    let taken = WholeState::open(path, name).and_then(|state| {
        state.read(|values| {
            let head = Head::read(values)?;
            let unreadable = |error| format!("holds a state that can't be read: {error}");
            configuration(&head, &values.next_value::<SimulationSnapshot>().map_err(unreadable)?.system)
        })
    });
    taken.map_err(|error| match error {
        CheckpointError::Read { path, source } => ConfigurationError::Read { path, source },
        CheckpointError::Damaged { path, reason } => ConfigurationError::Checkpoint { path, reason },
        none @ CheckpointError::NoneWhole(_) => {
            ConfigurationError::Checkpoint { path: name.to_owned(), reason: none.to_string() }
        }
    })
}

/// The particles of a state, in the order of their ids.
fn configuration(head: &Head, system: &Snapshot) -> Result<Configuration, String> {
    let particles = &system.particles;
    let bonds_known = system.bonds.iter().all(|bond| usize::from(bond.law) < head.bonds.len());
    if !particles.is_consistent(head.species.len()) || !bonds_known {
        return Err("holds particles that are not consistent".to_owned());
    }
    let count = particles.count();
    let mut place = vec![0; count];
    particles.id.iter().enumerate().for_each(|(k, &id)| place[id as usize] = k);
    let species = |kind: usize| particles.species.iter().position(|&species| usize::from(species) == kind);
    let named = |name: &String| Named { name: name.clone(), line: 1 };
    Ok(Configuration {
        sides: system.sides,
        species: head.species.iter().map(named).collect(),
        kinds: place.iter().map(|&k| u32::from(particles.species[k])).collect(),
        positions: place.iter().map(|&k| particles.position[k]).collect(),
        motion: Some(Motion::Momenta(place.iter().map(|&k| particles.momentum[k]).collect())),
        masses: (0..head.species.len()).map(|kind| Some(1.0 / particles.inverse_mass[species(kind)?])).collect(),
        bonds: system
            .bonds
            .iter()
            .map(|bond| Bond { kind: bond.law.into(), first: bond.first.into(), second: bond.second.into() })
            .collect(),
        bond_kinds: head.bonds.iter().map(named).collect(),
    })
}
