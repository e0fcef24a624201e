//! The input file: tables of plain structs that are at once schema, defaults and documentation.

mod build;
mod choice;
mod diagnostic;
mod document;
mod field;
mod molecules;
mod momentum_exchange;
mod route_parameters;
mod routes;
mod speed_distribution;
mod start;
mod structure;
mod sweep;
mod validate;
mod validate_measure;
mod validate_system;
mod wording;

pub use choice::{Intervals, Magnitudes};
pub use document::{InputError, InputFile, Setting};
pub use field::FieldInput;
pub use molecules::{BlockInput, BondInput, Chain, ExclusionsInput, MoleculeInput};
pub use momentum_exchange::{ExchangeKind, ExchangeStrength, MomentumExchangeInput, StrainRateInput};
pub use route_parameters::{
    CorrelationInput, CountingInput, DrivenRecordings, MeanSquaredDisplacementInput, NemdInput, NortonInput, Plain,
    ProfileInput, RoutesInput, TransverseCurrentInput,
};
pub use speed_distribution::SpeedHistogramInput;
pub use start::{FileStart, Files, Loaded, MomentaStart, StartInput};
pub use structure::{DerivativeInput, DistributionInput, FluctuationInput};
pub use sweep::{Point, Sweep};
pub use validate::Invalid;

use mesoflux_core::forcing::{Axis, ForcingKind};
use mesoflux_core::friction::Friction;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::integrate::{SweepOrder, Thermostat};
use mesoflux_core::potential::Potential;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Everything a user asks for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// What the run is about, for the reader of its results.
    #[serde(default)]
    pub title: String,
    /// How many particles in which box.
    pub system: SystemInput,
    /// The species by name; one of mass 1 if none is named.
    #[serde(default)]
    pub species: BTreeMap<String, SpeciesInput>,
    /// Pair laws: `all`, and overrides for pairs of species such as `A-B`.
    #[serde(default)]
    pub pair: BTreeMap<String, PairInput>,
    /// The kinds of bonds, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub bond: BTreeMap<String, BondInput>,
    /// The molecules to make of bonded particles, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub molecule: BTreeMap<String, MoleculeInput>,
    /// Which pair laws particles of one molecule don't feel.
    #[serde(default, skip_serializing_if = "ExclusionsInput::is_none")]
    pub exclusions: ExclusionsInput,
    /// External fields, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub field: BTreeMap<String, FieldInput>,
    /// Temperature, integrator and time step.
    pub dynamics: DynamicsInput,
    /// How long, how often, with which seed.
    pub run: RunInput,
    /// What to measure, by a name of the user's choice.
    #[serde(default)]
    pub measure: BTreeMap<String, MeasureInput>,
    /// What to check beside.
    #[serde(default, skip_serializing_if = "CheckInput::is_none")]
    pub check: CheckInput,
    /// Values to try in turn: the path of a key, as in this file, with an array of values. Several keys give all combinations.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub sweep: toml::Table,
}

/// `[system]`: two of particles, density and box decide the third (all three must fit together); with the box left out it is
/// a cube. A start from a file decides all three.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SystemInput {
    /// N; may be left out where the species say how many they are.
    #[serde(default)]
    pub particles: Option<u64>,
    /// ρ = N/V.
    #[serde(default)]
    pub density: Option<f64>,
    /// The sides of the box.
    #[serde(default, rename = "box", deserialize_with = "choice::three")]
    pub sides: Option<[f64; 3]>,
    /// Where the particles start.
    #[serde(default)]
    pub start: StartInput,
    /// The particles of the file that `start` names, once it is read.
    #[serde(skip)]
    pub loaded: Option<Arc<Loaded>>,
}

/// `[species.NAME]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeciesInput {
    /// m.
    #[serde(default = "one")]
    pub mass: f64,
    /// How many particles are of this species, those in molecules included; a single species takes all, one that is left out has
    /// those in molecules alone.
    #[serde(default)]
    pub particles: Option<u64>,
}

impl Default for SpeciesInput {
    fn default() -> Self {
        Self { mass: 1.0, particles: None }
    }
}

fn one() -> f64 {
    1.0
}

/// `[pair.all]` or `[pair.A-B]`; "none" switches a law of `all` off.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairInput {
    /// The conservative law.
    #[serde(default, with = "choice", skip_serializing_if = "Option::is_none")]
    pub potential: Option<Option<Potential>>,
    /// The friction law.
    #[serde(default, with = "choice", skip_serializing_if = "Option::is_none")]
    pub friction: Option<Option<Friction>>,
}

/// `[dynamics]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DynamicsInput {
    /// kT.
    pub temperature: f64,
    /// Δt.
    pub time_step: f64,
    /// The splitting; "ABOBA" unless velocity Verlet is chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub word: Option<String>,
    /// What the letter O stands for.
    #[serde(default = "DynamicsInput::default_thermostat")]
    pub thermostat: Thermostat,
    /// The direction of the thermostat's sweep over the pairs.
    #[serde(default)]
    pub sweep: SweepOrder,
    /// Groot and Warren's velocity Verlet in place of a word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_verlet: Option<VelocityVerletInput>,
    /// The explicit scheme of Naseri et al. in place of a word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explicit: Option<ExplicitInput>,
}

impl DynamicsInput {
    fn default_thermostat() -> Thermostat {
        Thermostat::PairOrnsteinUhlenbeck
    }

