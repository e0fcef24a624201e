//! The engine against naive references on random states of random shapes: same forces, same steps, same multipliers.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::naive::{Flux, Matrix, Naive};
use common::{Fluid, by_id, forcing, friction, interactions, lennard_jones, splitting, unwrapped};
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange, Topology};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Projection};
use mesoflux_core::forcing::{ForcingField, ForcingKind};
use mesoflux_core::friction::cross::Cross;
use mesoflux_core::friction::dot::Dot;
use mesoflux_core::friction::expression::Source;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::friction::thinning::Thinning;
use mesoflux_core::friction::{Dependence, Friction};
use mesoflux_core::integrate::{Change, Explicit, FluxChange, Integrator, Schedule, Stroke, VelocityVerlet};
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::observable::{BookedStress, Stress};
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::harmonic::Harmonic;
use mesoflux_core::potential::lennard_jones::Truncation;
use mesoflux_core::potential::soft::Soft;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::tensor::SymmetricTensor;
use mesoflux_core::vector::{Vector, dot, subtract};
use proptest::prelude::*;

const WORDS: [&str; 4] = ["ABOBA", "OBABO", "BAOAB", "OABAO"];

static FORCINGS: [ForcingKind; 5] = [
    ForcingKind::ColorDrift,
    ForcingKind::TwoParticleDrift,
    ForcingKind::Sinusoidal,
    ForcingKind::PiecewiseLinear,
    ForcingKind::PiecewiseConstant,
];

/// Random points no two of which are nearer than `apart`; an even number of them.
fn scattered(count: usize, apart: f64, region: &PeriodicBox, noise: NoiseKey) -> Vec<Vector> {
    let draw = noise.draw(Purpose::Start, 0, 0);
    let mut points: Vec<Vector> = Vec::new();
    for k in 0..10_000 {
        let point = std::array::from_fn(|axis| draw.uniform(k, axis as u64) * region.sides()[axis]);
        let distance = |other: &Vector| {
            let d = subtract(point, *other);
            let d: Vector = std::array::from_fn(|k| d[k] - region.sides()[k] * (d[k] / region.sides()[k]).round());
            dot(d, d).sqrt()
        };
        if points.len() < count && points.iter().all(|other| distance(other) > apart) {
            points.push(point);
        }
    }
    points.truncate(points.len() / 2 * 2);
    points
}

/// Frictions: linear ones, Cross, Dot, typed ones, or of each pair of species another (`choice` 0 to 4).
fn rubbing(choice: usize, kind: usize, coefficient: f64, cutoff: f64) -> Friction {
    let typed = "g*(1 - r/c)^2/(1 + 0.3*radial^2 + 0.2*transverse)";
    match (choice + if choice == 4 { kind } else { 0 }) % 4 {
        0 => Friction::Linear(friction(coefficient, cutoff)),
        1 => Friction::Cross(Cross(Thinning { coefficient, thinning: 0.4, cutoff, exponent: 2.0 })),
        2 => Friction::Dot(Dot(Thinning { coefficient, thinning: 0.3, cutoff, exponent: 1.5 })),
        _ => {
            let parameters = [("g".to_owned(), coefficient), ("c".to_owned(), cutoff)].into();
            Friction::Expression(Source { friction: typed.into(), parameters, cutoff }.into())
        }
    }
}

/// A random state: soft particles, a Lennard-Jones fluid or an ideal one (`law` 0, 1, 2), of one or two species.
fn random_system(law: usize, frictions: usize, species: usize, shape: [f64; 3], noise: NoiseKey) -> System {
    let potential = |a: usize, b: usize| match law {
        0 => Some(Potential::Soft(Soft { repulsion: 25.0 + 10.0 * (a + b) as f64, cutoff: 1.0 - 0.1 * a as f64 })),
        1 if a == b => Some(lennard_jones(1.6, Truncation::ForceShifted)),
        1 => Some(lennard_jones(1.3, Truncation::Shifted)),
        _ => None,
    };
    let rubbing =
        |a: usize, b: usize| Some(rubbing(frictions, a + b, 4.5 + 8.0 * (a + b) as f64, 1.2 + 0.1 * b as f64));
    let masses = [1.0, 3.7];
    let region = PeriodicBox::new(shape).unwrap();
    let apart = if law == 1 { 0.85 } else { 0.05 };
    let sites = scattered((region.volume() * 0.8) as usize, apart, &region, noise);
    let kinds = (0..sites.len()).map(|k| (k % 3 % species) as u8).collect();
    let laws = interactions(&masses[..species], potential, rubbing);
    let mut particles = Particles::at_rest(sites, kinds, &masses[..species]);
    draw_momenta(&mut particles, 1.3, noise);
    System::new(particles, region, laws, 0.3, Workers::One).unwrap()
}

