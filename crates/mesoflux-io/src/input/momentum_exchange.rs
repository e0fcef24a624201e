//! `routes.momentum_exchange`: its parameters, what they must fulfil, and what follows from them.

use super::choice::{Intervals, Magnitudes};
use super::structure::MOST_BINS;
use super::validate::{Invalid, number, written};
use super::{Input, MeasureInput};
use mesoflux_core::driving::{Exchange, Slabs};
use mesoflux_core::forcing::Axis;
use mesoflux_core::integrate::Thermostat;
use mesoflux_core::observable::Normalization;
use mesoflux_core::potential::Requirement;
use serde::{Deserialize, Serialize};

/// The thickest slabs: half of the box is left to the fluid between them.
const THICKEST: f64 = 0.25;

/// `routes.momentum_exchange`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MomentumExchangeInput {
    /// What the two particles do: `forced`, the first one is given a momentum, the second one loses it; `swap`, they exchange their
    /// velocities (Müller-Plathe's original; unequal masses collide elastically).
    #[serde(default)]
    pub kind: ExchangeKind,
    /// Δp of every forced exchange, one number or several. The stress is Δp/(2 A Δt) with Δt the time between exchanges: it changes with
    /// time step and box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum: Option<Magnitudes>,
    /// The stress of forced exchanges in place of their momentum, one number or several: Δp follows from time step and box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress: Option<Magnitudes>,
    /// Steps from one exchange to the next: 1 if left out. Swaps need it, one number or several; the longer, the smaller the stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<Intervals>,
    /// The thickness of each slab, as a fraction of the side of the box.
    #[serde(default = "MomentumExchangeInput::default_slab_width")]
    pub slab_width: f64,
    /// The fraction of the fluid between two slabs, in its middle, over which the gradient is fitted.
    #[serde(default = "MomentumExchangeInput::default_fitted_fraction")]
    pub fitted_fraction: f64,
    /// Bins of equal width across the box, along the gradient, for the profiles of velocity, density and temperature.
    #[serde(default = "MomentumExchangeInput::default_bins")]
    pub bins: u64,
    /// The viscosity by which the flow at the start is predicted, for forced exchanges; that of a mean-field theory if left
    /// out. It shortens the way to the steady state and changes no result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_viscosity: Option<f64>,
    /// Also the local velocity gradient of every particle from its neighbors, averaged over the bins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain_rate: Option<StrainRateInput>,
}

/// `routes.momentum_exchange.strain_rate`: the estimator of Naseri et al., eqs 19–26, with the weight (1 − r/r_c)^s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrainRateInput {
    /// r_c: at most the largest cutoff of any pair law.
    pub cutoff: f64,
    /// s; 0 counts all neighbors alike, as the paper does.
    #[serde(default)]
    pub exponent: f64,
    /// `local`, by the second moment that the neighbors have: exact in a uniform gradient; `isotropic`, the paper's.
    #[serde(default)]
    pub normalization: Normalization,
}

/// What the two particles of an exchange do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExchangeKind {
    /// A momentum of any size is given to one and taken from the other.
    #[default]
    Forced,
    /// They exchange their velocities along the flow.
    Swap,
}

/// How strongly is exchanged in one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExchangeStrength {
    /// By this momentum.
    Momentum(f64),
    /// By the momentum of this stress.
    Stress(f64),
    /// By whatever two particles swap.
    Swap,
}

impl MomentumExchangeInput {
    fn default_slab_width() -> f64 {
        0.1
    }

    fn default_fitted_fraction() -> f64 {
        0.6
    }

    fn default_bins() -> u64 {
        40
    }

    /// Strength and interval of every run.
    pub fn points(&self) -> Vec<(ExchangeStrength, u64)> {
        let intervals = self.interval.as_ref().map_or(&[1][..], |intervals| &intervals.0);
        if self.kind == ExchangeKind::Swap {
            return intervals.iter().map(|&interval| (ExchangeStrength::Swap, interval)).collect();
        }
        let momenta =
            self.momentum.iter().flat_map(|given| &given.0).map(|&momentum| ExchangeStrength::Momentum(momentum));
        let stresses = self.stress.iter().flat_map(|given| &given.0).map(|&stress| ExchangeStrength::Stress(stress));
        let interval = intervals.first().copied().unwrap_or(1);
        momenta.chain(stresses).map(|strength| (strength, interval)).collect()
    }

