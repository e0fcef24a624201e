//! Momentum exchange against its definition: who exchanges, what is conserved, where the energy goes.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, splitting, velocity_verlet};
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{Driving, Exchange, MomentumExchange, Slabs, mean_field_viscosity};
use mesoflux_core::forcing::Axis;
use mesoflux_core::integrate::Integrator;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::observable::Thermodynamics;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::system::System;
use mesoflux_core::vector::dot;

const SLABS: Slabs = Slabs { flow: Axis::Z, gradient: Axis::X, width: 0.1 };

fn mixture() -> Fluid {
    Fluid::groot_warren(192).with_species(&[(120, 1.0), (72, 2.5)])
}

fn forced(momentum: f64, interval: u64) -> Box<dyn Driving> {
    Box::new(MomentumExchange::new(SLABS, Exchange::Forced { momentum }, interval, 0.1))
}

fn swap(interval: u64) -> Box<dyn Driving> {
    Box::new(MomentumExchange::new(SLABS, Exchange::Swap, interval, 0.0))
}

/// The id of the particle that a slab gives: that of the least sign·v_z, of equally fast ones the one with the smaller id.
fn naive_partner(system: &System, center: f64, sign: f64) -> u64 {
    let side = system.region.sides()[0];
    let particles = &system.particles;
    let mut found: Option<(f64, u64)> = None;
    for k in 0..particles.count() {
        let from_center = particles.position[k][0].rem_euclid(side) - 0.5 * side;
        let speed = sign * particles.velocity(k)[2];
        let key = (speed, particles.id[k]);
        if (from_center - center * side).abs() <= 0.05 * side && found.is_none_or(|best| key < best) {
            found = Some(key);
        }
    }
    found.unwrap().1
}

/// Runs a bare exchange on a state of a fluid that has moved a little; tells whose momenta changed, by id with the change.
fn exchanged(exchange: Exchange, prepare: impl Fn(&mut System)) -> (System, System, f64) {
    let mut simulation = mixture().simulation("ABOBA", None, NoiseKey::new(&[3]), 0.02);
    for _ in 0..40 {
        simulation.step().unwrap();
    }
    let mut system = simulation.system;
    prepare(&mut system);
    let before = system.clone();
    let mut driving = MomentumExchange::new(SLABS, exchange, 1, 0.0);
    assert!(driving.end_step(&mut system, 0.02).is_none());
    let work = driving.exchanged().unwrap().work;
    (before, system, work)
}

/// The ids of the particles whose momentum changed, and by how much along z.
fn changes(before: &System, after: &System) -> Vec<(u64, f64)> {
    let changed = (0..before.particles.count()).filter_map(|k| {
        let [old, new] = [before, after].map(|system| system.particles.momentum[k]);
        assert_eq!(old[..2], new[..2], "only along the flow");
        (old != new).then_some((before.particles.id[k], new[2] - old[2]))
    });
    changed.collect()
}

fn kinetic(system: &System) -> f64 {
    0.5 * system.particles.twice_kinetic_energy(Workers::One)
}

#[test]
fn the_slowest_of_one_slab_and_the_fastest_of_the_other_exchange() {
    for exchange in [Exchange::Swap, Exchange::Forced { momentum: 0.7 }] {
        let (before, after, work) = exchanged(exchange, |_| ());
        let mut found = changes(&before, &after);
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        let [(first, gained), (second, lost)] = found[..] else { panic!("{found:?}") };
        assert_eq!([first, second], [naive_partner(&before, -0.25, 1.0), naive_partner(&before, 0.25, -1.0)]);
        assert!((gained + lost).abs() < 1e-14 && gained > 0.0);
        assert!(
            (kinetic(&after) - kinetic(&before) - work).abs() < 1e-11,
            "the work is the change of the kinetic energy"
        );
        if exchange == (Exchange::Forced { momentum: 0.7 }) {
            assert!((gained - 0.7).abs() < 1e-14);
        }
    }
}

#[test]
fn of_equally_fast_particles_the_one_with_the_smaller_id_is_taken() {
    let still = |system: &mut System| system.particles.momentum.iter_mut().for_each(|momentum| momentum[2] = 0.0);
    let (before, after, work) = exchanged(Exchange::Forced { momentum: 0.7 }, still);
    let mut found: Vec<u64> = changes(&before, &after).iter().map(|&(id, _)| id).collect();
    let mut expected = vec![naive_partner(&before, -0.25, 1.0), naive_partner(&before, 0.25, -1.0)];
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
    assert!(work > 0.0);
    // Nothing to swap.
    let (before, after, work) = exchanged(Exchange::Swap, still);
    assert!(changes(&before, &after).is_empty() && work == 0.0);
}

#[test]
fn a_swap_conserves_energy_with_unequal_masses() {
    let mut simulation = mixture().simulation("ABOBA", Some(swap(1)), NoiseKey::new(&[5]), 0.02);
    let mut pairs = std::collections::BTreeSet::new();
    for _ in 0..300 {
        simulation.step().unwrap();
        let exchanged = simulation.exchanged().unwrap();
        assert!(exchanged.work.abs() < 1e-13, "{exchanged:?}");
        pairs.insert(exchanged.momentum.to_bits());
    }
    assert!(pairs.len() > 250, "momenta were exchanged at nearly every step");
    // Masses unlike each other: the collision conserves energy and momentum and reverses the relative velocity.
    let by_mass = |system: &mut System, slab: f64, heavy: bool| {
        let sign = -slab.signum();
        let id = (0..system.particles.count())
            .filter(|&k| {
                let from_center = system.particles.position[k][0].rem_euclid(4.0) - 2.0;
                (from_center - slab * 4.0).abs() < 0.2 && (system.particles.inverse_mass[k] < 0.9) == heavy
            })
            .min()
            .unwrap();
        system.particles.momentum[id][2] = -9.0 * sign;
        id
    };
    let (before, after, work) = exchanged(Exchange::Swap, |system| {
        by_mass(system, -0.25, false);
        by_mass(system, 0.25, true);
    });
    let found = changes(&before, &after);
    assert_eq!(found.len(), 2);
    let velocity = |system: &System, id: u64| {
        let k = (0..192).find(|&k| system.particles.id[k] == id).unwrap();
        system.particles.velocity(k)[2]
    };
    let relative = |system: &System| velocity(system, found[0].0) - velocity(system, found[1].0);
    assert!((relative(&before) + relative(&after)).abs() < 1e-13 && relative(&before).abs() > 10.0);
    assert!(work.abs() < 1e-13 && (kinetic(&after) - kinetic(&before)).abs() < 1e-11);
}

