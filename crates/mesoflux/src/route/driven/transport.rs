//! From the slope of a response curve to a transport coefficient.

use mesoflux_analysis::Estimate;
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_io::input::Input;
use mesoflux_io::results::Conditions;

/// What the slope α = dR/dη at vanishing forcing says.
pub(crate) enum Transport {
    /// The mobility α itself.
    Mobility,
    /// The shear viscosity η = ρ|F₁|/(k²α) at the wavenumber k of the forcing (Wu & Shang, eq. 87), ρ the number density.
    ShearViscosity {
        /// ρ|F₁|/k².
        factor: f64,
        wavenumber: f64,
        remove_mean_force: bool,
    },
}

impl Transport {
    pub(super) fn new(input: &Input, forcing: ForcingChoice) -> Self {
        let ForcingChoice { kind, wave, remove_mean_force } = forcing;
        let Some(first) = kind.first_coefficient() else {
            return Self::Mobility;
        };
        let sides = input.sides();
        let density = input.particles() as f64 / sides.iter().product::<f64>();
        let wavenumber = wave.wavenumber(sides);
        Self::ShearViscosity { factor: density * first / (wavenumber * wavenumber), wavenumber, remove_mean_force }
    }

    /// From the slope of the flux against the forcing.
    pub(super) fn of_slope(&self, slope: Estimate) -> Estimate {
        match self {
            Self::Mobility => slope,
            Self::ShearViscosity { factor, .. } => slope.inverse().scaled(*factor),
        }
    }

    /// From the slope of the forcing against the flux.
    pub(super) fn of_inverse_slope(&self, slope: Estimate) -> Estimate {
        match self {
            Self::Mobility => slope.inverse(),
            Self::ShearViscosity { factor, .. } => slope.scaled(*factor),
        }
    }

    /// What a reader must know of the coefficient.
    pub(super) fn conditions(&self) -> Conditions {
        match self {
            Self::Mobility => Conditions::new(),
            Self::ShearViscosity { wavenumber, remove_mean_force, .. } => Conditions::from([
                ("wavenumber".to_owned(), (*wavenumber).into()),
                ("remove_mean_force".to_owned(), (*remove_mean_force).into()),
            ]),
        }
    }
}
