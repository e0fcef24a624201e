//! Routes: ways from runs to a coefficient, one file each. A route states the runs it needs and turns their records into an estimate.

mod average;
mod compressibility;
mod configurational;
mod correlation;
mod driven;
mod fluctuation;
mod green_kubo;
mod mean_squared_displacement;
mod memory;
mod momentum_exchange;
mod observable;
mod probability_density;
mod profile;
mod radial_distribution;
mod record;
mod relaxation;
mod speed_distribution;
mod transverse_current;
mod velocity_autocorrelation;

pub use correlation::Correlations;
pub use driven::DrivenRecord;
pub use momentum_exchange::ExchangeRecord;
pub use record::Record;
pub use speed_distribution::SpeedRecord;

use crate::figure::Figure;
use compressibility::Wanted;
use green_kubo::Viscosity;
use mesoflux_analysis::{AnalysisError, Estimate};
use mesoflux_core::driving::{Projection, Slabs};
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_core::observable::{StrainRateError, Thermodynamics};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_io::input::{ExchangeStrength, Input, MeasureInput, Quantity};
use mesoflux_io::results::{Conditions, Table};
use std::io::{self, Write};

/// How a run is driven; runs that agree in it are the same run, whichever routes ask for them.
#[derive(Debug, Clone, PartialEq)]
pub enum RunKind {
    /// Not at all.
    Equilibrium,
    /// By a constant force η.
    Nemd {
        /// What is pushed.
        forcing: ForcingChoice,
        /// η.
        magnitude: f64,
    },
    /// At a constant flux r.
    Norton {
        /// What is pushed.
        forcing: ForcingChoice,
        /// r.
        flux: f64,
        /// How it is held.
        projection: Projection,
    },
    /// By an exchange of momentum between two slabs.
    MomentumExchange {
        /// Where.
        slabs: Slabs,
        /// How strongly.
        strength: ExchangeStrength,
        /// Steps from one exchange to the next.
        interval: u64,
        /// By which the flow at the start is predicted.
        predicted_viscosity: Option<f64>,
    },
    /// Not at all, at another density.
    AtDensity {
        /// What the density of the input is multiplied by.
        factor: f64,
    },
}

impl RunKind {
    /// The route's name in the results.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Equilibrium => "equilibrium",
            Self::Nemd { .. } => "nemd",
            Self::Norton { .. } => "norton",
            Self::MomentumExchange { .. } => "momentum_exchange",
            Self::AtDensity { .. } => "derivative",
        }
    }

    /// The driving's strength, or what else tells it from others of its name, for the results.
    pub fn point(&self) -> Conditions {
        match *self {
            Self::Equilibrium => Conditions::new(),
            Self::Nemd { magnitude, .. } => Conditions::from([("magnitude".to_owned(), magnitude.into())]),
            Self::Norton { flux, .. } => Conditions::from([("flux".to_owned(), flux.into())]),
            Self::MomentumExchange { strength, interval, .. } => {
                let interval = ("interval".to_owned(), interval.into());
                match strength {
                    ExchangeStrength::Momentum(momentum) => {
                        Conditions::from([("momentum".to_owned(), momentum.into()), interval])
                    }
                    ExchangeStrength::Stress(stress) => {
                        Conditions::from([("stress".to_owned(), stress.into()), interval])
                    }
                    ExchangeStrength::Swap => Conditions::from([interval]),
                }
            }
            Self::AtDensity { factor } => Conditions::from([("density_factor".to_owned(), factor.into())]),
        }
    }

    /// Numbers that tell this kind of run from all others; part of its noise key.
    ///
    /// The strength itself enters, not its place in a list: a list that grows leaves the runs of its old entries as they were.
    pub fn identity(&self) -> Vec<u64> {
        match self {
            Self::Equilibrium => vec![0, 0, 0],
            Self::Nemd { forcing, magnitude } => {
                let (kind, more) = forcing.identity();
                [vec![1, kind, magnitude.to_bits()], more].concat()
            }
            Self::Norton { forcing, flux, projection } => {
                let (kind, more) = forcing.identity();
                [vec![2, kind, flux.to_bits(), *projection as u64], more].concat()
            }
            Self::AtDensity { factor } => vec![3, 0, factor.to_bits()],
            Self::MomentumExchange { slabs, strength, interval, predicted_viscosity } => {
                let (kind, strength) = match strength {
                    ExchangeStrength::Momentum(momentum) => (0, momentum.to_bits()),
                    ExchangeStrength::Stress(stress) => (1, stress.to_bits()),
                    ExchangeStrength::Swap => (2, 0),
                };
                let axes = 3 * slabs.flow as u64 + slabs.gradient as u64;
                let predicted = predicted_viscosity.unwrap_or(0.0).to_bits();
                vec![4, kind, strength, *interval, axes, slabs.width.to_bits(), predicted]
            }
        }
    }
}

