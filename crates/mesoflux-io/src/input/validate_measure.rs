//! What a measurement must fulfil: routes that lead to its quantity, laws that allow it, a driving that can act.

use super::field::wrong_expression;
use super::routes::rests_on_momentum;
use super::structure::MOST_BINS;
use super::validate::{Invalid, number, written};
use super::wording::one_of;
use super::{CountingInput, Input, MeasureInput, ProfileInput, Quantity, RoutesInput};
use mesoflux_core::forcing::{ForcingChoice, ForcingError, ForcingKind, Wave};
use mesoflux_core::observable::{check_configurational_temperature, check_pressure};
use mesoflux_core::potential::Requirement;

impl Input {
    /// Checks one measurement, called `path` in messages.
    pub(super) fn validate_measure(&self, path: &str, measure: &MeasureInput) -> Result<(), Invalid> {
        let routes = measure.quantity.default_routes(&measure.routes);
        let given = routes.names();
        let allowed = measure.quantity.routes();
        if given.is_empty() {
            return Err(Invalid::new(path, "", format!("must name at least one route, of {}", allowed.join(", "))));
        }
        for route in &given {
            if !allowed.contains(route) {
                let quantity = measure.quantity.name();
                let requirement = format!("does not lead to {quantity}: must be {}", one_of(allowed));
                return Err(Invalid::new(format!("{path}.routes.{route}"), "", requirement));
            }
            if rests_on_momentum(route) && !self.integrator_conserves_momentum() {
                let requirement = "rests on the conservation of momentum: must be left out with dynamics.thermostat.langevin, \
                                   whose drag takes momentum away and screens hydrodynamics";
                return Err(Invalid::new(format!("{path}.routes.{route}"), "", requirement));
            }
        }
        let laws = self.interactions();
        let refused =
            |error: mesoflux_core::observable::ObservableError| Invalid::new(format!("{path}.quantity"), "", error);
        match measure.quantity {
            quantity if quantity.is_of_a_uniform_fluid() && !self.field.is_empty() => {
                let requirement = format!(
                    "an external field makes the fluid another in every place: {} must be measured without [field]",
                    quantity.name().replace('_', " ")
                );
                return Err(Invalid::new(format!("{path}.quantity"), "", requirement));
            }
            Quantity::BulkViscosity if !self.is_thermostatted() && self.run.replicas > 1 => {
                let requirement = "needs run.replicas = 1 at constant energy: each replica has an energy of its own, and with it \
                                   a mean pressure from which its fluctuations count";
                return Err(Invalid::new(format!("{path}.quantity"), "", requirement));
            }
            // Viscosities are of the fluid that is simulated, where nothing is felt of a jump of the energy.
            Quantity::Pressure => check_pressure(&laws).map_err(refused)?,
            Quantity::ConfigurationalTemperature => check_configurational_temperature(&laws).map_err(refused)?,
            _ => {}
        }
        if routes.derivative.is_some() {
            check_pressure(&laws).map_err(refused)?;
        }
        self.validate_structure(path, measure, &routes)?;
        self.validate_speeds(path, &routes)?;
        match (measure.quantity.needs_observable(), measure.observable) {
            (true, None) => {
                let requirement = "observable is missing: say of what, e.g. observable = \"pressure\"";
                return Err(Invalid::new(path, "", requirement));
            }
            (false, Some(_)) => {
                let requirement = format!("must be left out: {} belongs to no observable", measure.quantity.name());
                return Err(Invalid::new(format!("{path}.observable"), "", requirement));
            }
            _ => {}
        }
        for (route, lag) in routes.longest_lags() {
            self.validate_lag(&format!("{path}.routes.{route}.longest_lag"), lag)?;
        }
        let steps = self.steps(self.run.production_time);
        for (route, interval) in routes.sample_intervals() {
            if !(1..=steps).contains(&interval) {
                let requirement = format!("must be at least 1 and at most the steps of production, {steps}");
                return Err(Invalid::new(format!("{path}.routes.{route}.sample_interval"), interval, requirement));
            }
        }
        if let Some(counting) = routes.counting {
            validate_counting(&format!("{path}.routes.counting"), counting)?;
        }
        if let Some(0) = routes.transverse_current.map(|route| route.wavenumbers) {
            let place = format!("{path}.routes.transverse_current.wavenumbers");
            return Err(Invalid::new(place, 0, "must be at least 1"));
        }
        self.validate_momentum_exchange(path, measure)?;
        self.validate_driving(path, measure, &routes)
    }