/// How far exclusions reach, if there are bonds at all: 0 for none.
fn exclusions(choice: usize) -> Option<ExclusionRange> {
    let ranges = [(0, 0), (1, 0), (2, 1), (1, 3)].map(|(potential, friction)| ExclusionRange { potential, friction });
    choice.checked_sub(1).map(|choice| ranges[choice])
}

/// The system with springs from two of three particles to the nearest one with a larger id: chains, stars and trees.
fn bonded(system: System, range: Option<ExclusionRange>) -> System {
    let Some(range) = range else { return system };
    let (q, region) = (unwrapped(&system), system.region);
    let distance = |i: usize, j: usize| {
        let d = region.nearest_image(subtract(q[i], q[j]));
        dot(d, d)
    };
    let nearest = |i: usize| (i + 1..q.len()).min_by(|&a, &b| distance(i, a).total_cmp(&distance(i, b)));
    let near = (0..q.len()).filter(|i| i % 3 < 2).filter_map(|i| Some((i, nearest(i)?)));
    let bonds = near.filter(|&(i, j)| distance(i, j) < 1.9).map(|(i, j)| Bond {
        law: (i % 2) as u16,
        first: (if i % 5 == 0 { j } else { i }) as u32,
        second: (if i % 5 == 0 { i } else { j }) as u32,
    });
    let laws = [(30.0, 0.8), (60.0, 0.5)].map(|(stiffness, length)| BondLaw::Harmonic(Harmonic { stiffness, length }));
    let topology = Topology::new(q.len(), laws.to_vec(), bonds.collect(), range).unwrap();
    system.with_bonds(topology)
}

fn same(engine: &[Vector], naive: &[Vector], tolerance: impl Fn(usize) -> f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(engine.len(), naive.len());
    for (k, (&a, &b)) in engine.iter().zip(naive).enumerate() {
        let d = subtract(a, b);
        prop_assert!(dot(d, d).sqrt() <= tolerance(k), "particle {}: {:?} against {:?}", k, a, b);
    }
    Ok(())
}

/// Component by component; `magnitude` is that of the terms.
fn same_tensor(engine: &SymmetricTensor, naive: &Matrix, magnitude: f64) -> Result<(), TestCaseError> {
    for (a, row) in naive.iter().enumerate() {
        for (b, &expected) in row.iter().enumerate() {
            let found = engine.component(a, b);
            prop_assert!((found - expected).abs() <= 1e-12 * magnitude, "{}{}: {} against {}", a, b, found, expected);
        }
    }
    Ok(())
}

/// Every part of the momentum flux of a time, `magnitude` being that of all impulses together.
fn same_flux(engine: &BookedStress, time: f64, naive: &Flux, magnitude: f64) -> Result<(), TestCaseError> {
    let parts = [
        (engine.kinetic, naive.kinetic),
        (engine.conservative, naive.conservative),
        (engine.dissipative, naive.dissipative),
        (engine.random, naive.random),
    ];
    parts.iter().try_for_each(|(engine, naive)| same_tensor(&(time * *engine), naive, magnitude))
}

