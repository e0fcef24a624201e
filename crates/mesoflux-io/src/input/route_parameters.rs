//! Parameters of the routes to a quantity, as the input file gives them: `routes.NAME = { … }`.

use super::choice::Magnitudes;
use super::momentum_exchange::MomentumExchangeInput;
use super::speed_distribution::SpeedHistogramInput;
use super::structure::{DerivativeInput, DistributionInput, FluctuationInput};
use mesoflux_core::driving::Projection;
use serde::{Deserialize, Serialize};

/// `routes.…`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoutesInput {
    /// From the momenta.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinetic: Option<Plain>,
    /// From the forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configurational: Option<Plain>,
    /// From the virial.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub virial: Option<Plain>,
    /// The potential energy itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direct: Option<Plain>,
    /// From the mean squared displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub msd: Option<MeanSquaredDisplacementInput>,
    /// From the autocorrelation of the velocities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vacf: Option<CorrelationInput>,
    /// From the correlation of the stress, without its noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub green_kubo: Option<CorrelationInput>,
    /// From the autocorrelation of the stress with its noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub green_kubo_total_stress: Option<CorrelationInput>,
    /// From the mean squared displacement of the Helfand moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub einstein_helfand: Option<CorrelationInput>,
    /// From the decay of transverse currents, extrapolated to zero wavenumber.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transverse_current: Option<TransverseCurrentInput>,
    /// By counting in bins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counting: Option<CountingInput>,
    /// From blocks of growing length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocking: Option<Plain>,
    /// From the autocorrelation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<CorrelationInput>,
    /// By a constant force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nemd: Option<NemdInput>,
    /// By a constant flux.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub norton: Option<NortonInput>,
    /// By an exchange of momentum between two slabs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum_exchange: Option<MomentumExchangeInput>,
    /// By counting pairs in bins of distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<DistributionInput>,
    /// By counting speeds in bins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_histogram: Option<SpeedHistogramInput>,
    /// From the radial distribution function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radial_distribution: Option<Plain>,
    /// From the pressure at neighboring densities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub derivative: Option<DerivativeInput>,
    /// From the fluctuations of the density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluctuation: Option<FluctuationInput>,
}

/// A route without parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plain {}

/// `routes.msd`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanSquaredDisplacementInput {
    /// The longest time over which displacements are followed; a twentieth of the production time if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_lag: Option<f64>,
}

/// A route by a correlation in time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrelationInput {
    /// Steps between two samples; follows from the time in which the correlation decays if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_interval: Option<u64>,
    /// The longest lag that is looked at; as long as the data allow if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_lag: Option<f64>,
}

/// `routes.counting`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CountingInput {
    /// The lowest and the highest value that are counted; what lies outside is reported.
    pub range: [f64; 2],
    /// Into so many bins of equal width.
    #[serde(default = "CountingInput::default_bins")]
    pub bins: u64,
}

impl CountingInput {
    fn default_bins() -> u64 {
        50
    }
}

/// `routes.transverse_current`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransverseCurrentInput {
    /// How many wavenumbers 2πn/L, n = 1, 2, …, of all axes, the smallest ones.
    #[serde(default = "TransverseCurrentInput::default_wavenumbers")]
    pub wavenumbers: u32,
    /// Steps between two samples; follows from the time in which the correlation decays if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_interval: Option<u64>,
}

impl TransverseCurrentInput {
    fn default_wavenumbers() -> u32 {
        3
    }
}

/// `routes.nemd`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NemdInput {
    /// η, one number or several; at zero the fluid is in equilibrium.
    pub magnitude: Magnitudes,
    /// Also the autocorrelation of R at every η.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub autocorrelation: Option<CorrelationInput>,
    /// Also the probability density of R, counted at every step, at every η.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<CountingInput>,
    /// Also density, velocity, temperature and stress across the box, for a forcing that drives a shear flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileInput>,
}

/// `routes.norton`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NortonInput {
    /// r, one number or several; at zero the mean forcing vanishes.
    pub flux: Magnitudes,
    /// How the flux is brought back after a letter has changed it.
    #[serde(default)]
    pub projection: Projection,
    /// Also average λ(q, p) of eq. 13 along the trajectory, an independent check of the booked multipliers.
    #[serde(default)]
    pub check_forcing_observable: bool,
    /// Also the autocorrelation of λ at every r.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub autocorrelation: Option<CorrelationInput>,
    /// Also the probability density of λ, counted at every step, at every r.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<CountingInput>,
    /// Also density, velocity, temperature and stress across the box, for a forcing that drives a shear flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileInput>,
}

/// `routes.nemd.profile` and `routes.norton.profile`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileInput {
    /// Layers of equal thickness across the box, along the gradient.
    #[serde(default = "ProfileInput::default_bins")]
    pub bins: u64,
}

impl ProfileInput {
    fn default_bins() -> u64 {
        20
    }
}

/// What a driven route records beside its response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenRecordings {
    /// `autocorrelation`.
    pub autocorrelation: Option<CorrelationInput>,
    /// `histogram`.
    pub histogram: Option<CountingInput>,
    /// `profile`.
    pub profile: Option<ProfileInput>,
}

impl DrivenRecordings {
    /// Whether nothing is recorded beside.
    pub fn are_none(&self) -> bool {
        self.autocorrelation.is_none() && self.histogram.is_none() && self.profile.is_none()
    }
}

impl NemdInput {
    /// What is recorded beside R.
    pub fn recordings(&self) -> DrivenRecordings {
        let &Self { autocorrelation, histogram, profile, .. } = self;
        DrivenRecordings { autocorrelation, histogram, profile }
    }
}

impl NortonInput {
    /// What is recorded beside λ.
    pub fn recordings(&self) -> DrivenRecordings {
        let &Self { autocorrelation, histogram, profile, .. } = self;
        DrivenRecordings { autocorrelation, histogram, profile }
    }
}