    fn validate_lag(&self, path: &str, lag: f64) -> Result<(), Invalid> {
        number(path, lag, Requirement::Positive)?;
        if lag > self.run.production_time {
            let requirement = format!("must be at most the production time, {}", self.run.production_time);
            return Err(Invalid::new(path, written(lag), requirement));
        }
        Ok(())
    }

    fn validate_driving(&self, path: &str, measure: &MeasureInput, routes: &RoutesInput) -> Result<(), Invalid> {
        self.validate_forcing(path, measure)?;
        let magnitudes = routes.nemd.as_ref().map(|nemd| ("nemd", "magnitude", &nemd.magnitude, nemd.recordings()));
        let fluxes = routes.norton.as_ref().map(|norton| ("norton", "flux", &norton.flux, norton.recordings()));
        for (route, key, values, recordings) in magnitudes.into_iter().chain(fluxes) {
            let key = format!("routes.{route}.{key}");
            if measure.forcing.is_none() {
                let example = match measure.quantity {
                    Quantity::Mobility => "forcing = \"color_drift\"",
                    Quantity::TransportCoefficient => TYPED,
                    _ => "forcing = \"sinusoidal\"",
                };
                let requirement = format!("forcing is missing: {key} needs one, e.g. {example}");
                return Err(Invalid::new(path, "", requirement));
            }
            if !self.dynamics.has_word() {
                return Err(Invalid::new(
                    format!("{path}.{key}"),
                    "",
                    "needs a splitting word such as \"ABOBA\": other schemes have no letters between which to act",
                ));
            }
            if values.0.is_empty() {
                return Err(Invalid::new(format!("{path}.{key}"), "[]", "must hold at least one number"));
            }
            for (index, &value) in values.0.iter().enumerate() {
                let place = if values.0.len() > 1 { format!("{path}.{key}.{index}") } else { format!("{path}.{key}") };
                if !value.is_finite() {
                    return Err(Invalid::new(place, written(value), "must be finite"));
                }
                if values.0[..index].contains(&value) {
                    return Err(Invalid::new(place, written(value), "must not be given twice"));
                }
            }
            if values.0.iter().all(|&value| value == 0.0) && recordings.are_none() {
                let requirement = "must hold a number that isn't zero, unless autocorrelation, histogram or profile is asked for: \
                                   what is measured at zero tells no coefficient";
                return Err(Invalid::new(format!("{path}.{key}"), "", requirement));
            }
            let place = format!("{path}.routes.{route}");
            if let Some(counting) = recordings.histogram {
                validate_counting(&format!("{place}.histogram"), counting)?;
            }
            if let Some(ProfileInput { bins }) = recordings.profile {
                if !measure.forcing.as_ref().is_some_and(ForcingKind::is_shear) {
                    let requirement = "must be left out: only a forcing that drives a shear flow, such as \"sinusoidal\", has a profile";
                    return Err(Invalid::new(format!("{place}.profile"), "", requirement));
                }
                if !(2..=MOST_BINS).contains(&bins) {
                    let requirement = format!("must be from 2 to {MOST_BINS}");
                    return Err(Invalid::new(format!("{place}.profile.bins"), bins, requirement));
                }
            }
        }
        Ok(())
    }

