//! Parameters of the routes to structure and compressibility; the same input at another density, or at half its time step.

use super::validate::{Invalid, number, rounded, written};
use super::{Input, MeasureInput, MomentumExchangeInput, Quantity, RoutesInput, choice::Magnitudes};
use mesoflux_core::observable::shells;
use mesoflux_core::potential::Requirement;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How far g(r) is followed where the input doesn't say it, in largest cutoffs, if half the box allows.
const CUTOFFS: f64 = 3.0;
/// The most bins of distance.
pub(super) const MOST_BINS: u64 = 10_000;
/// The most wave vectors.
const MOST_WAVE_VECTORS: f64 = 1000.0;
/// The fewest shells of wave vectors from which 1/S(k) can be extrapolated by a parabola with an error that tells something.
const FEWEST_SHELLS: usize = 4;

/// `routes.histogram`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DistributionInput {
    /// How far g(r) is followed, at most half the shortest side of the box; three times the largest cutoff if left out, or half
    /// the shortest side where that is less.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_distance: Option<f64>,
    /// Bins of equal width from zero to the longest distance.
    #[serde(default = "DistributionInput::default_bins")]
    pub bins: u64,
}

impl DistributionInput {
    fn default_bins() -> u64 {
        100
    }
}

impl Default for DistributionInput {
    fn default() -> Self {
        Self { longest_distance: None, bins: Self::default_bins() }
    }
}

/// `routes.derivative`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivativeInput {
    /// δ, one number or several: the pressure is measured at the densities ρ(1 ± δ). With several the curvature that differences
    /// don't cancel is fitted too.
    #[serde(default = "DerivativeInput::default_density_step")]
    pub density_step: Magnitudes,
}

impl DerivativeInput {
    fn default_density_step() -> Magnitudes {
        Magnitudes(vec![0.05, 0.1])
    }
}

/// `routes.fluctuation`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluctuationInput {
    /// The largest |k| at which S(k) is measured; 2π√6 over the shortest side of the box if left out:
    /// forty wave vectors of six lengths in a cube.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_wave_number: Option<f64>,
}

impl Input {
    /// How far g(r) is followed.
    pub fn longest_distance(&self, route: &DistributionInput) -> f64 {
        route.longest_distance.unwrap_or_else(|| (CUTOFFS * self.interactions().cutoff()).min(self.half_side()))
    }

    /// The largest |k| at which S(k) is measured.
    pub fn largest_wave_number(&self, route: &FluctuationInput) -> f64 {
        route.largest_wave_number.unwrap_or_else(|| 6f64.sqrt() * 0.5 * TAU / self.half_side())
    }

