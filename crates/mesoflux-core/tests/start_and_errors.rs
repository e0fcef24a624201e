//! What is refused at the door, and how a run that blows up ends.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, forcing, splitting, velocity_verlet};
use mesoflux_core::driving::{ConstantFlux, ConstantForce, Driving, Projection};
use mesoflux_core::forcing::{ColorDrift, Forcing, ForcingError, ForcingField, ForcingKind};
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::simulation::{SetupError, Simulation};
use mesoflux_core::state::Particles;
use mesoflux_core::system::SimulationError;
use mesoflux_core::vector::Vector;

#[test]
fn an_absurd_time_step_ends_in_an_error_that_names_step_and_particle() {
    for integrator in [splitting("ABOBA"), velocity_verlet()] {
        let noise = NoiseKey::new(&[1]);
        let system = Fluid::lennard_jones(216).system(1.0, noise);
        let mut simulation = Simulation::new(system, integrator, None, noise, 0.2).unwrap();
        let error = (0..1000).find_map(|_| simulation.step().err()).unwrap();
        let SimulationError::Escaped { step, particle, distance, limit, .. } = error else { panic!("{error}") };
        assert_eq!(step, simulation.system.step, "the step under way");
        assert!(particle < 216 && !(distance < limit));
        let message = error.to_string();
        assert!(message.contains(&format!("at step {step}: particle {particle} moved")), "{message}");
        assert!(message.contains("time step is too large"), "{message}");
    }
}

#[test]
fn a_position_that_is_no_number_ends_in_an_error_that_names_its_particle() {
    let mut simulation = Fluid::groot_warren(192).simulation("ABOBA", None, NoiseKey::new(&[1]), 0.01);
    let place = simulation.system.particles.id.iter().position(|&id| id == 77).unwrap();
    simulation.system.particles.momentum[place][1] = f64::NAN;
    let error = simulation.step().unwrap_err();
    let SimulationError::Escaped { step, particle, .. } = error else { panic!("{error}") };
    assert_eq!((step, particle), (0, 77));
}

#[test]
fn velocity_verlet_refuses_a_driving() {
    let drivings: [Box<dyn Driving>; 2] = [
        Box::new(ConstantForce::new(ForcingField::new(Box::new(ColorDrift)), 1.0)),
        Box::new(ConstantFlux::new(ForcingField::new(Box::new(ColorDrift)), 1.0, Projection::Symmetric)),
    ];
    for driving in drivings {
        let noise = NoiseKey::new(&[1]);
        let system = Fluid::groot_warren(192).system(1.0, noise);
        let refused = Simulation::new(system, velocity_verlet(), Some(driving), noise, 0.01).unwrap_err();
        assert_eq!(refused, SetupError::DrivingNeedsWord);
    }
}

#[test]
fn color_drift_refuses_an_odd_number_of_particles() {
    let refused = |kind, particles| forcing(kind).field(particles, [4.0; 3]).err();
    assert_eq!(refused(ForcingKind::ColorDrift, 191), Some(ForcingError::OddParticles(191)));
    assert_eq!(refused(ForcingKind::ColorDrift, 192), None);
    assert_eq!(refused(ForcingKind::TwoParticleDrift, 191), None);
}

/// Pushes along x by color and watches the current along x, or along y, which it can't control.
#[derive(Debug)]
struct Watching {
    axis: usize,
}

impl Forcing for Watching {
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2] {
        let [force, _] = ColorDrift.at(particles, k);
        let mut response = [0.0; 3];
        response[self.axis] = force[0];
        [force, response]
    }
    fn is_balanced(&self) -> bool {
        true
    }
    fn depends_on_positions(&self) -> bool {
        false
    }
    fn check(&self, _particles: usize) -> Result<(), ForcingError> {
        Ok(())
    }
}

#[test]
fn a_flux_that_the_forcing_cannot_move_is_refused() {
    let noise = NoiseKey::new(&[1]);
    let start = |axis| {
        let driving =
            Box::new(ConstantFlux::new(ForcingField::new(Box::new(Watching { axis })), 1.0, Projection::Symmetric));
        let system = Fluid::groot_warren(192).system(1.0, noise);
        Simulation::new(system, splitting("ABOBA"), Some(driving), noise, 0.01)
    };
    assert_eq!(start(1).unwrap_err(), SetupError::Forcing(ForcingError::NoControl(0.0)));
    assert!(start(0).is_ok());
}
