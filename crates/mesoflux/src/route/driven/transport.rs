//! From the slope of a response curve to a transport coefficient.

use mesoflux_analysis::Estimate;
use mesoflux_core::forcing::{ForcingChoice, ForcingKind};
use mesoflux_core::integrate::Thermostat;
use mesoflux_io::input::Input;
use mesoflux_io::results::Conditions;

/// What the slope α = dR/dη at vanishing forcing says.
pub(crate) enum Transport {
    /// The mobility α itself.
    Mobility,
    /// α itself, of a forcing that the user types.
    Typed { remove_mean_force: bool },
    /// The shear viscosity η = (ρ/k²)(|F₁|/α − γ) at the wavenumber k of the forcing (Wu & Shang, eq. 87), ρ the number density and
    /// γ the drag of the Langevin thermostat, where there is one: it takes a part of the force that the viscous stress doesn't
    /// (Joubaud & Stoltz, Multiscale Model. Simul. 10, 191 (2012)).
    ShearViscosity {
        /// |F₁|.
        first_coefficient: f64,
        /// ρ/k².
        factor: f64,
        drag: f64,
        wavenumber: f64,
        remove_mean_force: bool,
    },
}

impl Transport {
    pub(super) fn new(input: &Input, forcing: &ForcingChoice) -> Self {
        let &ForcingChoice { ref kind, wave, remove_mean_force } = forcing;
        let Some(first_coefficient) = kind.first_coefficient() else {
            let is_typed = matches!(kind, ForcingKind::Expression(_));
            return if is_typed { Self::Typed { remove_mean_force } } else { Self::Mobility };
        };
        let sides = input.sides();
        let density = input.particles() as f64 / sides.iter().product::<f64>();
        let wavenumber = wave.wavenumber(sides);
        let factor = density / (wavenumber * wavenumber);
        let drag = match input.dynamics.thermostat {
            Thermostat::Langevin(bath) => bath.friction,
            Thermostat::PairOrnsteinUhlenbeck | Thermostat::None => 0.0,
        };
        Self::ShearViscosity { first_coefficient, factor, drag, wavenumber, remove_mean_force }
    }

    /// From the slope of the flux against the forcing.
    pub(super) fn of_slope(&self, slope: Estimate) -> Estimate {
        match self {
            Self::Mobility | Self::Typed { .. } => slope,
            Self::ShearViscosity { .. } => self.of_inverse_slope(slope.inverse()),
        }
    }

    /// From the slope of the forcing against the flux.
    pub(super) fn of_inverse_slope(&self, slope: Estimate) -> Estimate {
        match self {
            Self::Mobility | Self::Typed { .. } => slope.inverse(),
            Self::ShearViscosity { first_coefficient, factor, drag, .. } => {
                let mut viscosity = slope.scaled(factor * first_coefficient);
                viscosity.value = viscosity.value.map(|value| value - factor * drag);
                viscosity
            }
        }
    }

    /// What a reader must know of the coefficient.
    pub(super) fn conditions(&self) -> Conditions {
        match self {
            Self::Mobility => Conditions::new(),
            Self::Typed { remove_mean_force } => {
                Conditions::from([("remove_mean_force".to_owned(), (*remove_mean_force).into())])
            }
            Self::ShearViscosity { wavenumber, remove_mean_force, .. } => Conditions::from([
                ("wavenumber".to_owned(), (*wavenumber).into()),
                ("remove_mean_force".to_owned(), (*remove_mean_force).into()),
            ]),
        }
    }
}
