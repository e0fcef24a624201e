//! Viscosities from correlations of the stress (Green 1954, Kubo 1957; without noise: Ernst & Brito 2005, Jung & Schmid 2016).

use super::correlation::{CorrelationRecorder, Correlations, Sample, Sampler, integral_conditions, interval};
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells};
use mesoflux_analysis::{CorrelationPoint, Integral, IntegralOptions, MultipleTau, Quadrature};
use mesoflux_core::observable::Stress;
use mesoflux_core::run::Moment;
use mesoflux_core::tensor::SymmetricTensor;
use mesoflux_io::input::{CorrelationInput, Input, Quantity};
use mesoflux_io::results::Table;

/// Which viscosity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Viscosity {
    /// η, from the five independent components of the traceless momentum flux.
    Shear,
    /// ζ, from its trace.
    Bulk,
}

impl Viscosity {
    /// The viscosity that a quantity is.
    pub fn of(quantity: Quantity) -> Self {
        if quantity == Quantity::BulkViscosity { Self::Bulk } else { Self::Shear }
    }

    /// The components of the momentum flux that have the viscosity's correlations.
    fn components(self, flux: SymmetricTensor) -> Vec<f64> {
        match self {
            Self::Shear => flux.shear().to_vec(),
            Self::Bulk => vec![flux.trace() / 3.0],
        }
    }

    fn count(self) -> usize {
        match self {
            Self::Shear => 5,
            Self::Bulk => 1,
        }
    }

    /// V times what the random forces add at once.
    fn instantaneous(self, stress: &Stress) -> f64 {
        match self {
            Self::Shear => stress.instantaneous_shear().iter().sum::<f64>() / 5.0,
            Self::Bulk => stress.instantaneous_bulk(),
        }
    }

    /// A correlator of so many series for each component, for pairs of them; fluctuations about the mean pressure for ζ.
    fn correlator(self, series: usize, pair: [usize; 2], spacing: f64) -> Result<MultipleTau, RouteError> {
        let count = self.count();
        let pairs: Vec<[usize; 2]> = (0..count).map(|c| pair.map(|of| of * count + c)).collect();
        let mut correlator = MultipleTau::new(series * count, &pairs, spacing)?;
        if self == Self::Bulk {
            for channel in 0..series * count {
                correlator = correlator.remove_mean(channel)?;
            }
        }
        Ok(correlator)
    }
}

/// η = η_∞ + (1/VkT) ∫₀^∞ ⟨J₊(t) J₋(0)⟩ dt: see the book's page on Green–Kubo.
pub(super) struct NoiseFree {
    pub viscosity: Viscosity,
    pub parameters: CorrelationInput,
}

/// Reads J₊ and J₋.
struct Fluxes(Viscosity);

impl Sampler for Fluxes {
    fn sample(&mut self, moment: &mut Moment) -> Sample {
        let system = &mut moment.simulation.system;
        let stress = Stress::of(system);
        let mut channels = self.0.components(stress.forward());
        channels.extend(self.0.components(stress.backward()));
        Sample { channels: vec![channels], averages: vec![system.kinetic_temperature(), self.0.instantaneous(&stress)] }
    }
}

impl Route for NoiseFree {
    fn method(&self) -> &'static str {
        "green_kubo"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let interval = interval(input, self.parameters.sample_interval);
        let spacing = interval as f64 * input.dynamics.time_step;
        // J₊, the first series, comes later; J₋, the second, comes earlier.
        let correlator = self.viscosity.correlator(2, [0, 1], spacing)?;
        CorrelationRecorder::boxed(interval, Fluxes(self.viscosity), vec![correlator], 2)
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let correlations = records[0].correlations()?;
        let scale = Scale::of(input, correlations);
        let function = &correlations.functions[0];
        let quadrature = Quadrature::Smooth;
        let integral = function.integral(&IntegralOptions { quadrature, longest_time: self.parameters.longest_lag });
        let instantaneous = correlations.averages.component(1).scaled(1.0 / scale.volume);
        let mut outcome = scale.outcome(function, &integral, quadrature, Running::Integral);
        if let (Some(value), Some(error)) = (instantaneous.value, instantaneous.standard_error) {
            outcome.estimate.value = outcome.estimate.value.map(|integral| integral + value);
            outcome.estimate.standard_error = outcome.estimate.standard_error.map(|integral| integral.hypot(error));
            outcome.conditions.insert("instantaneous_part".to_owned(), value.into());
            outcome.conditions.insert("instantaneous_part_standard_error".to_owned(), error.into());
        }
        Ok(outcome)
    }
}

/// η = (1/VkT) Δt [½C₀ + C₁ + C₂ + …] with C_k = ⟨J_k J_0⟩ of the flux J that each step made, noise included: exact for the discrete steps.
/// With `helfand` the same from ⟨ΔG²⟩/(2VkTt), ΔG = ∫J dt (Naseri et al., eqs 59, 60).
pub(super) struct TotalStress {
    pub viscosity: Viscosity,
    pub parameters: CorrelationInput,
    pub helfand: bool,
}