    fn half_side(&self) -> f64 {
        0.5 * self.sides().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The same particles in a box of the same shape at `factor` times the density.
    #[must_use]
    pub fn at_density(&self, factor: f64) -> Self {
        let stretch = factor.cbrt().recip();
        let mut input = self.clone();
        input.system.particles = Some(self.particles());
        input.system.sides = Some(self.sides().map(|side| side * stretch));
        input.system.density = None;
        if let Some(loaded) = &mut input.system.loaded {
            let loaded = Arc::make_mut(loaded);
            let configuration = Arc::make_mut(&mut loaded.configuration);
            configuration.sides = configuration.sides.map(|side| side * stretch);
            for position in &mut configuration.positions {
                *position = position.map(|x| x * stretch);
            }
        }
        input
    }

    /// The same input with half the time step: the same times, twice as many steps, samples at the same times.
    #[must_use]
    pub fn at_half_time_step(&self) -> Self {
        let mut input = self.clone();
        input.dynamics.time_step *= 0.5;
        input.run.sample_interval = self.run.sample_interval.saturating_mul(2);
        let exchanges = input.measure.values_mut().filter_map(|measure| measure.routes.momentum_exchange.as_mut());
        exchanges.for_each(MomentumExchangeInput::at_half_time_step);
        input
    }

    /// Checks the routes to structure and compressibility of a measurement called `path` in messages.
    pub(super) fn validate_structure(
        &self,
        path: &str,
        measure: &MeasureInput,
        routes: &RoutesInput,
    ) -> Result<(), Invalid> {
        if let Some(histogram) = &routes.histogram {
            self.validate_histogram(&format!("{path}.routes.histogram"), histogram)?;
        }
        if routes.radial_distribution.is_some() && !self.bond.is_empty() {
            let requirement = "needs a fluid without bonds: g(r) does not tell bonded pairs, which feel other forces, from the others";
            return Err(Invalid::new(format!("{path}.routes.radial_distribution"), "", requirement));
        }
        if let Some(derivative) = &routes.derivative {
            self.validate_derivative(&format!("{path}.routes.derivative.density_step"), &derivative.density_step.0)?;
        }
        if let Some(fluctuation) = &routes.fluctuation {
            self.validate_fluctuation(&format!("{path}.routes.fluctuation"), measure.quantity, fluctuation)?;
        }
        Ok(())
    }

    fn validate_histogram(&self, path: &str, histogram: &DistributionInput) -> Result<(), Invalid> {
        if !(1..=MOST_BINS).contains(&histogram.bins) {
            return Err(Invalid::new(format!("{path}.bins"), histogram.bins, format!("must be from 1 to {MOST_BINS}")));
        }
        if let Some(distance) = histogram.longest_distance {
            let path = format!("{path}.longest_distance");
            number(&path, distance, Requirement::Positive)?;
            if distance > self.half_side() {
                let requirement = format!("must be at most half the shortest side of the box, {}", self.half_side());
                return Err(Invalid::new(path, written(distance), requirement));
            }
        }
        Ok(())
    }

    fn validate_derivative(&self, path: &str, steps: &[f64]) -> Result<(), Invalid> {
        if steps.is_empty() {
            return Err(Invalid::new(path, "[]", "must hold at least one number"));
        }
        for (index, &step) in steps.iter().enumerate() {
            let place = if steps.len() > 1 { format!("{path}.{index}") } else { path.to_owned() };
            if !(step > 0.0 && step < 1.0) {
                return Err(Invalid::new(place, written(step), "must be above 0 and below 1"));
            }
            if steps[..index].contains(&step) {
                return Err(Invalid::new(place, written(step), "must not be given twice"));
            }
            self.at_density(1.0 + step).validate_box().map_err(|invalid| {
                Invalid::new(place, written(step), format!("at the larger density {}", invalid.requirement))
            })?;
        }
        Ok(())
    }

    fn validate_fluctuation(&self, path: &str, quantity: Quantity, route: &FluctuationInput) -> Result<(), Invalid> {
        if self.species().len() > 1 || !self.bond.is_empty() {
            let requirement = format!(
                "needs a fluid of one species without bonds, for which S(0) = ρ kT κ_T holds: choose `derivative` for the {} of this one",
                quantity.name()
            );
            return Err(Invalid::new(path, "", requirement));
        }
        let path = format!("{path}.largest_wave_number");
        let largest = self.largest_wave_number(route);
        number(&path, largest, Requirement::Positive)?;
        let volume: f64 = self.sides().iter().product();
        // Half of the vectors in a sphere: of k and −k one counts.
        let vectors = volume * largest.powi(3) / (12.0 * PI * PI);
        if vectors > MOST_WAVE_VECTORS {
            let most = rounded((12.0 * PI * PI * MOST_WAVE_VECTORS / volume).cbrt());
            let requirement = format!(
                "leaves about {vectors:.0} wave vectors: must be at most {most}, so that {MOST_WAVE_VECTORS} are left"
            );
            return Err(Invalid::new(path, written(largest), requirement));
        }
        let region = self.region().map_err(|error| Invalid::new("system", "", error))?;
        let found = shells(&region, largest).len();
        if found < FEWEST_SHELLS {
            let requirement = format!(
                "leaves {found} lengths of wave vectors: must leave at least {FEWEST_SHELLS}, for an extrapolation to k = 0; the longest waves have k = {}",
                rounded(TAU / self.sides().into_iter().fold(0.0, f64::max))
            );
            return Err(Invalid::new(path, written(largest), requirement));
        }
        Ok(())
    }
}