    /// Whether time goes on by the letters of a word.
    pub fn has_word(&self) -> bool {
        self.velocity_verlet.is_none() && self.explicit.is_none()
    }

    /// The splitting word in force where no other scheme is chosen.
    pub fn word(&self) -> &str {
        self.word.as_deref().unwrap_or("ABOBA")
    }
}

/// `dynamics.velocity_verlet`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VelocityVerletInput {
    /// λ: how far velocities are predicted.
    #[serde(default = "VelocityVerletInput::default_lambda")]
    pub lambda: f64,
    /// How the noise's own effect on a friction that depends on the radial velocity is taken into account.
    #[serde(default)]
    pub correction: Correction,
}

/// `dynamics.explicit`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplicitInput {
    /// How the noise's own effect on a friction that depends on the radial velocity is taken into account.
    #[serde(default)]
    pub correction: Correction,
}

impl VelocityVerletInput {
    fn default_lambda() -> f64 {
        0.5
    }
}

/// `[run]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunInput {
    /// The seed of all noise.
    #[serde(default = "RunInput::default_seed")]
    pub seed: u64,
    /// Independent runs of everything.
    #[serde(default = "RunInput::default_replicas")]
    pub replicas: u64,
    /// Time before anything is measured.
    pub equilibration_time: f64,
    /// Time during which is measured, in each replica.
    pub production_time: f64,
    /// How far the neighbor list sees beyond the largest cutoff; derived from time step and box if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skin: Option<f64>,
    /// Steps between two checkpoints of a run, beside those by wall time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checkpoint_interval: Option<u64>,
    /// Wall time between two checkpoints of a run, in seconds; at least a hundred times what the last one took, so that they cost < 1 %.
    #[serde(default = "RunInput::default_checkpoint_wall_seconds")]
    pub checkpoint_wall_seconds: f64,
    /// Steps between two samples of quantities that cost a pass over the pairs.
    #[serde(default = "RunInput::default_sample_interval")]
    pub sample_interval: u64,
}

impl RunInput {
    fn default_seed() -> u64 {
        1
    }

    fn default_replicas() -> u64 {
        1
    }

    fn default_checkpoint_wall_seconds() -> f64 {
        300.0
    }

    fn default_sample_interval() -> u64 {
        10
    }
}

/// `[check]`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckInput {
    /// `[check.time_step]`: everything once more with half the time step, in independent runs over the same times; the results
    /// then say what each estimate owes to the time step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_step: Option<Plain>,
}

impl CheckInput {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// `[measure.NAME]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasureInput {
    /// What is wanted.
    pub quantity: Quantity,
    /// How the fluid is driven, for the routes that drive it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forcing: Option<ForcingKind>,
    /// The axis along which a shear forcing pushes, or momentum is exchanged; x if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flow: Option<Axis>,
    /// The axis along which a shear flow changes; y if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<Axis>,
    /// How many waves of a shear forcing fit into the box; 1 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waves: Option<u32>,
    /// Whether the mean of a forcing that shears or is typed is removed over the particles at every step, so that momentum is
    /// conserved; so it is if left out. Without, the box drifts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remove_mean_force: Option<bool>,
    /// Whose fluctuations are measured, for quantities that belong to an observable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observable: Option<Observable>,
    /// The ways to the quantity; several are a cross-check. Most quantities have one that is taken where none is named.
    #[serde(default)]
    pub routes: RoutesInput,
}

/// Quantities that can be measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// kT from the momenta.
    Temperature,
    /// kT from the forces.
    ConfigurationalTemperature,
    /// The pressure.
    Pressure,
    /// The potential energy of the whole system.
    PotentialEnergy,
    /// The self-diffusion coefficient, as the box gives it.
    DiffusionCoefficient,
    /// The mobility, drift velocity over force.
    Mobility,
    /// α = lim R/η of a forcing that the user types, in the units of its response over its force.
    TransportCoefficient,
    /// g(r), a table for every pair of species.
    RadialDistribution,
    /// κ_T = (∂ρ/∂P)_T/ρ.
    IsothermalCompressibility,
    /// The isothermal speed of sound, √(1/(ρ_m κ_T)) with ρ_m the mass density.
    ///
    /// A DPD fluid's energy is not conserved: the thermostat holds the temperature of every region, so that sound of long waves is
    /// isothermal. An adiabatic speed there is none.
    SoundSpeed,
    /// The shear viscosity η.
    ShearViscosity,
    /// The bulk viscosity ζ.
    BulkViscosity,
    /// The integrated autocorrelation time τ = ∫₀^∞ C(t)/C(0) dt of an observable.
    CorrelationTime,
    /// The asymptotic variance σ² = 2∫₀^∞ C(t) dt of an observable: the squared error of its mean over a long time T is σ²/T.
    AsymptoticVariance,
    /// The probability density of an observable.
    ProbabilityDensity,
    /// The probability density of the particles' speeds, against Maxwell's; its number is the kT that the momenta have.
    SpeedDistribution,
}

/// Observables whose fluctuations can be measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Observable {
    /// kT from the momenta.
    Temperature,
    /// The pressure by the virial.
    Pressure,
    /// The potential energy of the whole system.
    PotentialEnergy,
    /// The stress σ_xy, its kinetic and conservative parts.
    ShearStress,
}
