//! The simulation of one task at its start: particles placed or read, overlaps relaxed, momenta drawn, driving attached.

use crate::job::JobError;
use crate::plan::{PointPlan, Task};
use crate::route::RunKind;
use mesoflux_core::bond::Topology;
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Exchange, MomentumExchange, mean_field_viscosity};
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_core::integrate::Integrator;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{
    Start, chain, check_overlaps, deal_species, draw_free_momenta, positions, relax_overlaps, remove_drift,
};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_io::configuration::Motion;
use mesoflux_io::input::{Input, Loaded, MomentaStart};

/// The simulation of one task at its start.
pub(crate) fn simulation(point: &PointPlan, task: Task, workers: Workers, place: &str) -> Result<Simulation, JobError> {
    let kind = &point.runs[task.run];
    let compressed;
    let input = match *kind {
        RunKind::AtDensity { factor } => {
            compressed = point.input.at_density(factor);
            &compressed
        }
        _ => &point.input,
    };
    let identity = [vec![input.run.seed, task.point as u64], kind.identity(), vec![task.replica]].concat();
    let noise = NoiseKey::new(&identity);
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let integrator = input.integrator().map_err(|error| refused(error.to_string()))?;
    let system = start(input, &integrator, noise, workers, place)?;
    let field = |forcing: &ForcingChoice| {
        forcing.field(system.particles.count(), system.region.sides()).map_err(|error| refused(error.to_string()))
    };
    let driving: Option<Box<dyn Driving>> = match kind {
        RunKind::Equilibrium | RunKind::AtDensity { .. } => None,
        RunKind::Nemd { forcing, magnitude } => Some(Box::new(ConstantForce::new(field(forcing)?, *magnitude))),
        RunKind::Norton { forcing, flux, projection } => {
            Some(Box::new(ConstantFlux::new(field(forcing)?, *flux, *projection)))
        }
        &RunKind::MomentumExchange { slabs, strength, interval, predicted_viscosity } => {
            let exchange = input.exchange(slabs.gradient, strength, interval);
            let stress = match exchange {
                Exchange::Forced { momentum } => momentum / input.momentum_over_stress(slabs.gradient, interval),
                Exchange::Swap => 0.0,
            };
            let viscosity = predicted_viscosity.or_else(|| predicted(&system, input.dynamics.temperature));
            let gradient = viscosity.map_or(0.0, |viscosity| stress / viscosity);
            Some(Box::new(MomentumExchange::new(slabs, exchange, interval, gradient)))
        }
    };
    let mut simulation = Simulation::new(system, integrator, driving, noise, input.dynamics.time_step)
        .map_err(|error| refused(error.to_string()))?;
    simulation.book_stress(point.users(task.run).any(|user| point.measurements[user].route.books_stress()));
    Ok(simulation)
}

/// The viscosity by mean-field theory; of hard cores, whose viscosity is mostly that of their potential, nothing is known.
fn predicted(system: &System, temperature: f64) -> Option<f64> {
    let hard = system.interactions.potentials.entries().iter().flatten().any(|law| law.contact_distance() > 0.0);
    if hard { None } else { mean_field_viscosity(system, temperature) }
}

/// The system of an input: particles placed and bonded, overlaps relaxed, momenta drawn.
fn start(
    input: &Input,
    integrator: &Integrator,
    noise: NoiseKey,
    workers: Workers,
    place: &str,
) -> Result<System, JobError> {
    let refused = |reason: String| JobError::Setup { place: place.to_owned(), reason };
    let region = input.region().map_err(|error| refused(error.to_string()))?;
    let temperature = input.dynamics.temperature;
    let (particles, relax, drawn) = if let Some(loaded) = &input.system.loaded {
        read(input, loaded)
    } else {
        let arrangement = input.system.start.arrangement().unwrap_or_default();
        let relax = arrangement == Start::Random || !input.molecule.is_empty();
        (arranged(input, arrangement, &region, noise), relax, true)
    };
    let topology = Topology::new(particles.count(), input.bond_laws(), input.bonds(), input.exclusion_range());
    let mut system = System::new(particles, region, input.interactions(), input.skin(), workers)
        .map_err(|error| refused(error.to_string()))?
        .with_bonds(topology.map_err(|error| refused(error.to_string()))?)
        .with_fields(input.fields(&region).map_err(|error| refused(error.to_string()))?)
        .with_integrator(integrator);
    let unfit = |source| JobError::Simulation { place: format!("{place}, start"), source };
    if relax {
        relax_overlaps(&mut system, temperature).map_err(unfit)?;
    }
    check_overlaps(&mut system, temperature)
        .map_err(|source| JobError::Overlap { place: place.to_owned(), source: Box::new(source) })?;
    system.positions_moved().map_err(unfit)?;
    if drawn {
        draw_free_momenta(&mut system.particles, temperature, noise);
    }
    let conserved = system.conserved_momentum();
    remove_drift(&mut system.particles, conserved);
    Ok(system)
}

/// Molecules first, as random walks, then all other particles as the start arranges them.
fn arranged(input: &Input, arrangement: Start, region: &PeriodicBox, noise: NoiseKey) -> Particles {
    let interactions = input.interactions();
    let laws = input.bond_laws();
    let mut free = input.species_counts();
    let (mut species, mut sites) = (Vec::new(), Vec::new());
    for molecule in input.chains() {
        let length = |pair: &[u8]| {
            let potential = interactions
                .potentials
                .get(pair[0], pair[1])
                .as_ref()
                .filter(|_| input.exclusions.potential_within == 0);
            laws[usize::from(molecule.bond)].most_likely_length(potential, input.dynamics.temperature)
        };
        let lengths: Vec<f64> = molecule.species.windows(2).map(length).collect();
        for _ in 0..molecule.count {
            sites.extend(chain(&lengths, sites.len() as u64, region, noise));
            species.extend_from_slice(&molecule.species);
        }
    }
    species.iter().for_each(|&kind| free[usize::from(kind)] -= 1);
    let dealt = deal_species(&free, noise);
    let placed = positions(arrangement, dealt.len(), region, noise);
    Particles::at_rest(followed_by(sites, placed), followed_by(species, dealt), &input.masses())
}

/// One list after the other; where the first is empty, the second as it is.
fn followed_by<T>(mut first: Vec<T>, second: Vec<T>) -> Vec<T> {
    if first.is_empty() {
        return second;
    }
    first.reserve_exact(second.len());
    first.extend(second);
    first
}

/// The particles of a file; whether they are to be relaxed; whether their momenta are to be drawn.
fn read(input: &Input, loaded: &Loaded) -> (Particles, bool, bool) {
    let configuration = &loaded.configuration;
    let species = configuration.kinds.iter().map(|&kind| loaded.species[kind as usize]).collect();
    let mut particles = Particles::at_rest(configuration.positions.clone(), species, &input.masses());
    let (relax, momenta) =
        input.system.start.file().map_or_else(Default::default, |(file, ..)| (file.relax, file.momenta));
    let motion = configuration.motion.as_ref().filter(|_| momenta == MomentaStart::Keep);
    match motion {
        Some(Motion::Momenta(momenta)) => particles.momentum.clone_from(momenta),
        Some(Motion::Velocities(velocities)) => {
            particles.momentum =
                velocities.iter().zip(&particles.inverse_mass).map(|(v, w)| v.map(|component| component / w)).collect();
        }
        None => {}
    }
    (particles, relax, motion.is_none())
}