    /// A forcing that drives what is measured, in a box and with particles that allow it.
    fn validate_forcing(&self, path: &str, measure: &MeasureInput) -> Result<(), Invalid> {
        let shears = measure.forcing.as_ref().is_some_and(ForcingKind::is_shear);
        let exchanges = measure.routes.momentum_exchange.is_some();
        let is_typed = matches!(measure.forcing, Some(ForcingKind::Expression(_)));
        let misplaced = [
            ("flow", measure.flow.is_some() && !shears && !exchanges),
            ("gradient", measure.gradient.is_some() && !shears && !exchanges),
            ("waves", measure.waves.is_some() && !shears),
            ("remove_mean_force", measure.remove_mean_force.is_some() && !shears && !is_typed),
        ];
        if let Some((key, _)) = misplaced.into_iter().find(|(_, misplaced)| *misplaced) {
            let requirement =
                "must be left out: it belongs to a forcing that drives a shear flow, such as \"sinusoidal\"";
            return Err(Invalid::new(format!("{path}.{key}"), "", requirement));
        }
        let Some(choice) = measure.forcing_choice() else {
            return Ok(());
        };
        let place = format!("{path}.forcing");
        let fits = match measure.quantity {
            Quantity::ShearViscosity => shears,
            Quantity::Mobility => !shears && !is_typed,
            Quantity::TransportCoefficient => is_typed,
            _ => false,
        };
        if !fits {
            let requirement = match measure.quantity {
                Quantity::ShearViscosity => {
                    "must be \"sinusoidal\", \"piecewise_linear\" or \"piecewise_constant\" for a shear viscosity"
                }
                Quantity::Mobility => "must be \"color_drift\" or \"two_particle_drift\" for a mobility",
                Quantity::TransportCoefficient => {
                    "must be a forcing.expression for a transport coefficient: \"color_drift\" and \"two_particle_drift\" belong to \
                     mobility, shear forcings to shear_viscosity"
                }
                _ => {
                    "must be left out: only mobility, shear_viscosity and transport_coefficient are measured by driving the fluid"
                }
            };
            let help = "what a typed forcing tells is quantity = \"transport_coefficient\"";
            return Err(Invalid::new(place, "", requirement).helped(is_typed.then(|| help.to_owned())));
        }
        choice.field(self.particles() as usize, self.sides()).map(|_| ()).map_err(|error| match error {
            ForcingError::FlowAlongGradient => Invalid::new(format!("{path}.gradient"), "", error),
            ForcingError::NoWave => Invalid::new(format!("{path}.waves"), "", error),
            ForcingError::Vanishing(key) => Invalid::new(format!("{place}.expression.{key}"), "", error),
            ForcingError::Expression { key, axis, error } => {
                wrong_expression(&format!("{place}.expression"), &format!("{key}.{axis}"), &error)
            }
            _ => Invalid::new(place, "", error),
        })
    }
}

/// What a typed forcing looks like.
const TYPED: &str = "forcing.expression = { force = [\"sin(2*pi*y/ly)\", \"0\", \"0\"], response = [\"sin(2*pi*y/ly)/n\", \"0\", \"0\"] }";

/// A range that holds something, in a number of bins that fits into memory.
fn validate_counting(place: &str, counting: CountingInput) -> Result<(), Invalid> {
    let CountingInput { range: [low, high], bins } = counting;
    if !(low.is_finite() && high.is_finite() && low < high) {
        let requirement = "must be two finite numbers, the lower one first";
        let value = format!("[{}, {}]", written(low), written(high));
        return Err(Invalid::new(format!("{place}.range"), value, requirement));
    }
    if !(1..=MOST_BINS).contains(&bins) {
        return Err(Invalid::new(format!("{place}.bins"), bins, format!("must be from 1 to {MOST_BINS}")));
    }
    Ok(())
}

impl MeasureInput {
    /// The forcing with all that it needs to be told, where one is named.
    pub fn forcing_choice(&self) -> Option<ForcingChoice> {
        let [flow, gradient] = self.flow_and_gradient();
        let wave = Wave { flow, gradient, waves: self.waves.unwrap_or(1) };
        let remove_mean_force = self.remove_mean_force.unwrap_or(true);
        self.forcing.clone().map(|kind| ForcingChoice { kind, wave, remove_mean_force })
    }

    /// Fills in what a forcing leaves open.
    pub(super) fn fill_forcing(&mut self) {
        let Some(ForcingChoice { kind, wave, remove_mean_force }) = self.forcing_choice() else {
            return;
        };
        if kind.is_shear() {
            (self.flow, self.gradient, self.waves) = (Some(wave.flow), Some(wave.gradient), Some(wave.waves));
        }
        if kind.is_shear() || matches!(kind, ForcingKind::Expression(_)) {
            self.remove_mean_force = Some(remove_mean_force);
        }
    }
}
