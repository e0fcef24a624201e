//! Which routes lead to which quantity.

use super::{
    CorrelationInput, DistributionInput, MeanSquaredDisplacementInput, Plain, Quantity, RoutesInput,
    SpeedHistogramInput,
};

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
            Self::TransportCoefficient => "transport_coefficient",
            Self::RadialDistribution => "radial_distribution",
            Self::IsothermalCompressibility => "isothermal_compressibility",
            Self::SoundSpeed => "sound_speed",
            Self::ShearViscosity => "shear_viscosity",
            Self::BulkViscosity => "bulk_viscosity",
            Self::CorrelationTime => "correlation_time",
            Self::AsymptoticVariance => "asymptotic_variance",
            Self::ProbabilityDensity => "probability_density",
            Self::SpeedDistribution => "speed_distribution",
        }
    }

    /// The routes to the quantity, by their names in the input file.
    pub fn routes(self) -> &'static [&'static str] {
        match self {
            Self::Temperature => &["kinetic"],
            Self::ConfigurationalTemperature => &["configurational"],
            Self::Pressure => &["virial", "radial_distribution"],
            Self::PotentialEnergy => &["direct"],
            Self::ProbabilityDensity => &["counting"],
            Self::SpeedDistribution => &["speed_histogram"],
            Self::DiffusionCoefficient => &["msd", "vacf"],
            Self::Mobility => &["msd", "nemd", "norton"],
            Self::TransportCoefficient => &["nemd", "norton"],
            Self::RadialDistribution => &["histogram"],
            Self::IsothermalCompressibility | Self::SoundSpeed => &["derivative", "fluctuation"],
            Self::ShearViscosity => &[
                "green_kubo",
                "green_kubo_total_stress",
                "einstein_helfand",
                "transverse_current",
                "nemd",
                "norton",
                "momentum_exchange",
            ],
            Self::BulkViscosity => &["green_kubo", "green_kubo_total_stress"],
            Self::CorrelationTime | Self::AsymptoticVariance => &["blocking", "correlation"],
        }
    }

    /// Whether the quantity is one of a fluid that is the same everywhere and conserves momentum.
    pub fn is_of_a_uniform_fluid(self) -> bool {
        matches!(
            self,
            Self::Pressure
                | Self::ShearViscosity
                | Self::BulkViscosity
                | Self::RadialDistribution
                | Self::IsothermalCompressibility
                | Self::SoundSpeed
        )
    }

    /// Whether the quantity belongs to an observable that must be named.
    pub fn needs_observable(self) -> bool {
        matches!(self, Self::CorrelationTime | Self::AsymptoticVariance | Self::ProbabilityDensity)
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
                Self::SpeedDistribution => routes.speed_histogram = Some(SpeedHistogramInput::default()),
                Self::BulkViscosity => routes.green_kubo = Some(CorrelationInput::default()),
                Self::CorrelationTime | Self::AsymptoticVariance => {
                    routes.correlation = Some(CorrelationInput::default());
                }
                Self::Mobility
                | Self::TransportCoefficient
                | Self::ProbabilityDensity
                | Self::ShearViscosity
                | Self::IsothermalCompressibility
                | Self::SoundSpeed => {}
            }
        }
        routes
    }
}

/// Whether a route takes its coefficient from the way in which conserved momentum spreads or flows.
pub(super) fn rests_on_momentum(route: &str) -> bool {
    ["green_kubo", "green_kubo_total_stress", "einstein_helfand", "transverse_current", "momentum_exchange"]
        .contains(&route)
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
            ("vacf", self.vacf.is_some()),
            ("green_kubo", self.green_kubo.is_some()),
            ("green_kubo_total_stress", self.green_kubo_total_stress.is_some()),
            ("einstein_helfand", self.einstein_helfand.is_some()),
            ("transverse_current", self.transverse_current.is_some()),
            ("counting", self.counting.is_some()),
            ("blocking", self.blocking.is_some()),
            ("correlation", self.correlation.is_some()),
            ("nemd", self.nemd.is_some()),
            ("norton", self.norton.is_some()),
            ("momentum_exchange", self.momentum_exchange.is_some()),
            ("histogram", self.histogram.is_some()),
            ("speed_histogram", self.speed_histogram.is_some()),
            ("radial_distribution", self.radial_distribution.is_some()),
            ("derivative", self.derivative.is_some()),
            ("fluctuation", self.fluctuation.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, asked)| asked.then_some(name))
        .collect()
    }
}

impl RoutesInput {
    /// The routes by a correlation in time.
    fn correlations(&self) -> [(&'static str, Option<CorrelationInput>); 7] {
        [
            ("vacf", self.vacf),
            ("green_kubo", self.green_kubo),
            ("green_kubo_total_stress", self.green_kubo_total_stress),
            ("einstein_helfand", self.einstein_helfand),
            ("correlation", self.correlation),
            ("nemd.autocorrelation", self.nemd.as_ref().and_then(|nemd| nemd.autocorrelation)),
            ("norton.autocorrelation", self.norton.as_ref().and_then(|norton| norton.autocorrelation)),
        ]
    }

    /// The longest lags that are given, by route.
    pub(super) fn longest_lags(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let msd = self.msd.as_ref().and_then(|msd| msd.longest_lag).map(|lag| ("msd", lag));
        let correlations = self.correlations().into_iter();
        msd.into_iter().chain(correlations.filter_map(|(route, given)| Some((route, given?.longest_lag?))))
    }

    /// The intervals between samples that are given, by route.
    pub(super) fn sample_intervals(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let currents = self.transverse_current.and_then(|given| given.sample_interval);
        let correlations = self.correlations().into_iter();
        let given = correlations.filter_map(|(route, given)| Some((route, given?.sample_interval?)));
        let speeds = self.speed_histogram.and_then(|given| given.sample_interval);
        let given = given.chain(speeds.map(|interval| ("speed_histogram", interval)));
        given.chain(currents.map(|interval| ("transverse_current", interval)))
    }
}

impl MeanSquaredDisplacementInput {
    /// The longest time over which displacements are followed.
    pub fn longest_lag(&self, production_time: f64) -> f64 {
        self.longest_lag.unwrap_or(production_time / 20.0)
    }
}
