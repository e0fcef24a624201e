//! Forcings that a user types: those of the built-in ones again, the drift of the response, the same bits on any number of threads.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, forcing, typed};
use mesoflux_core::domain::Workers;
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Projection};
use mesoflux_core::forcing::{Axis, ForcingChoice, ForcingError, ForcingField, ForcingKind, Wave};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, dot};

/// The same forcing, built in and typed.
fn pairs() -> [(ForcingChoice, ForcingChoice); 3] {
    let wave = Wave { flow: Axis::Z, gradient: Axis::X, waves: 2 };
    let sine = typed(["0", "0", "sin(4*pi*x/lx)"], ["0", "0", "sin(4*pi*x/lx)/n"]);
    [
        (ForcingChoice { wave, ..forcing(ForcingKind::Sinusoidal) }, sine.clone()),
        (
            ForcingChoice { wave, remove_mean_force: false, ..forcing(ForcingKind::Sinusoidal) },
            ForcingChoice { remove_mean_force: false, ..sine },
        ),
        (forcing(ForcingKind::ColorDrift), typed(["color/sqrt(n)", "0", "0"], ["color/sqrt(n)", "0", "0"])),
    ]
}

fn fluid() -> Fluid {
    Fluid::groot_warren(192).with_species(&[(128, 1.0), (64, 4.0)])
}

fn field(choice: &ForcingChoice, system: &System) -> ForcingField {
    choice.field(system.particles.count(), system.region.sides()).unwrap()
}

/// A fluid that has moved for a while, some of its particles beyond the faces of the box.
fn state() -> System {
    let mut simulation = fluid().simulation("ABOBA", None, NoiseKey::new(&[7]), 0.02);
    common::advance(&mut simulation, 1.0);
    let mut system = simulation.system;
    let side = system.region.sides()[0];
    system.particles.position[3][0] += side;
    system.particles.position[5][0] = -0.01;
    system
}

fn drift(field: &ForcingField, particles: &Particles) -> Vec<f64> {
    (0..particles.count()).map(|k| field.forcing().response_drift(particles, k)).collect()
}

#[test]
fn typed_forcings_are_the_built_in_ones() {
    let system = state();
    let count = system.particles.count() as f64;
    for (built_in, typed) in pairs() {
        let [expected, found] = [&built_in, &typed].map(|choice| {
            let mut field = field(choice, &system);
            field.update(&system.particles, 0, true, Workers::One);
            field
        });
        let close = |a: Vector, b: Vector, scale: f64| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12 * scale);
        for k in 0..system.particles.count() {
            assert!(close(found.force[k], expected.force[k], 1.0), "{typed:?}: {:?}", found.force[k]);
            let [found, expected] = [found.response[k].vector(), expected.response[k].vector()];
            assert!(close(found, expected, 1.0 / count), "{typed:?}: {found:?} for {expected:?}");
        }
        assert!((found.control / expected.control - 1.0).abs() < 1e-12);
        let drifts = [&found, &expected].map(|field| drift(field, &system.particles));
        let largest = drifts[1].iter().fold(0.0f64, |largest, drift| largest.max(drift.abs()));
        assert_eq!(largest > 0.0, built_in.kind.is_shear());
        assert!(drifts[0].iter().zip(&drifts[1]).all(|(a, b)| (a - b).abs() <= 1e-12 * largest), "{typed:?}");
    }
}

#[test]
fn typed_forcings_drive_as_the_built_in_ones() {
    type Drive = fn(ForcingField) -> Box<dyn Driving>;
    let drives: [(Drive, f64); 3] = [
        (|field| Box::new(ConstantForce::new(field, 2.0)), 1.0),
        (|field| Box::new(ConstantFlux::new(field, 0.2, Projection::Symmetric)), 100.0),
        (|field| Box::new(ConstantFlux::new(field, 0.2, Projection::Paper)), 100.0),
    ];
    for (built_in, typed) in pairs() {
        for (number, (drive, scale)) in drives.into_iter().enumerate() {
            let run = |choice: &ForcingChoice| {
                let noise = NoiseKey::new(&[3]);
                let field = field(choice, &fluid().system(1.0, noise));
                let mut simulation = fluid().simulation("ABOBA", Some(drive(field)), noise, 0.02);
                (0..40)
                    .map(|_| {
                        let driven = simulation.step().unwrap().unwrap();
                        [driven.flux, driven.forcing, simulation.system.kinetic_temperature()]
                    })
                    .collect::<Vec<_>>()
            };
            for (found, expected) in run(&typed).iter().zip(run(&built_in)) {
                let differences = [0, 1, 2].map(|k| (found[k] - expected[k]).abs());
                assert!(
                    differences[0] < 1e-10 && differences[1] < 1e-10 * scale && differences[2] < 1e-10,
                    "{built_in:?}, driving {number}: {found:?} for {expected:?}"
                );
            }
        }
    }
}