/// A route that cannot record or estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// The estimator refused.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// A local strain rate that can't be estimated.
    #[error(transparent)]
    StrainRate(#[from] StrainRateError),
    /// A recorder's state that can't be read.
    #[error("the state of a recorder: {0}")]
    State(#[from] postcard::Error),
    /// A recorder's state that isn't one of this recorder.
    #[error("the state of a recorder: is of another kind, or its parts don't fit together")]
    OtherState,
    /// A record of another kind than the route's own.
    #[error("the record of a run is not of the kind that the route takes")]
    WrongRecord,
}

/// What an estimate says beside its number.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Value, error, warnings.
    pub estimate: Estimate,
    /// What was measured beside, or chosen: fit window, temperature, linearity.
    pub conditions: Conditions,
    /// Tables to write beside the results, each with the end of its file's name, which the first one has none of.
    pub tables: Vec<(&'static str, Table)>,
    /// Figures of the route's own, each with the end of its file's name, as for tables.
    pub figures: Vec<(&'static str, Figure)>,
    /// Points of the response curve, for a route that drives the fluid.
    pub response: Vec<Response>,
    /// The response curve fitted to them as (forcing, flux), from end to end; empty where it is the straight line.
    pub fitted: Vec<(f64, f64)>,
    /// The slope of the response curve at vanishing forcing, flux over forcing, where the route knows it.
    pub slope: Option<f64>,
}

/// A point of a response curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// η, or the mean λ, and its standard error.
    pub forcing: (f64, f64),
    /// The mean R, or r, and its standard error.
    pub flux: (f64, f64),
}

impl Outcome {
    /// An estimate alone.
    pub fn of(estimate: Estimate) -> Self {
        let (tables, figures, response, fitted) = Default::default();
        Self { estimate, conditions: Conditions::new(), tables, figures, response, fitted, slope: None }
    }
}

/// Value and standard error for a table; not a number where an estimate can't tell.
fn cells(estimate: &Estimate) -> [f64; 2] {
    [estimate.value, estimate.standard_error].map(cell)
}

/// A number for a table; not a number where there is none.
fn cell(number: Option<f64>) -> f64 {
    number.unwrap_or(f64::NAN)
}

/// A recorder that can be kept in a checkpoint and turned into its record.
pub trait RouteRecorder: Recorder {
    /// Steps from one sample to the next.
    fn interval(&self) -> u64;

    /// Writes everything it holds, the same bytes each time.
    ///
    /// # Errors
    /// Those of `out`.
    fn save(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Takes over what `save` gave.
    ///
    /// # Errors
    /// Bytes that are no such state.
    fn load(&mut self, state: &[u8]) -> Result<(), RouteError>;

    /// What was recorded so far.
    ///
    /// # Errors
    /// A sample that was refused.
    fn finish(self: Box<Self>) -> Result<Record, RouteError>;
}

impl Recorder for Box<dyn RouteRecorder> {
    fn observe(&mut self, moment: &mut Moment) {
        self.as_mut().observe(moment);
    }
}

/// A way from runs to a quantity.
pub trait Route: Send + Sync {
    /// The method's name in the results.
    fn method(&self) -> &'static str;

    /// The runs it needs.
    fn runs(&self) -> Vec<RunKind> {
        vec![RunKind::Equilibrium]
    }

    /// Whether its recorder needs the momentum flux of every step booked.
    fn books_stress(&self) -> bool {
        false
    }

    /// A recorder for one replica of one of its runs.
    ///
    /// # Errors
    /// Parameters that the estimator refuses.
    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError>;

    /// The estimate from the records of its runs, in their order, the replicas of each merged.
    ///
    /// # Errors
    /// Records that the estimator refuses.
    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError>;
}

/// A recorder of the kinetic temperature, which every run has.
///
/// # Errors
/// None that can be met.
pub fn thermometer(input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
    average::StateRecorder::boxed(input, 1, |system| vec![system.kinetic_temperature()])
}

/// The routes that a measurement asks for.
pub fn routes(measure: &MeasureInput) -> Vec<Box<dyn Route>> {
    let asked = measure.quantity.default_routes(&measure.routes);
    let mut routes: Vec<Box<dyn Route>> = Vec::new();
    if asked.kinetic.is_some() {
        routes.push(Box::new(average::Average { method: "kinetic", read: |system| system.kinetic_temperature() }));
    }
    if asked.virial.is_some() {
        routes
            .push(Box::new(average::Average { method: "virial", read: |system| Thermodynamics::of(system).pressure }));
    }
    if asked.direct.is_some() {
        routes.push(Box::new(average::Average {
            method: "direct",
            read: |system| Thermodynamics::of(system).potential_energy,
        }));
    }
    if asked.configurational.is_some() {
        routes.push(Box::new(configurational::Configurational));
    }
    if let Some(msd) = asked.msd {
        let mobility = measure.quantity == Quantity::Mobility;
        routes.push(Box::new(mean_squared_displacement::MeanSquaredDisplacementRoute { parameters: msd, mobility }));
    }
    if let Some(parameters) = asked.vacf {
        routes.push(Box::new(velocity_autocorrelation::VelocityAutocorrelation { parameters }));
    }
    let viscosity = Viscosity::of(measure.quantity);
    if let Some(parameters) = asked.green_kubo {
        routes.push(Box::new(green_kubo::NoiseFree { viscosity, parameters }));
    }
    for (asked, helfand) in [(asked.green_kubo_total_stress, false), (asked.einstein_helfand, true)] {
        if let Some(parameters) = asked {
            routes.push(Box::new(green_kubo::TotalStress { viscosity, parameters, helfand }));
        }
    }
    if let Some(parameters) = asked.transverse_current {
        routes.push(Box::new(transverse_current::TransverseCurrent { parameters }));
    }
    if let (Some(parameters), Some(observable)) = (asked.counting, measure.observable) {
        routes.push(Box::new(probability_density::ProbabilityDensity { observable, parameters }));
    }
    let memories = [(asked.blocking.is_some(), None), (asked.correlation.is_some(), asked.correlation)];
    for (_, correlation) in memories.into_iter().filter(|(asked, _)| *asked) {
        if let Some(observable) = measure.observable {
            routes.push(Box::new(memory::Memory { observable, quantity: measure.quantity, correlation }));
        }
    }
    if let (Some(parameters), Some(forcing)) = (asked.nemd, measure.forcing_choice()) {
        routes.push(Box::new(driven::Driven(driven::Nemd { forcing, parameters })));
    }
    if let (Some(parameters), Some(forcing)) = (asked.norton, measure.forcing_choice()) {
        routes.push(Box::new(driven::Driven(driven::Norton { forcing, parameters })));
    }
    if let Some(parameters) = asked.momentum_exchange {
        routes.push(Box::new(momentum_exchange::MomentumExchange::new(measure, parameters)));
    }
    if let Some(parameters) = asked.histogram {
        routes.push(Box::new(radial_distribution::Histogram { parameters }));
    }
    if let Some(parameters) = asked.speed_histogram {
        routes.push(Box::new(speed_distribution::SpeedHistogram { parameters }));
    }
    if asked.radial_distribution.is_some() {
        routes.push(Box::new(radial_distribution::PressureFromDistribution));
    }
    let sound = measure.quantity == Quantity::SoundSpeed;
    let wanted = if sound { Wanted::SoundSpeed } else { Wanted::Compressibility };
    if let Some(derivative) = asked.derivative {
        routes.push(Box::new(compressibility::Derivative { wanted, density_steps: derivative.density_step.0 }));
    }
    if let Some(parameters) = asked.fluctuation {
        routes.push(Box::new(fluctuation::Fluctuation { wanted, parameters }));
    }
    routes
}