/// The pairs that a sweep at the system's positions visits, in its order, by id.
fn sweep_order(system: &mut System, backward: bool) -> Vec<(usize, usize)> {
    let id = system.particles.id.clone();
    let mut order = Vec::new();
    let cutoff = system.interactions.cutoff();
    let linear = system.interactions.friction_dependence() == Dependence::Distance;
    let (positions, region) = (system.particles.position.clone(), system.region);
    for contacts in system.contacts().contacts() {
        let visits: Vec<usize> = if linear { contacts.in_order().collect() } else { contacts.in_groups() };
        let near = visits.into_iter().filter(|&k| contacts.separation(k, &positions, &region).0 < cutoff);
        order.extend(near.map(|k| contacts.pair(k).map(|place| id[place] as usize)).map(|[i, j]| (i, j)));
    }
    if backward {
        order.reverse();
    }
    order
}

/// The orders of a word's sweeps within the coming step, found by taking the step with a copy of the simulation's system.
fn orders(
    system: &System,
    driving: Option<Box<dyn Driving>>,
    word: &str,
    dt: f64,
    noise: NoiseKey,
) -> Vec<Vec<(usize, usize)>> {
    let Integrator::Splitting(schedule) = splitting(word) else { unreachable!() };
    let (mut system, mut driving) = (system.clone(), driving);
    let backward = schedule.backward(system.step);
    if let Some(driving) = &mut driving {
        driving.begin(&mut system).unwrap();
    }
    let mut orders = Vec::new();
    for (place, (letter, share)) in schedule.entries().iter().enumerate() {
        let order = sweep_order(&mut system, backward);
        orders.push(if letter.symbol() == 'O' { order } else { Vec::new() });
        let stroke =
            Stroke { time: share * dt, place: place as u64, noise, backward, response: None, constraint: None };
        letter.apply(&mut system, &stroke).unwrap();
        if let Some(driving) = &mut driving {
            let change = Change { flux: FluxChange::Determined, multiplier: None };
            driving.after_letter(&mut system, letter.symbol(), stroke.time, change);
        }
    }
    orders
}