/// Adds up the flux of the steps between two samples.
struct Booked {
    viscosity: Viscosity,
    total: SymmetricTensor,
    /// Its kinetic and conservative parts.
    quiet: SymmetricTensor,
    steps: u64,
}

impl Sampler for Booked {
    fn gather(&mut self, moment: &Moment) {
        if let Some(stress) = moment.stress() {
            self.total += stress.total();
            self.quiet += stress.kinetic + stress.conservative;
            self.steps += 1;
        }
    }

    fn sample(&mut self, moment: &mut Moment) -> Sample {
        let scale = 1.0 / self.steps as f64;
        let mut channels = self.viscosity.components(scale * self.total);
        channels.extend(self.viscosity.components(scale * self.quiet));
        (self.total, self.quiet, self.steps) = (SymmetricTensor::default(), SymmetricTensor::default(), 0);
        Sample { channels: vec![channels], averages: vec![moment.simulation.system.kinetic_temperature()] }
    }

    fn gathered(&self) -> Vec<f64> {
        [self.total.0.as_slice(), &self.quiet.0, &[self.steps as f64]].concat()
    }

    fn resume(&mut self, gathered: &[f64]) -> bool {
        let Some((&total, rest)) = gathered.split_first_chunk() else {
            return false;
        };
        let Some((&quiet, &[steps])) = rest.split_first_chunk() else {
            return false;
        };
        (self.total, self.quiet, self.steps) = (SymmetricTensor(total), SymmetricTensor(quiet), steps as u64);
        true
    }
}

impl Route for TotalStress {
    fn method(&self) -> &'static str {
        if self.helfand { "einstein_helfand" } else { "green_kubo_total_stress" }
    }

    fn books_stress(&self) -> bool {
        true
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let interval = interval(input, self.parameters.sample_interval);
        let spacing = interval as f64 * input.dynamics.time_step;
        // The second series is the flux without friction and noise: it shows how long is to be waited.
        let count = self.viscosity.count();
        let correlator = self.viscosity.correlator(2, [0, 0], spacing)?.remembered_by(count..2 * count)?;
        let sampler = Booked {
            viscosity: self.viscosity,
            total: SymmetricTensor::default(),
            quiet: SymmetricTensor::default(),
            steps: 0,
        };
        CorrelationRecorder::boxed(interval, sampler, vec![correlator], 1)
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let correlations = records[0].correlations()?;
        let function = &correlations.functions[0];
        let (quadrature, longest_time) = (Quadrature::Summed, self.parameters.longest_lag);
        let scale = Scale::of(input, correlations);
        Ok(if self.helfand {
            scale.outcome(function, &function.helfand_slope(longest_time), quadrature, Running::Helfand)
        } else {
            let integral = function.integral(&IntegralOptions { quadrature, longest_time });
            scale.outcome(function, &integral, quadrature, Running::Integral)
        })
    }
}

/// What makes a viscosity of an integral.
struct Scale {
    volume: f64,
    temperature: f64,
}

impl Scale {
    /// kT is that of the thermostat; without one it is the measured one.
    fn of(input: &Input, correlations: &Correlations) -> Self {
        let measured = correlations.averages.mean().map(|mean| mean[0]);
        let volume = input.region().map_or(f64::NAN, |region| region.volume());
        let temperature =
            if input.is_thermostatted() { Some(input.dynamics.temperature) } else { measured }.unwrap_or(f64::NAN);
        Self { volume, temperature }
    }

    /// The viscosity of an integral, with the correlation function and its running integral as a table.
    fn outcome(
        &self,
        function: &MultipleTau,
        integral: &Integral,
        quadrature: Quadrature,
        running: Running,
    ) -> Outcome {
        let factor = 1.0 / (self.volume * self.temperature);
        let mut outcome = Outcome::of(integral.estimate.scaled(factor));
        outcome.conditions.insert("kinetic_temperature".to_owned(), self.temperature.into());
        outcome.conditions.extend(integral_conditions(function, integral));
        let row = |point: CorrelationPoint| {
            let (shown, factor) = match running {
                Running::Integral => (point.integral, factor),
                Running::Helfand => (point.helfand, factor / point.time.max(f64::MIN_POSITIVE)),
            };
            let numbers = [&point.correlation.scaled(1.0 / self.volume.powi(2)), &shown.scaled(factor)];
            std::iter::once(point.time).chain(numbers.into_iter().flat_map(cells)).collect()
        };
        let header =
            ["time [t]", "correlation [p^2]", "standard_error [p^2]", "viscosity [p t]", "standard_error [p t]"];
        outcome.tables.push(("", Table::new(header, function.table(quadrature).into_iter().map(row).collect())));
        outcome
    }
}

/// What the table of a correlation function shows beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Running {
    /// The integral up to a time.
    Integral,
    /// ⟨ΔG²⟩/(2t) at a time.
    Helfand,
}
