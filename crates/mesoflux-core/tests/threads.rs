//! One large run, by Norton dynamics or by momentum exchange, gives the same bits on any number of threads.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, by_id};
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, Driving, Exchange, MomentumExchange, Projection, Slabs};
use mesoflux_core::forcing::{Axis, ColorDrift, ForcingField};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::vector::Vector;

/// Everything that a run leaves behind, as bits.
#[derive(PartialEq)]
struct Trace {
    positions: Vec<[u64; 3]>,
    momenta: Vec<[u64; 3]>,
    /// Flux and booked forcing of every step, or momentum, work and heat.
    driven: Vec<[u64; 3]>,
    builds: u64,
}

fn norton() -> Box<dyn Driving> {
    Box::new(ConstantFlux::new(ForcingField::new(Box::new(ColorDrift)), 30.0, Projection::Symmetric))
}

fn exchange() -> Box<dyn Driving> {
    let slabs = Slabs { flow: Axis::X, gradient: Axis::Y, width: 0.1 };
    Box::new(MomentumExchange::new(slabs, Exchange::Forced { momentum: 3.0 }, 1, 0.1))
}

type NewDriving = fn() -> Box<dyn Driving>;

fn run(fluid: &Fluid, driving: NewDriving, steps: usize, dt: f64, workers: Workers) -> Trace {
    let driving = driving();
    let mut simulation = fluid.simulation("ABOBA", Some(driving), NoiseKey::new(&[1]), dt);
    simulation.system.workers = workers;
    let step = |_| {
        let driven = simulation.step().unwrap().map(|step| [step.flux, step.forcing, 0.0]);
        let exchanged = simulation.exchanged().map(|step| [step.momentum, step.work, step.heat.unwrap()]);
        driven.or(exchanged).unwrap().map(f64::to_bits)
    };
    let driven = (0..steps).map(step).collect();
    let bits = |column: &[Vector]| -> Vec<[u64; 3]> {
        let ordered = by_id(&simulation.system.particles, column);
        ordered.iter().map(|v| v.map(f64::to_bits)).collect()
    };
    Trace {
        positions: bits(&simulation.system.particles.position),
        momenta: bits(&simulation.system.particles.momentum),
        driven,
        builds: simulation.system.list().builds(),
    }
}

fn same_bits_on_any_number_of_threads(fluid: &Fluid, driving: NewDriving, steps: usize, dt: f64) {
    let expected = run(fluid, driving, steps, dt, Workers::One);
    assert!(expected.builds > 3, "the list must have been rebuilt, {} builds", expected.builds);
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| run(fluid, driving, steps, dt, Workers::Pool));
        assert!(found.driven == expected.driven, "flux or forcing differ on {threads} threads");
        assert!(found.momenta == expected.momenta, "momenta differ on {threads} threads");
        assert!(found.positions == expected.positions, "positions differ on {threads} threads");
        assert_eq!(found.builds, expected.builds);
    }
}

#[test]
fn soft_fluid() {
    same_bits_on_any_number_of_threads(&Fluid::groot_warren(20_000), norton, 20, 0.04);
}

#[test]
fn lennard_jones_liquid_of_two_masses() {
    let fluid = Fluid::lennard_jones(20_000).with_species(&[(12_000, 1.0), (8_000, 2.0)]);
    same_bits_on_any_number_of_threads(&Fluid { skin: 0.1, ..fluid }, norton, 12, 0.01);
}

#[test]
fn langevin_thermostat_with_two_masses() {
    let fluid = Fluid::groot_warren(20_000).with_species(&[(12_000, 1.0), (8_000, 2.0)]).with_langevin(2.0);
    same_bits_on_any_number_of_threads(&fluid, norton, 20, 0.04);
}

#[test]
fn momentum_exchange_with_two_masses() {
    let fluid = Fluid::groot_warren(20_000).with_species(&[(12_000, 1.0), (8_000, 2.0)]);
    same_bits_on_any_number_of_threads(&fluid, exchange, 20, 0.04);
}
