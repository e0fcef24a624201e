//! The particles of a checkpoint of an earlier run, as the start of a new one.

use super::{Bond, Configuration, ConfigurationError, Motion, Named};
use crate::checkpoint::decode;
use crate::state::Head;
use mesoflux_core::simulation::SimulationSnapshot;

/// Reads the contents of a checkpoint.
///
/// # Errors
/// Contents that are damaged, or of another version of the program.
pub(super) fn parse(name: &str, contents: &[u8]) -> Result<Configuration, ConfigurationError> {
    let refused = |reason: String| ConfigurationError::Checkpoint { path: name.to_owned(), reason };
    let state = decode(contents).map_err(refused)?;
    let head = Head::read(state).map_err(refused)?;
    let (_, snapshot): (Head, SimulationSnapshot) = postcard::take_from_bytes(state)
        .map(|(found, _)| found)
        .map_err(|error| refused(format!("holds a state that can't be read: {error}")))?;
    let system = snapshot.system;
    let particles = &system.particles;
    let bonds_known = system.bonds.iter().all(|bond| usize::from(bond.law) < head.bonds.len());
    if !particles.is_consistent(head.species.len()) || !bonds_known {
        return Err(refused("holds particles that are not consistent".to_owned()));
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
