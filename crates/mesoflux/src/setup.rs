//! The simulation of one task at its start: particles placed, overlaps relaxed, momenta drawn, driving attached.

use crate::job::JobError;
use crate::plan::{PointPlan, Task};
use crate::route::RunKind;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{deal_species, draw_momenta, positions, relax_overlaps};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_io::input::Input;

/// The simulation of one task at its start.
pub(crate) fn simulation(point: &PointPlan, task: Task, workers: Workers, place: &str) -> Result<Simulation, JobError> {
    let input = &point.input;
    let kind = &point.runs[task.run];
    let [route, forcing, strength] = kind.identity();
    let noise = NoiseKey::new(&[input.run.seed, task.point as u64, route, forcing, strength, task.replica]);
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let system = start(input, noise, workers, place)?;
    let driving: Option<Box<dyn Driving>> = match *kind {
        RunKind::Equilibrium => None,
        RunKind::Nemd { forcing, magnitude } => {
            let forcing = forcing.forcing(system.particles.count()).map_err(|error| refused(error.to_string()))?;
            Some(Box::new(ConstantForce::new(forcing, magnitude)))
        }
        RunKind::Norton { forcing, flux } => {
            let forcing = forcing.forcing(system.particles.count()).map_err(|error| refused(error.to_string()))?;
            Some(Box::new(ConstantFlux::new(forcing, flux)))
        }
    };
    let integrator = input.integrator().map_err(|error| refused(error.to_string()))?;
    Simulation::new(system, integrator, driving, noise, input.dynamics.time_step)
        .map_err(|error| refused(error.to_string()))
}

/// The system of an input: particles placed, overlaps relaxed, momenta drawn.
fn start(input: &Input, noise: NoiseKey, workers: Workers, place: &str) -> Result<System, JobError> {
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let region = input.region().map_err(|error| refused(error.to_string()))?;
    let species = deal_species(&input.species_counts(), noise);
    let positions = positions(input.system.start, species.len(), &region, noise);
    let particles = Particles::at_rest(positions, species, &input.masses());
    let mut system = System::new(particles, region, input.interactions(), input.skin(), workers)
        .map_err(|error| refused(error.to_string()))?;
    if input.system.start == mesoflux_core::start::Start::Random {
        relax_overlaps(&mut system, input.dynamics.temperature)
            .map_err(|source| JobError::Simulation { place: format!("{place}, relaxing the start"), source })?;
    }
    draw_momenta(&mut system.particles, input.dynamics.temperature, noise);
    Ok(system)
}