    /// Where momentum is exchanged, given the axes of the measurement.
    pub fn slabs(&self, measure: &MeasureInput) -> Slabs {
        let [flow, gradient] = measure.flow_and_gradient();
        Slabs { flow, gradient, width: self.slab_width }
    }

    /// The same exchanges at the same times with half the time step.
    pub(super) fn at_half_time_step(&mut self) {
        let intervals = self.interval.get_or_insert(Intervals(vec![1]));
        intervals.0.iter_mut().for_each(|interval| *interval = interval.saturating_mul(2));
    }
}

impl MeasureInput {
    /// The axes of a shear flow.
    pub fn flow_and_gradient(&self) -> [Axis; 2] {
        [self.flow.unwrap_or(Axis::X), self.gradient.unwrap_or(Axis::Y)]
    }

    /// Fills in what momentum exchange leaves open.
    pub(super) fn fill_momentum_exchange(&mut self) {
        let [flow, gradient] = self.flow_and_gradient();
        if let Some(route) = &mut self.routes.momentum_exchange {
            (self.flow, self.gradient) = (Some(flow), Some(gradient));
            route.interval.get_or_insert(Intervals(vec![1]));
        }
    }
}

impl Input {
    /// 2 A Δt: the momentum of an exchange over the stress that it makes, with A the area of a slab and Δt the time from one exchange
    /// to the next.
    pub fn momentum_over_stress(&self, gradient: Axis, interval: u64) -> f64 {
        let sides = self.sides();
        2.0 * sides.iter().product::<f64>() / sides[gradient as usize] * interval as f64 * self.dynamics.time_step
    }

    /// What two particles exchange.
    pub fn exchange(&self, gradient: Axis, strength: ExchangeStrength, interval: u64) -> Exchange {
        match strength {
            ExchangeStrength::Momentum(momentum) => Exchange::Forced { momentum },
            ExchangeStrength::Stress(stress) => {
                Exchange::Forced { momentum: stress * self.momentum_over_stress(gradient, interval) }
            }
            ExchangeStrength::Swap => Exchange::Swap,
        }
    }

    /// Checks the route of a measurement called `path` in messages.
    pub(super) fn validate_momentum_exchange(&self, path: &str, measure: &MeasureInput) -> Result<(), Invalid> {
        let Some(route) = &measure.routes.momentum_exchange else { return Ok(()) };
        let [flow, gradient] = measure.flow_and_gradient();
        if flow == gradient {
            let requirement = "must be another axis than the flow, whose velocity changes along it";
            return Err(Invalid::new(format!("{path}.gradient"), "", requirement));
        }
        let path = format!("{path}.routes.momentum_exchange");
        let place = |key: &str| format!("{path}.{key}");
        match route.kind {
            ExchangeKind::Forced => self.validate_forced_exchange(&path, route)?,
            ExchangeKind::Swap => {
                let given = [
                    ("momentum", route.momentum.is_some()),
                    ("stress", route.stress.is_some()),
                    ("predicted_viscosity", route.predicted_viscosity.is_some()),
                ];
                if let Some((key, _)) = given.into_iter().find(|(_, given)| *given) {
                    let requirement = "must be left out with kind = \"swap\": what is exchanged is measured; the interval decides how much";
                    return Err(Invalid::new(place(key), "", requirement));
                }
                if route.interval.is_none() {
                    let requirement = "interval is missing: with kind = \"swap\" it decides how strongly the fluid is sheared, e.g. interval = [50, 100]";
                    return Err(Invalid::new(path, "", requirement));
                }
            }
        }
        self.validate_intervals(&place("interval"), route)?;
        number(&place("slab_width"), route.slab_width, Requirement::Positive)?;
        if route.slab_width > THICKEST {
            let requirement =
                format!("must be at most {THICKEST}: half of the box is left to the fluid between the slabs");
            return Err(Invalid::new(place("slab_width"), written(route.slab_width), requirement));
        }
        number(&place("fitted_fraction"), route.fitted_fraction, Requirement::Positive)?;
        if route.fitted_fraction > 1.0 {
            let requirement = "must be at most 1, the whole fluid between two slabs";
            return Err(Invalid::new(place("fitted_fraction"), written(route.fitted_fraction), requirement));
        }
        if !(4..=MOST_BINS).contains(&route.bins) {
            return Err(Invalid::new(place("bins"), route.bins, format!("must be from 4 to {MOST_BINS}")));
        }
        if let Some(StrainRateInput { cutoff, exponent, .. }) = route.strain_rate {
            number(&place("strain_rate.cutoff"), cutoff, Requirement::Positive)?;
            number(&place("strain_rate.exponent"), exponent, Requirement::NotNegative)?;
            let longest = self.interactions().cutoff();
            if cutoff > longest {
                let requirement =
                    format!("must be at most {longest}, the largest cutoff of any pair law: no others are neighbors");
                return Err(Invalid::new(place("strain_rate.cutoff"), written(cutoff), requirement));
            }
        }
        Ok(())
    }

