//! The booked stress: the exact momentum flux of every step, a trajectory that doesn't notice, the same bits always.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, by_id, friction, interactions, splitting, unwrapped, velocity_verlet};
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange, Topology};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, Driving, Projection};
use mesoflux_core::forcing::{ColorDrift, ForcingField};
use mesoflux_core::friction::Friction;
use mesoflux_core::integrate::Integrator;
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::observable::BookedStress;
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::harmonic::Harmonic;
use mesoflux_core::potential::soft::Soft;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::draw_momenta;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, dot};

const DT: f64 = 0.01;
const SIDE: f64 = 14.0;

fn integrator(word: &str) -> Integrator {
    if word == "velocity Verlet" { velocity_verlet() } else { splitting(word) }
}

/// Particles of two masses in the middle of a box so large that no pair looks across its faces; some of them are bonded.
fn cluster(bonded: bool) -> System {
    let (noise, count) = (NoiseKey::new(&[7]), 60);
    let draw = noise.draw(Purpose::Start, 0, 0);
    let site = |k: u64| std::array::from_fn(|axis| 0.5 * SIDE + 2.4 * (draw.uniform(k, axis as u64) - 0.5));
    let masses = [1.0, 3.7];
    let potential =
        |a: usize, b: usize| Some(Potential::Soft(Soft { repulsion: 25.0 + 10.0 * (a + b) as f64, cutoff: 1.0 }));
    let rubbing = |a: usize, b: usize| Some(Friction::Linear(friction(4.5 + 8.0 * (a + b) as f64, 1.2)));
    let kinds = (0..count).map(|k| (k % 3 == 1).into()).collect();
    let mut particles = Particles::at_rest((0..count).map(site).collect(), kinds, &masses);
    draw_momenta(&mut particles, 1.0, noise);
    let laws = interactions(&masses, potential, rubbing);
    let system = System::new(particles, PeriodicBox::new([SIDE; 3]).unwrap(), laws, 0.3, Workers::One).unwrap();
    if !bonded {
        return system;
    }
    let law = BondLaw::Harmonic(Harmonic { stiffness: 40.0, length: 0.8 });
    let bonds = (0..20).map(|k| Bond { law: 0, first: 3 * k, second: 3 * k + 1 }).collect();
    let range = ExclusionRange { potential: 1, friction: 0 };
    system.with_bonds(Topology::new(count as usize, vec![law], bonds, range).unwrap())
}

/// Σ_i x_a p_b for positions from the middle of the box, and Σ_i |x||p|.
fn helfand_moment(system: &System) -> ([[f64; 3]; 3], f64) {
    let momenta = by_id(&system.particles, &system.particles.momentum);
    let (mut moment, mut magnitude) = ([[0.0; 3]; 3], 0.0);
    for (q, p) in unwrapped(system).into_iter().zip(momenta) {
        let x: Vector = q.map(|q| q - 0.5 * SIDE);
        magnitude += (dot(x, x) * dot(p, p)).sqrt();
        for a in 0..3 {
            for b in 0..3 {
                moment[a][b] += x[a] * p[b];
            }
        }
    }
    (moment, magnitude)
}

/// d(Σ x_a p_b) = J_ab dt holds for every step to rounding, whatever the word.
#[test]
fn what_is_booked_is_the_exact_change_of_the_helfand_moment() {
    for word in ["ABOBA", "OBABO", "BAOAB", "AOBAO", "velocity Verlet"] {
        for bonded in [false, true] {
            let mut simulation =
                Simulation::new(cluster(bonded), integrator(word), None, NoiseKey::new(&[1]), DT).unwrap();
            simulation.book_stress(true);
            let (before, magnitude) = helfand_moment(&simulation.system);
            let mut sum = [[0.0; 3]; 3];
            let mut parts = [0.0f64; 4];
            for _ in 0..30 {
                simulation.step().unwrap();
                let booked = simulation.booked_stress().unwrap();
                let total = booked.total();
                (0..9).for_each(|k| sum[k / 3][k % 3] += DT * total.component(k / 3, k % 3));
                let tensors = [booked.kinetic, booked.conservative, booked.dissipative, booked.random];
                parts = std::array::from_fn(|k| parts[k].max(tensors[k].component(0, 1).abs()));
            }
            assert!(parts.iter().all(|&part| part > 1.0), "{word}: a part is missing, {parts:?}");
            let after = helfand_moment(&simulation.system).0;
            for k in 0..9 {
                let (a, b) = (k / 3, k % 3);
                let error = (after[a][b] - before[a][b] - sum[a][b]).abs();
                assert!(error < 1e-12 * magnitude, "{word}, bonded {bonded}, {a}{b}: off by {error:e} of {magnitude}");
            }
        }
    }
}

