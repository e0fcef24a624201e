//! Stopping and going on: a restored simulation takes the same way to the last bit.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
mod common;

use common::forcing;
use mesoflux_core::driving::{ConstantFlux, Driving, Exchange, MomentumExchange, Projection, Slabs};
use mesoflux_core::forcing::{Axis, ForcingKind};
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::friction::{Friction, linear::Linear};
use mesoflux_core::integrate::{Explicit, Integrator, Schedule, SweepOrder, Thermostat, VelocityVerlet};
use mesoflux_core::interactions::Interactions;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::potential::{Potential, soft::Soft};
use mesoflux_core::simulation::Simulation;
use mesoflux_core::snapshot::{Snapshot, SnapshotError};
use mesoflux_core::start::{Start, draw_momenta, positions};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;

#[derive(Clone, Copy)]
enum Driven {
    Not,
    Norton,
    Exchange,
}

fn simulation(integrator: Integrator, driven: Driven) -> Simulation {
    let noise = NoiseKey::new(&[1]);
    let region = PeriodicBox::new([5.0, 4.0, 6.0]).unwrap();
    let potential = Potential::Soft(Soft { repulsion: 25.0, cutoff: 1.0 });
    let friction = Friction::Linear(Linear { coefficient: 4.5, cutoff: 1.0, exponent: 2.0 });
    let interactions = Interactions::uniform(Some(potential), Some(friction), 1.0);
    let sites = positions(Start::Random, 360, &region, noise);
    let mut particles = Particles::at_rest(sites, vec![0; 360], &[1.0]);
    draw_momenta(&mut particles, 1.0, noise);
    let system = System::new(particles, region, interactions, 0.3, Workers::One).unwrap();
    let field = forcing(ForcingKind::Sinusoidal).field(360, system.region.sides()).unwrap();
    let slabs = Slabs { flow: Axis::Z, gradient: Axis::X, width: 0.1 };
    let driving: Option<Box<dyn Driving>> = match driven {
        Driven::Not => None,
        Driven::Norton => Some(Box::new(ConstantFlux::new(field, 0.01, Projection::Symmetric))),
        Driven::Exchange => Some(Box::new(MomentumExchange::new(slabs, Exchange::Forced { momentum: 0.5 }, 3, 0.1))),
    };
    Simulation::new(system, integrator, driving, noise, 0.02).unwrap()
}

fn word(word: &str) -> Integrator {
    let thermostat = Thermostat::PairOrnsteinUhlenbeck;
    Integrator::Splitting(Schedule::new(word, thermostat, 1.0, SweepOrder::Alternating).unwrap())
}

/// Runs 60 steps at once, and again with a new start from a snapshot after each of some numbers of steps.
fn goes_on_to_the_same_bits(integrator: impl Fn() -> Integrator, driven: Driven) {
    let mut uninterrupted = simulation(integrator(), driven);
    let step = |simulation: &mut Simulation| (simulation.step().unwrap(), simulation.exchanged());
    let forcings: Vec<_> = (0..60).map(|_| step(&mut uninterrupted)).collect();
    assert!(uninterrupted.system.list().builds() > 5, "the list must be rebuilt on the way");
    let mut interrupted = simulation(integrator(), driven);
    let mut again = Vec::new();
    for steps in [1, 2, 3, 7, 20, 27] {
        again.extend((0..steps).map(|_| step(&mut interrupted)));
        let mut restored = simulation(integrator(), driven);
        restored.restore(interrupted.snapshot()).unwrap();
        interrupted = restored;
    }
    assert_eq!(forcings, again);
    assert_eq!(uninterrupted.snapshot(), interrupted.snapshot());
}

#[test]
fn a_restored_simulation_goes_on_to_the_same_bits() {
    let velocity_verlet = || Integrator::VelocityVerlet(VelocityVerlet::new(1.0, 0.5, Correction::default()));
    goes_on_to_the_same_bits(|| word("ABOBA"), Driven::Not);
    goes_on_to_the_same_bits(|| word("OBABO"), Driven::Not);
    goes_on_to_the_same_bits(|| word("ABOBA"), Driven::Norton);
    goes_on_to_the_same_bits(velocity_verlet, Driven::Not);
    goes_on_to_the_same_bits(|| word("ABOBA"), Driven::Exchange);
    goes_on_to_the_same_bits(velocity_verlet, Driven::Exchange);
    goes_on_to_the_same_bits(|| Integrator::Explicit(Explicit::new(1.0, Correction::TwoStep)), Driven::Exchange);
}

#[test]
fn snapshots_that_do_not_fit_are_refused() {
    let source = simulation(word("ABOBA"), Driven::Not);
    let good = source.snapshot();
    let refused = |change: &dyn Fn(&mut Snapshot)| {
        let mut target = simulation(word("ABOBA"), Driven::Not);
        let mut bad = good.clone();
        change(&mut bad.system);
        target.restore(bad).unwrap_err()
    };
    assert_eq!(refused(&|s| s.particles.to_mut().id[3] = s.particles.id[4]), SnapshotError::Inconsistent);
    assert_eq!(refused(&|s| s.particles.to_mut().momentum[0][1] = f64::NAN), SnapshotError::Inconsistent);
    assert_eq!(refused(&|s| s.reference.to_mut().truncate(10)), SnapshotError::Inconsistent);
    assert_eq!(refused(&|s| s.particles.to_mut().species[7] = 9), SnapshotError::Inconsistent);
    assert_eq!(refused(&|s| s.reference.to_mut().swap(5, 200)), SnapshotError::Order);
    let sides = source.system.region.sides();
    let found = [sides[1], sides[0], sides[2]];
    assert_eq!(refused(&|s| s.sides = found), SnapshotError::Box { found, expected: sides });
    let bond = mesoflux_core::bond::Bond { law: 0, first: 0, second: 1 };
    assert_eq!(refused(&|s| s.bonds.to_mut().push(bond)), SnapshotError::Bonds);
    assert_eq!(refused(&|s| s.particles.to_mut().id.truncate(1)), SnapshotError::Count { found: 1, expected: 360 });
    simulation(word("ABOBA"), Driven::Not).restore(good.clone()).unwrap();
}