#[test]
fn response_drift_is_the_rate_at_which_free_flight_changes_the_flux() {
    let system = state();
    let choice = common::typed_in_all_directions();
    let field = field(&choice, &system);
    let flux = |time: f64| {
        let mut moved = system.particles.clone();
        for k in 0..moved.count() {
            let velocity = moved.velocity(k);
            (0..3).for_each(|axis| moved.position[k][axis] += time * velocity[axis]);
        }
        (0..moved.count()).map(|k| dot(field.forcing().at(&moved, k)[1], moved.momentum[k])).sum::<f64>()
    };
    let slope = (8.0 * (flux(1e-3) - flux(-1e-3)) - (flux(2e-3) - flux(-2e-3))) / 12e-3;
    let drifts = drift(&field, &system.particles);
    let (drift, scale): (f64, f64) = (drifts.iter().sum(), drifts.iter().map(|drift| drift.abs()).sum());
    assert!((slope - drift).abs() < 1e-8 * scale && drift.abs() > 1e-2 * scale, "{slope} and {drift}");
}

#[test]
fn a_typed_forcing_has_the_same_bits_on_any_number_of_threads() {
    let system = Fluid::groot_warren(20_000).system(1.0, NoiseKey::new(&[1]));
    let bits = |workers: Workers| {
        let mut field = field(&common::typed_in_all_directions(), &system);
        field.update(&system.particles, 0, true, workers);
        let vectors = field.force.iter().copied().chain(field.response.iter().map(|row| row.vector()));
        let bits: Vec<[u64; 3]> = vectors.map(|vector| vector.map(f64::to_bits)).collect();
        (bits, field.control.to_bits())
    };
    let expected = bits(Workers::One);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| bits(Workers::Pool)) == expected, "{threads} threads");
    }
}

#[test]
fn forcings_that_differ_have_different_identities() {
    let sine = || typed(["sin(2*pi*y/ly)", "0", "0"], ["1", "0", "0"]);
    let with = |parameters: &[(&str, f64)]| {
        let mut choice = sine();
        if let ForcingKind::Expression(source) = &mut choice.kind {
            source.parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        }
        choice
    };
    let choices = [
        sine(),
        ForcingChoice { remove_mean_force: false, ..sine() },
        typed(["0", "sin(2*pi*y/ly)", "0"], ["1", "0", "0"]),
        typed(["sin(2*pi*y/ly)", "0", "0"], ["0", "1", "0"]),
        // The same letters, cut elsewhere.
        typed(["sin(2*pi*y/ly)0", "", "0"], ["1", "0", "0"]),
        with(&[("a", 1.0)]),
        with(&[("a", 2.0)]),
        with(&[("b", 1.0)]),
        with(&[("a", 1.0), ("b", 1.0)]),
        forcing(ForcingKind::ColorDrift),
        forcing(ForcingKind::Sinusoidal),
    ];
    for (k, choice) in choices.iter().enumerate() {
        assert!(choices[..k].iter().all(|other| other.identity() != choice.identity()), "{choice:?}");
        assert_eq!(choice.identity(), choice.clone().identity());
    }
    // What runs of earlier versions drew must stay what it was.
    assert_eq!(forcing(ForcingKind::ColorDrift).identity(), (0, vec![]));
    assert_eq!(forcing(ForcingKind::TwoParticleDrift).identity(), (1, vec![]));
    assert_eq!(forcing(ForcingKind::Sinusoidal).identity(), (2, vec![0, 1, 1, 1]));
    assert_eq!(forcing(ForcingKind::PiecewiseLinear).identity(), (3, vec![0, 1, 1, 1]));
    assert_eq!(forcing(ForcingKind::PiecewiseConstant).identity(), (4, vec![0, 1, 1, 1]));
}

#[test]
fn typed_forcings_that_cannot_be_are_refused() {
    let refused = |force, response| typed(force, response).field(192, [4.0, 5.0, 8.0]).unwrap_err().to_string();
    let sine = ["sin(2*pi*y/ly)", "0", "0"];
    assert_eq!(
        refused(["0", "z", "0"], sine),
        "force[1]: must be the same on opposite faces of the box, but the force jumps by -8.000e0 from z = 8 to z = 0 \
         (at x = 0, y = 0, z = 8)"
    );
    assert_eq!(
        refused(sine, ["0", "0", "1/(1 + color)"]),
        "response[2]: must be finite, but at x = 0, y = 0, z = 0 the response of color -1 is inf"
    );
    assert_eq!(
        refused(sine, ["sqrt(abs(sin(2*pi*x/lx)))", "0", "0"]),
        "response[0]: must be finite, but at x = 0, y = 0, z = 0 the slope of the response is inf"
    );
    // Nobody asks how fast a force rises.
    assert!(typed(["sqrt(x*(lx - x))", "0", "0"], sine).field(192, [4.0; 3]).is_ok());
    assert_eq!(typed(sine, ["0", "1 - 1", "0"]).field(192, [4.0; 3]).unwrap_err(), ForcingError::Vanishing("response"));
    assert_eq!(
        typed(sine, sine).field(1, [4.0; 3]).unwrap_err(),
        ForcingError::TooFewParticles { needed: 2, found: 1 }
    );
}
