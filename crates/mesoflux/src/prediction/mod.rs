//! What a job will cost: memory and time, from a small copy of its runs that really runs for a moment.

mod duty;
mod memory;

pub use duty::{Duty, duty};
pub use memory::{Memory, TooLarge, check_memory, free_memory, memory, size};

use crate::job::{JobError, Prepared};
use crate::plan::PointPlan;
use mesoflux_core::run::{Length, Moment, Recorder, run};
use mesoflux_io::input::{Input, StartInput};
use std::time::{Duration, Instant};

/// Samples by which a recorder that remembers earlier ones has as many as it will have.
const FULL: usize = 40;
/// A step at which every recorder takes a sample, whatever its cadence.
const EVERY_CADENCE: u64 = 0;

/// So many steps of production.
fn steps(prepared: &mut Prepared, production: u64) -> Result<(), JobError> {
    let length = Length { equilibration: 0, production };
    let ended = run(&mut prepared.simulation, length, &mut prepared.recorders, |_, _| true);
    ended.map(drop).map_err(|source| JobError::Simulation { place: prepared.place.clone(), source })
}

/// Lets every recorder take as many samples as it remembers, unless that lasts too long.
fn fill(prepared: &mut Prepared, longest: Duration) {
    let Prepared { simulation, recorders, .. } = prepared;
    for recorder in recorders {
        let begin = Instant::now();
        for _ in (0..FULL).take_while(|_| begin.elapsed() < longest) {
            recorder.observe(&mut Moment { simulation, step: EVERY_CADENCE, driven: None });
        }
    }
}

/// The point with at most about so many particles, at the same density and with the same laws.
fn shrunk(point: &PointPlan, most: u64) -> PointPlan {
    let count = point.input.particles();
    let mut input: Input = point.input.clone();
    if count <= most {
        return PointPlan::new(point.conditions.clone(), input);
    }
    let factor = most as f64 / count as f64;
    let side = (input.sides().iter().product::<f64>() * factor).cbrt();
    input.run.skin = Some(point.input.skin());
    input.system.sides = Some([side; 3]);
    input.system.density = None;
    // Lists are as long as the start makes them; but hard cores in random places would have to be relaxed for long.
    let interactions = input.interactions();
    let hard = interactions.potentials.entries().iter().flatten().any(|law| law.contact_distance() > 0.0);
    if hard || input.system.start.arrangement().is_none() {
        input.system.start = StartInput::CubicLattice;
    }
    input.system.loaded = None;
    // Even numbers, for forcings that come in pairs.
    let fewer = |count: u64| (2.0 * (0.5 * count as f64 * factor).round()).max(2.0) as u64;
    input.molecule.values_mut().for_each(|molecule| molecule.count = fewer(molecule.count));
    input.species.values_mut().for_each(|species| species.particles = species.particles.map(fewer));
    input.system.particles = None;
    if input.species.len() <= 1 {
        input.species.values_mut().for_each(|species| species.particles = None);
        input.system.particles = Some(most);
    }
    PointPlan::new(point.conditions.clone(), input)
}
