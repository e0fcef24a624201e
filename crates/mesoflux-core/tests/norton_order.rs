//! Stochastic Norton dynamics: of which order in the time step the mean forcing is.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Fluid, advance, replicas};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::driving::{ConstantFlux, Projection};
use mesoflux_core::forcing::{Axis, ForcingChoice, ForcingKind, Wave};
use mesoflux_core::noise::NoiseKey;

/// The mean booked forcing, and its difference from λ(q, p) at the ends of the steps.
fn measure(
    fluid: &Fluid,
    forcing: ForcingChoice,
    flux: f64,
    projection: Projection,
    dt: f64,
    time: f64,
) -> [Estimate; 2] {
    let parts = replicas(2, |replica| {
        let noise = NoiseKey::new(&[dt.to_bits(), projection as u64, replica]);
        let system = fluid.system(1.0, noise);
        let field = forcing.field(system.particles.count(), system.region.sides()).unwrap();
        let mut simulation =
            fluid.simulation("ABOBA", Some(Box::new(ConstantFlux::new(field, flux, projection))), noise, dt);
        advance(&mut simulation, 5.0);
        let mut series = Blocking::new(2).unwrap();
        let mut before = 0.0;
        for _ in 0..(time / dt) as u64 {
            let booked = simulation.step().unwrap().unwrap().forcing;
            let after = 0.0;
            series.record(&[booked, booked - 0.5 * (before + after)]).unwrap();
            before = after;
        }
        series
    });
    let mut all = parts.into_iter();
    let mut first = all.next().unwrap();
    all.for_each(|part| first.merge(&part).unwrap());
    [first.component(0), first.component(1)]
}

#[test]
fn explore() {
    let wave = Wave { flow: Axis::X, gradient: Axis::Y, waves: 1 };
    for (kind, fluid, flux) in [
        (ForcingKind::ColorDrift, Fluid::ideal(192, 9.0), 2.0),
        (ForcingKind::TwoParticleDrift, Fluid::ideal(192, 9.0), 2.0),
    ] {
        let forcing = ForcingChoice { kind, wave, remove_mean_force: true };
        for projection in [Projection::Paper, Projection::Symmetric] {
            for dt in [0.02, 0.04, 0.08, 0.16] {
                let [forcing, difference] = measure(&fluid, forcing, flux, projection, dt, 25000.0 * dt);
                println!(
                    "{kind:?} {projection:?} {dt}: {:.4}({:.4}) {:.5}({:.5})",
                    forcing.value.unwrap(),
                    forcing.standard_error.unwrap(),
                    difference.value.unwrap(),
                    difference.standard_error.unwrap()
                );
            }
        }
    }
}
