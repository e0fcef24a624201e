//! The observables whose fluctuations can be asked for.

use mesoflux_core::observable::{Stress, Thermodynamics};
use mesoflux_core::system::System;
use mesoflux_io::input::Observable;

/// How an observable is read from a state.
pub(super) fn reader(observable: Observable) -> fn(&mut System) -> f64 {
    match observable {
        Observable::Temperature => |system| system.kinetic_temperature(),
        Observable::Pressure => |system| Thermodynamics::of(system).pressure,
        Observable::PotentialEnergy => |system| Thermodynamics::of(system).potential_energy,
        Observable::ShearStress => |system| {
            let stress = Stress::of(system);
            (stress.kinetic + stress.conservative).shear()[0] / system.region.volume()
        },
    }
}
