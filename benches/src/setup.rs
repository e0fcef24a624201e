//! From an input file to a simulation at its start.

use crate::failure::Failure;
use crate::task::Drive;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Projection};
use mesoflux_core::forcing::{ColorDrift, ForcingField};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{Start, deal_species, draw_momenta, positions, relax_overlaps};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_io::input::{Input, InputFile, Setting};
use std::path::Path;

/// Reads an input with settings as from `--set`.
pub fn read(path: &Path, settings: &[String]) -> Result<Input, Failure> {
    let settings = settings.iter().map(|text| text.parse::<Setting>()).collect::<Result<Vec<_>, _>>();
    let settings = settings.map_err(Failure::Usage)?;
    Ok(InputFile::read(path, &settings).map_err(Failure::simulation)?.input)
}

/// The simulation of an input; replicas differ in their noise.
pub fn simulation(input: &Input, drive: Drive, replica: u64, workers: Workers) -> Result<Simulation, Failure> {
    let noise = NoiseKey::new(&[input.run.seed, replica]);
    let region = input.region().map_err(Failure::simulation)?;
    let species = deal_species(&input.species_counts(), noise);
    let arrangement = input.system.start.arrangement().unwrap_or_default();
    let sites = positions(arrangement, species.len(), &region, noise);
    let particles = Particles::at_rest(sites, species, &input.masses());
    let mut system =
        System::new(particles, region, input.interactions(), input.skin(), workers).map_err(Failure::simulation)?;
    if arrangement == Start::Random {
        relax_overlaps(&mut system, input.dynamics.temperature).map_err(Failure::simulation)?;
    }
    system.positions_moved().map_err(Failure::simulation)?;
    draw_momenta(&mut system.particles, input.dynamics.temperature, noise);
    let integrator = input.integrator().map_err(Failure::simulation)?;
    let driving = driving(drive);
    Simulation::new(system, integrator, driving, noise, input.dynamics.time_step).map_err(Failure::simulation)
}

fn driving(drive: Drive) -> Option<Box<dyn Driving>> {
    let field = || ForcingField::new(Box::new(ColorDrift));
    match drive {
        Drive::None => None,
        Drive::Nemd(magnitude) => Some(Box::new(ConstantForce::new(field(), magnitude))),
        Drive::Norton(flux) => Some(Box::new(ConstantFlux::new(field(), flux, Projection::default()))),
    }
}