/// 2·10⁴ steps; Σp must stay below 1e-10 per particle, and momentum be exchanged all the time.
fn conserves_momentum(integrator: Integrator, driving: Box<dyn Driving>) {
    let noise = NoiseKey::new(&[1]);
    let mut simulation =
        Simulation::new(mixture().system(1.0, noise), integrator, Some(driving), noise, 0.005).unwrap();
    let mut carried = 0.0;
    for _ in 0..20_000 {
        simulation.step().unwrap();
        carried += simulation.exchanged().unwrap().momentum;
    }
    let total = simulation.system.particles.total_momentum(Workers::One);
    assert!(dot(total, total).sqrt() < 192e-10, "the total momentum is {total:?}");
    assert!(carried > 100.0, "{carried}");
}

#[test]
fn momentum_is_conserved_with_every_integrator() {
    conserves_momentum(splitting("ABOBA"), forced(0.05, 1));
    conserves_momentum(splitting("OBABO"), forced(0.5, 7));
    conserves_momentum(splitting("ABOBA"), swap(5));
    conserves_momentum(splitting("BAB"), swap(50));
    conserves_momentum(velocity_verlet(), forced(0.05, 1));
    conserves_momentum(velocity_verlet(), swap(5));
}

#[test]
fn exchanges_come_every_so_many_steps() {
    let mut simulation = mixture().simulation("ABOBA", Some(forced(0.3, 7)), NoiseKey::new(&[2]), 0.01);
    for step in 1..=30 {
        simulation.step().unwrap();
        let momentum = simulation.exchanged().unwrap().momentum;
        assert_eq!(momentum, if step % 7 == 0 { 0.3 } else { 0.0 }, "step {step}");
    }
}

/// Σ (work − heat) over the steps against the change of the total energy, and the sum of the work.
fn balance(fluid: &Fluid, dt: f64, steps: u64) -> (f64, f64, f64) {
    let mut simulation = fluid.simulation("ABOBA", Some(forced(2.0 * dt, 1)), NoiseKey::new(&[4]), dt);
    let energy = |simulation: &mut Simulation| {
        Thermodynamics::of(&mut simulation.system).potential_energy + kinetic(&simulation.system)
    };
    let start = energy(&mut simulation);
    let (mut work, mut heat) = (0.0, 0.0);
    for _ in 0..steps {
        simulation.step().unwrap();
        let exchanged = simulation.exchanged().unwrap();
        work += exchanged.work;
        heat += exchanged.heat.unwrap();
    }
    (work, heat, energy(&mut simulation) - start)
}

#[test]
fn the_energy_balance_closes() {
    // Where no force acts between the letters, to rounding.
    let (work, heat, change) = balance(&Fluid::ideal(192, 9.0), 0.01, 4000);
    assert!(work.abs() > 50.0 && (work - heat - change).abs() < 1e-8 * work.abs(), "{work} {heat} {change}");
    // Else to the order of the time step squared.
    let (work, heat, change) = balance(&Fluid::groot_warren(192), 0.005, 4000);
    assert!(work.abs() > 50.0 && (work - heat - change).abs() < 0.01 * work.abs(), "{work} {heat} {change}");
    // Velocity Verlet can't tell.
    let noise = NoiseKey::new(&[4]);
    let system = Fluid::groot_warren(192).system(1.0, noise);
    let mut simulation = Simulation::new(system, velocity_verlet(), Some(forced(0.1, 1)), noise, 0.01).unwrap();
    simulation.step().unwrap();
    assert_eq!(simulation.exchanged().unwrap().heat, None);
}

#[test]
fn the_mean_field_viscosity_is_the_one_of_the_literature() {
    // Groot & Warren: η = 2πγρ²r_c⁵/1575 + ρD/2 with D = 45 kT/(2πγρr_c³).
    let (gamma, density, temperature) = (9.0, 3.0, 1.3);
    let pi = std::f64::consts::PI;
    let by_friction = 2.0 * pi * gamma * density * density / 1575.0;
    let by_flight = 0.5 * 45.0 * temperature / (2.0 * pi * gamma);
    for fluid in [Fluid::ideal(192, gamma), Fluid::ideal(192, gamma).with_species(&[(100, 1.0), (92, 1.0)])] {
        let system = fluid.system(1.0, NoiseKey::new(&[1]));
        let found = mean_field_viscosity(&system, temperature).unwrap();
        assert!((found / (by_friction + by_flight) - 1.0).abs() < 1e-3, "{found}");
    }
    let heavy = Fluid::ideal(192, gamma).with_species(&[(192, 2.0)]).system(1.0, NoiseKey::new(&[1]));
    let found = mean_field_viscosity(&heavy, temperature).unwrap();
    assert!((found / (by_friction + 2.0 * by_flight) - 1.0).abs() < 1e-3, "{found}");
}