    fn validate_forced_exchange(&self, path: &str, route: &MomentumExchangeInput) -> Result<(), Invalid> {
        let (key, strengths) = match (&route.momentum, &route.stress) {
            (Some(momenta), None) => ("momentum", &momenta.0),
            (None, Some(stresses)) => ("stress", &stresses.0),
            (Some(_), Some(_)) => {
                let requirement = "must be left out where momentum is given: each follows from the other";
                return Err(Invalid::new(format!("{path}.stress"), "", requirement));
            }
            (None, None) => {
                let requirement =
                    "momentum or stress is missing: say how strongly the fluid is sheared, e.g. stress = [0.5, 1.0]";
                return Err(Invalid::new(path, "", requirement));
            }
        };
        if self.dynamics.thermostat == Thermostat::None {
            let requirement = "changes the energy, which nothing holds with dynamics.thermostat = \"none\": must be left out, with kind = \"swap\"";
            return Err(Invalid::new(format!("{path}.{key}"), "", requirement));
        }
        if strengths.is_empty() {
            return Err(Invalid::new(format!("{path}.{key}"), "[]", "must hold at least one number"));
        }
        for (index, &strength) in strengths.iter().enumerate() {
            let place = if strengths.len() > 1 { format!("{path}.{key}.{index}") } else { format!("{path}.{key}") };
            number(&place, strength, Requirement::Positive)?;
            if strengths[..index].contains(&strength) {
                return Err(Invalid::new(place, written(strength), "must not be given twice"));
            }
        }
        if let Some(viscosity) = route.predicted_viscosity {
            number(&format!("{path}.predicted_viscosity"), viscosity, Requirement::Positive)?;
        }
        Ok(())
    }

    fn validate_intervals(&self, path: &str, route: &MomentumExchangeInput) -> Result<(), Invalid> {
        let Some(Intervals(intervals)) = &route.interval else { return Ok(()) };
        if intervals.is_empty() {
            return Err(Invalid::new(path, "[]", "must hold at least one number"));
        }
        if intervals.len() > 1 && route.kind == ExchangeKind::Forced {
            let requirement = "must be one number for forced exchanges, whose strength is their momentum or stress";
            return Err(Invalid::new(path, "", requirement));
        }
        let steps = self.steps(self.run.production_time);
        for (index, &interval) in intervals.iter().enumerate() {
            let place = if intervals.len() > 1 { format!("{path}.{index}") } else { path.to_owned() };
            if !(1..=steps).contains(&interval) {
                let requirement = format!("must be at least 1 and at most the steps of production, {steps}");
                return Err(Invalid::new(place, interval, requirement));
            }
            if intervals[..index].contains(&interval) {
                return Err(Invalid::new(place, interval, "must not be given twice"));
            }
        }
        Ok(())
    }
}