#[derive(Debug, Clone, Copy)]
enum Drive {
    None,
    Nemd(&'static ForcingKind),
    Norton(&'static ForcingKind),
}

fn field(kind: &ForcingKind, system: &System) -> ForcingField {
    forcing(kind.clone()).field(system.particles.count(), system.region.sides()).unwrap()
}

impl Drive {
    const MAGNITUDE: f64 = 0.9;

    fn driving(self, system: &System) -> Option<Box<dyn Driving>> {
        match self {
            Self::None => None,
            Self::Nemd(kind) => Some(Box::new(ConstantForce::new(field(kind, system), Self::MAGNITUDE))),
            Self::Norton(kind) => {
                Some(Box::new(ConstantFlux::new(field(kind, system), Self::MAGNITUDE, Projection::Paper)))
            }
        }
    }
}

/// Three steps of engine and naive reference; compares positions, momenta, flux and booked forcing after each.
fn compare_steps(system: System, word: &str, drive: Drive, noise: NoiseKey) -> Result<(), TestCaseError> {
    let (dt, count) = (0.008, system.particles.count());
    let Integrator::Splitting(schedule) = splitting(word) else { unreachable!() };
    let mut field = match drive {
        Drive::None => None,
        Drive::Nemd(kind) | Drive::Norton(kind) => Some(field(kind, &system)),
    };
    let mut naive = Naive::of(&system);
    if let (Drive::Norton(_), Some(field)) = (drive, &mut field) {
        naive.project(field, Drive::MAGNITUDE);
    }
    let driving = drive.driving(&system);
    let mut simulation = Simulation::new(system, splitting(word), driving, noise, dt).unwrap();
    simulation.book_stress(true);
    for _ in 0..3 {
        naive.flux = Flux::default();
        let orders = orders(&simulation.system, drive.driving(&simulation.system), word, dt, noise);
        let driven = simulation.step().unwrap();
        let multiplier = naive_step(&mut naive, &schedule, drive, field.as_mut(), &orders, dt, noise)?;
        let sum: f64 = naive.p.iter().map(|&p| dot(p, p).sqrt()).sum();
        let scale = 1e-10 * sum / count as f64;
        same(&unwrapped(&simulation.system), &naive.q, |_| 1e-11)?;
        let particles = &simulation.system.particles;
        same(&by_id(particles, &particles.momentum), &naive.p, |_| scale)?;
        same_flux(simulation.booked_stress().unwrap(), dt, &naive.flux, 100.0 * sum)?;
        if let (Some(driven), Some(field)) = (driven, &mut field) {
            prop_assert!((driven.flux - naive.flux(field)).abs() <= 1e-10 * sum / (count as f64).sqrt());
            let tolerance = 1e-10 * (sum / dt).max(multiplier.abs());
            prop_assert!(
                (driven.forcing - multiplier).abs() <= tolerance,
                "{} booked, {} expected",
                driven.forcing,
                multiplier
            );
        }
    }
    Ok(())
}

/// One naive step with its driving (eqs 25–32 and 52–71); returns η or ℓ/Δt.
fn naive_step(
    naive: &mut Naive,
    schedule: &Schedule,
    drive: Drive,
    mut field: Option<&mut ForcingField>,
    orders: &[Vec<(usize, usize)>],
    dt: f64,
    noise: NoiseKey,
) -> Result<f64, TestCaseError> {
    let mut booked = 0.0;
    let mut outcome = Ok(());
    let order = |place: usize, naive: &Naive| {
        let mut found: Vec<_> = orders[place].iter().map(|&(i, j)| (i.min(j), i.max(j))).collect();
        found.sort_by_key(|&(i, j)| (j, i));
        if found != naive.pairs() {
            outcome = Err(TestCaseError::fail("the contacts are not the pairs within the cutoff"));
        }
        orders[place].clone()
    };
    naive.word(schedule, dt, noise, order, |naive, symbol, time, dissipative| match (drive, &mut field) {
        (Drive::Nemd(_), Some(field)) if symbol == 'B' => {
            naive.flux(field);
            for (p, f) in naive.p.iter_mut().zip(&field.force) {
                *p = std::array::from_fn(|k| p[k] + time * Drive::MAGNITUDE * f[k]);
            }
        }
        (Drive::Norton(_), Some(field)) => {
            let multiplier = naive.project(field, Drive::MAGNITUDE);
            let expected: f64 = field.response.iter().zip(dissipative).map(|(g, &d)| dot(g.vector(), d)).sum();
            booked += if symbol == 'O' { -expected / field.control } else { multiplier };
        }
        _ => {}
    });
    outcome?;
    Ok(if matches!(drive, Drive::Norton(_)) { booked / dt } else { Drive::MAGNITUDE })
}

/// Dense enough for several bricks, two across each axis: the colors follow each other forward and backward.
#[test]
fn words_of_many_bricks() {
    for species in [vec![(864, 1.0)], vec![(432, 1.0), (432, 3.7)]] {
        let noise = NoiseKey::new(&[1]);
        let mut system = Fluid::groot_warren(864).with_species(&species).system(1.0, noise);
        let bricks = system.contacts().contacts().filter(|contacts| contacts.count() > 0).count();
        assert!(bricks >= 4, "{bricks} bricks: there must be one of each color");
        compare_steps(system, "ABOBA", Drive::Norton(&ForcingKind::ColorDrift), noise).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn conservative_forces(law in 0usize..2, frictions in 0usize..5, species in 1usize..3, bonds in 0usize..5, shape in [3.9..8.0f64, 3.9..8.0f64, 3.9..8.0f64], seed: u64) {
        let mut system = bonded(random_system(law, frictions, species, shape, NoiseKey::new(&[seed])), exclusions(bonds));
        system.update_forces();
        let (expected, magnitude) = Naive::of(&system).forces();
        let forces: Vec<Vector> = system.forces().iter().map(|row| row.vector()).collect();
        // A soft pair near its cutoff feels a small difference of numbers of order 25: that much rounding stays.
        same(&by_id(&system.particles, &forces), &expected, |k| 1e-12 * magnitude[k] + 1e-13)?;
    }

    #[test]
    fn stress(law in 0usize..3, frictions in 0usize..5, species in 1usize..3, bonds in 0usize..5, shape in [3.9..8.0f64, 3.9..8.0f64, 3.9..8.0f64], seed: u64) {
        let mut system = bonded(random_system(law, frictions, species, shape, NoiseKey::new(&[seed])), exclusions(bonds));
        let naive = Naive::of(&system);
        let velocity: Vec<Vector> = naive.p.iter().zip(&naive.mass).map(|(p, m)| p.map(|p| p / m)).collect();
        let (found, expected) = (Stress::of(&mut system), naive.stress(&velocity));
        // Of some hundred terms, the largest ones cancel: 1e4 is their sum.
        same_tensor(&found.kinetic, &expected.kinetic, 1e4)?;
        same_tensor(&found.conservative, &expected.conservative, 1e4 + naive.forces().1.iter().sum::<f64>())?;
        same_tensor(&found.dissipative, &expected.dissipative, 1e4)?;
        same_tensor(&found.friction, &expected.friction, 1e4)?;
    }

    #[test]
    fn words(law in 0usize..3, frictions in 0usize..5, species in 1usize..3, bonds in 0usize..5, shape in [3.9..7.0f64, 3.9..7.0f64, 3.9..7.0f64], word in 0usize..4, start in 0u64..2, seed: u64) {
        let noise = NoiseKey::new(&[seed]);
        let mut system = bonded(random_system(law, frictions, species, shape, noise), exclusions(bonds));
        system.step = start;
        compare_steps(system, WORDS[word], Drive::None, noise)?;
    }

    #[test]
    fn driven_words(frictions in 0usize..5, species in 1usize..3, bonds in 0usize..5, shape in [3.9..7.0f64, 3.9..7.0f64, 3.9..7.0f64], word in 0usize..4, kind in 0usize..5, norton: bool, seed: u64) {
        let noise = NoiseKey::new(&[seed]);
        let kind = &FORCINGS[kind];
        let drive = if norton { Drive::Norton(kind) } else { Drive::Nemd(kind) };
        let system = bonded(random_system(seed as usize % 3, frictions, species, shape, noise), exclusions(bonds));
        compare_steps(system, WORDS[word], drive, noise)?;
    }

    #[test]
    fn velocity_verlet_and_the_explicit_scheme(law in 0usize..3, frictions in 0usize..5, species in 1usize..3, bonds in 0usize..5, shape in [3.9..7.0f64, 3.9..7.0f64, 3.9..7.0f64], explicit: bool, two_steps: bool, seed: u64) {
        let noise = NoiseKey::new(&[seed]);
        let correction = if two_steps { Correction::TwoStep } else { Correction::Derivative };
        let integrator = if explicit {
            Integrator::Explicit(Explicit::new(1.0, correction))
        } else {
            Integrator::VelocityVerlet(VelocityVerlet::new(1.0, 0.5, correction))
        };
        let system = bonded(random_system(law, frictions, species, shape, noise), exclusions(bonds));
        let mut naive = Naive::of(&system);
        let mut simulation = Simulation::new(system, integrator, None, noise, 0.008).unwrap();
        simulation.book_stress(true);
        let mut booked = [BookedStress::default(); 3];
        for booked in &mut booked {
            assert!(simulation.step().unwrap().is_none());
            *booked = *simulation.booked_stress().unwrap();
        }
        if explicit {
            naive.explicit(3, 0.008, (noise, correction));
        } else {
            naive.velocity_verlet(3, 0.008, 0.5, (noise, correction));
        }
        let sum = |part: fn(&BookedStress) -> SymmetricTensor| part(&booked[0]) + part(&booked[1]) + part(&booked[2]);
        let all = BookedStress {
            kinetic: sum(|booked| booked.kinetic),
            conservative: sum(|booked| booked.conservative),
            dissipative: sum(|booked| booked.dissipative),
            random: sum(|booked| booked.random),
        };
        same_flux(&all, 0.008, &naive.flux, 100.0 * naive.p.iter().map(|&p| dot(p, p).sqrt()).sum::<f64>())?;
        same(&unwrapped(&simulation.system), &naive.q, |_| 1e-11)?;
        let particles = &simulation.system.particles;
        same(&by_id(particles, &particles.momentum), &naive.p, |_| 1e-10)?;
    }
}
