//! Which routes lead to which quantity.

use super::{DistributionInput, MeanSquaredDisplacementInput, Plain, Quantity, RoutesInput};

impl Quantity {
    /// The quantity's name in input and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Temperature => "temperature",
            Self::ConfigurationalTemperature => "configurational_temperature",
            Self::Pressure => "pressure",
            Self::PotentialEnergy => "potential_energy",
            Self::DiffusionCoefficient => "diffusion_coefficient",
            Self::Mobility => "mobility",
            Self::RadialDistribution => "radial_distribution",
            Self::IsothermalCompressibility => "isothermal_compressibility",
            Self::SoundSpeed => "sound_speed",
        }
    }

    /// The routes to the quantity, by their names in the input file.
    pub fn routes(self) -> &'static [&'static str] {
        match self {
            Self::Temperature => &["kinetic"],
            Self::ConfigurationalTemperature => &["configurational"],
            Self::Pressure => &["virial", "radial_distribution"],
            Self::PotentialEnergy => &["direct"],
            Self::DiffusionCoefficient => &["msd"],
            Self::Mobility => &["msd", "nemd", "norton"],
            Self::RadialDistribution => &["histogram"],
            Self::IsothermalCompressibility | Self::SoundSpeed => &["derivative", "fluctuation"],
        }
    }

    /// The routes asked for; where none is, the one that goes without saying, if there is one.
    #[must_use]
    pub fn default_routes(self, asked: &RoutesInput) -> RoutesInput {
        let mut routes = asked.clone();
        if routes.names().is_empty() {
            match self {
                Self::Temperature => routes.kinetic = Some(Plain {}),
                Self::ConfigurationalTemperature => routes.configurational = Some(Plain {}),
                Self::Pressure => routes.virial = Some(Plain {}),
                Self::PotentialEnergy => routes.direct = Some(Plain {}),
                Self::DiffusionCoefficient => routes.msd = Some(MeanSquaredDisplacementInput::default()),
                Self::RadialDistribution => routes.histogram = Some(DistributionInput::default()),
                Self::Mobility | Self::IsothermalCompressibility | Self::SoundSpeed => {}
            }
        }
        routes
    }
}

impl RoutesInput {
    /// The names of the routes that are asked for.
    pub fn names(&self) -> Vec<&'static str> {
        [
            ("kinetic", self.kinetic.is_some()),
            ("configurational", self.configurational.is_some()),
            ("virial", self.virial.is_some()),
            ("direct", self.direct.is_some()),
            ("msd", self.msd.is_some()),
            ("nemd", self.nemd.is_some()),
            ("norton", self.norton.is_some()),
            ("histogram", self.histogram.is_some()),
            ("radial_distribution", self.radial_distribution.is_some()),
            ("derivative", self.derivative.is_some()),
            ("fluctuation", self.fluctuation.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, asked)| asked.then_some(name))
        .collect()
    }
}

impl MeanSquaredDisplacementInput {
    /// The longest time over which displacements are followed.
    pub fn longest_lag(&self, production_time: f64) -> f64 {
        self.longest_lag.unwrap_or(production_time / 20.0)
    }
}