/// Positions, momenta and what was booked after some steps, by id.
fn trace(mut simulation: Simulation, book: bool, steps: usize) -> (Vec<Vector>, Vec<Vector>, Vec<BookedStress>) {
    simulation.book_stress(book);
    let mut booked = Vec::new();
    for _ in 0..steps {
        simulation.step().unwrap();
        booked.extend(simulation.booked_stress());
    }
    let particles = &simulation.system.particles;
    (by_id(particles, &particles.position), by_id(particles, &particles.momentum), booked)
}

#[test]
fn booking_leaves_no_trace_in_the_trajectory() {
    let noise = NoiseKey::new(&[1]);
    for masses in [vec![(192, 1.0)], vec![(100, 1.0), (92, 3.0)]] {
        let fluid = Fluid::groot_warren(192).with_species(&masses);
        for (word, norton) in [("ABOBA", false), ("ABOBA", true), ("OBABO", false), ("velocity Verlet", false)] {
            for skin in [0.3, 0.03] {
                let start = || {
                    let flux: Box<dyn Driving> = Box::new(ConstantFlux::new(
                        ForcingField::new(Box::new(ColorDrift)),
                        0.5,
                        Projection::Symmetric,
                    ));
                    let system = Fluid { skin, ..fluid.clone() }.system(1.0, noise);
                    Simulation::new(system, integrator(word), norton.then_some(flux), noise, DT).unwrap()
                };
                let (with, without) = (trace(start(), true, 40), trace(start(), false, 40));
                assert!(with.0 == without.0 && with.1 == without.1, "{word}, skin {skin}");
                assert_eq!((with.2.len(), without.2.len()), (40, 0));
            }
        }
    }
}

#[test]
fn what_is_booked_has_the_same_bits_for_any_number_of_threads() {
    let fluid = Fluid::groot_warren(6000).with_species(&[(3000, 1.0), (3000, 2.0)]);
    for word in ["ABOBA", "velocity Verlet"] {
        let start = |workers| {
            let noise = NoiseKey::new(&[1]);
            let mut simulation = Simulation::new(fluid.system(1.0, noise), integrator(word), None, noise, DT).unwrap();
            simulation.system.workers = workers;
            simulation
        };
        let one = trace(start(Workers::One), true, 3).2;
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| trace(start(Workers::Pool), true, 3).2) == one, "{word} on {threads} threads");
        }
    }
}

/// A restored simulation books what the one that goes on books; one that hadn't booked begins with its first whole step.
#[test]
fn booking_goes_on_after_a_restart() {
    for word in ["ABOBA", "velocity Verlet"] {
        let noise = NoiseKey::new(&[1]);
        let start = || {
            let system = Fluid::groot_warren(192).system(1.0, noise);
            Simulation::new(system, integrator(word), None, noise, DT).unwrap()
        };
        let (mut going_on, mut restored) = (start(), start());
        going_on.book_stress(true);
        common::advance(&mut going_on, 7.0 * DT);
        restored.restore(going_on.snapshot()).unwrap();
        assert!(trace(going_on, true, 5) == trace(restored, true, 5), "{word}");
        let mut late = start();
        late.step().unwrap();
        let booked = trace(late, true, 4).2.len();
        assert_eq!(booked, if word == "ABOBA" { 4 } else { 3 }, "{word}");
    }
}
