//! `routes.speed_histogram`: its parameters, what they must fulfil, and what follows from them.

use super::structure::MOST_BINS;
use super::validate::{Invalid, number};
use super::{Input, RoutesInput};
use mesoflux_core::potential::Requirement;
use serde::{Deserialize, Serialize};

/// The fewest bins that tell the shape of a distribution.
const FEWEST_BINS: u64 = 10;
/// How far speeds are counted where the input doesn't say it, in √(kT/m) of the lightest particles: one speed in 10⁸ lies beyond.
const FARTHEST: f64 = 6.5;

/// `routes.speed_histogram`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedHistogramInput {
    /// Bins of equal width from zero to the largest speed; faster particles are counted together.
    #[serde(default = "SpeedHistogramInput::default_bins")]
    pub bins: u64,
    /// Up to which speed; 6.5 √(kT/m) of the lightest particles if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_speed: Option<f64>,
    /// Steps from one snapshot to the next; five times as long as friction takes to make a velocity forget itself if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_interval: Option<u64>,
}

impl SpeedHistogramInput {
    fn default_bins() -> u64 {
        150
    }
}

impl Default for SpeedHistogramInput {
    fn default() -> Self {
        Self { bins: Self::default_bins(), largest_speed: None, sample_interval: None }
    }
}

impl Input {
    /// Up to which speed is counted.
    pub fn largest_speed(&self, route: &SpeedHistogramInput) -> f64 {
        let lightest = self.masses().into_iter().fold(f64::INFINITY, f64::min);
        route.largest_speed.unwrap_or_else(|| FARTHEST * (self.dynamics.temperature / lightest).sqrt())
    }

    /// Checks the route of a measurement called `path` in messages.
    pub(super) fn validate_speeds(&self, path: &str, routes: &RoutesInput) -> Result<(), Invalid> {
        let Some(route) = &routes.speed_histogram else { return Ok(()) };
        let path = format!("{path}.routes.speed_histogram");
        if !self.is_thermostatted() {
            let requirement = "needs a thermostat: at constant energy speeds have no temperature to be compared with";
            return Err(Invalid::new(path, "", requirement));
        }
        if !self.field.is_empty() {
            let requirement = "must be left out with [field], which leaves the total momentum fixed along some axes alone: \
                               no single Maxwell distribution is exact then";
            return Err(Invalid::new(path, "", requirement));
        }
        if !(FEWEST_BINS..=MOST_BINS).contains(&route.bins) {
            let requirement = format!("must be from {FEWEST_BINS} to {MOST_BINS}");
            return Err(Invalid::new(format!("{path}.bins"), route.bins, requirement));
        }
        route
            .largest_speed
            .map_or(Ok(()), |speed| number(&format!("{path}.largest_speed"), speed, Requirement::Positive))
    }
}
