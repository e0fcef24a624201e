//! The profile of a shear flow: density, velocity, temperature and stress in layers across the box, and the balance of momentum.

use super::{Way, cells};
use crate::route::{Outcome, RouteError};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::forcing::{ForcingChoice, ForcingField};
use mesoflux_core::integrate::Thermostat;
use mesoflux_core::observable::StressProfile;
use mesoflux_core::system::System;
use mesoflux_core::vector::dot;
use mesoflux_io::input::Input;
use mesoflux_io::results::Table;

/// The chance with which a sound run is blamed for its balance of momentum.
const FALSE_ALARM: f64 = 1e-3;

/// What is recorded of one layer, each over the layer's volume.
const NUMBERS: usize = 7;
/// Σ 1 over the particles in the layer.
const COUNT: usize = 0;
/// Σ m.
const MASS: usize = 1;
/// Σ p along the flow.
const MOMENTUM: usize = 2;
/// Σ p²/m.
const ENERGY: usize = 3;
/// σ_xy averaged over the layer, its kinetic, conservative and dissipative parts.
const STRESS: usize = 4;
/// The stress in the next layer less that in this one, over the thickness.
const GRADIENT: usize = 5;
/// Σ ηF w, with w one at the upper face, falling linearly to zero over the two layers at its sides.
const FORCE: usize = 6;

/// Reads the layers of a flow.
///
/// With x the axis of the flow and y that of the gradient, the momentum Σ p_x w(y) near a face changes by what the two layers at its
/// sides carry and by the force, so in a steady state (Σ_i over everybody, w the hat function of the face, A its area)
///
/// A (⟨σ_xy⟩ of the upper layer − ⟨σ_xy⟩ of the lower one) = ⟨Σ_i ηF_i w(y_i)⟩:
///
/// Wu & Shang's eq. 84, ∂σ_xy/∂Y = ρF, integrated over layers of any thickness without an error. The random stress is left out: its mean
/// is zero. The momenta count as they are: as nothing flows across the layers, ⟨Σ p_y⟩ = 0, the velocity of the flow is not part of σ_xy.
#[derive(Debug)]
pub(super) struct FlowReader {
    pub flow: usize,
    pub gradient: usize,
    pub layers: usize,
    pub field: ForcingField,
}

impl FlowReader {
    pub(super) fn new(input: &Input, choice: &ForcingChoice, layers: usize) -> Option<Self> {
        // The input was found right, its forcing with it.
        let field = choice.field(input.particles() as usize, input.sides()).ok()?;
        Some(Self { flow: choice.wave.flow as usize, gradient: choice.wave.gradient as usize, layers, field })
    }

    /// A series for each layer.
    pub(super) fn series(&self) -> Result<Vec<Blocking>, RouteError> {
        Ok((0..self.layers).map(|_| Blocking::new(NUMBERS)).collect::<Result<_, _>>()?)
    }

    /// The layers of a state that is driven by `forcing` times F.
    pub(super) fn read(&mut self, system: &mut System, forcing: f64) -> Vec<[f64; NUMBERS]> {
        let (count, sides) = (self.layers, system.region.sides());
        let thickness = sides[self.gradient] / count as f64;
        let per_volume = count as f64 / sides.iter().product::<f64>();
        let mut layers = vec![[0.0; NUMBERS]; count];
        for (layer, stress) in layers.iter_mut().zip(StressProfile::of(system, self.gradient, count).layers) {
            layer[STRESS] = stress.forward().component(self.flow, self.gradient);
        }
        self.field.update(&system.particles, system.layout(), true, system.workers);
        let particles = &system.particles;
        for k in 0..particles.count() {
            let place = (particles.position[k][self.gradient] / thickness).rem_euclid(count as f64);
            let index = (place as usize).min(count - 1);
            let (momentum, above) = (particles.momentum[k], place - index as f64);
            let layer = &mut layers[index];
            layer[COUNT] += 1.0;
            layer[MASS] += 1.0 / particles.inverse_mass[k];
            layer[MOMENTUM] += momentum[self.flow];
            layer[ENERGY] += particles.inverse_mass[k] * dot(momentum, momentum);
            let force = forcing * self.field.force[k][self.flow];
            layer[FORCE] += above * force;
            layers[(index + count - 1) % count][FORCE] += (1.0 - above) * force;
        }
        layers.as_flattened_mut().iter_mut().for_each(|number| *number *= per_volume);
        for index in 0..count {
            layers[index][GRADIENT] = (layers[(index + 1) % count][STRESS] - layers[index][STRESS]) / thickness;
        }
        layers
    }
}

/// kT = ⟨Σ |p − m u|²/m⟩/(3⟨n⟩) of the particles of a layer, relative to its mean velocity u = ⟨Σ p⟩/⟨Σ m⟩ over the whole run.
///
/// Nothing is lost to the velocity of the few particles that are there at an instant, whose fluctuations are thermal. The
/// total momentum is fixed: a particle has 3(1 − m/M) degrees of freedom.
fn temperature(layer: &Blocking, total_mass: f64) -> Estimate {
    let degrees = |mean: &[f64]| 3.0 * (mean[COUNT] - mean[MASS] / total_mass);
    let value = |mean: &[f64]| (mean[ENERGY] - mean[MOMENTUM].powi(2) / mean[MASS]) / degrees(mean);
    layer.function(value, |mean| {
        let (velocity, degrees, temperature) = (mean[MOMENTUM] / mean[MASS], degrees(mean), value(mean));
        let mut gradient = vec![0.0; NUMBERS];
        gradient[ENERGY] = 1.0 / degrees;
        gradient[MOMENTUM] = -2.0 * velocity / degrees;
        gradient[MASS] = (velocity * velocity + 3.0 * temperature / total_mass) / degrees;
        gradient[COUNT] = -3.0 * temperature / degrees;
        gradient
    })
}

/// Adds the profile of every strength to an outcome, and how well momentum is balanced.
pub(super) fn report<W: Way>(
    outcome: &mut Outcome,
    input: &Input,
    gradient: usize,
    strengths: &[f64],
    profiles: &[&[Blocking]],
) {
    let (sides, layers) = (input.sides(), profiles.first().map_or(0, |layers| layers.len()));
    let thickness = sides[gradient] / layers as f64;
    let masses = input.masses().into_iter().zip(input.species_counts());
    // A bath takes momentum from every particle: its sum isn't fixed, and stress and force alone are in no balance.
    let bath = matches!(input.dynamics.thermostat, Thermostat::Langevin(_));
    let total_mass = if bath { f64::INFINITY } else { masses.map(|(mass, count)| mass * count as f64).sum() };
    let faces = (strengths.len() * layers) as f64;
    let mut rows = Vec::new();
    let (mut worst, mut violated) = (0.0f64, false);
    for (&strength, profile) in strengths.iter().zip(profiles) {
        for (index, layer) in profile.iter().enumerate() {
            let mut difference = [0.0; NUMBERS];
            (difference[GRADIENT], difference[FORCE]) = (1.0, -1.0);
            let difference = layer.linear(&difference);
            worst = worst.max(difference.z_score_against(0.0, 0.0).map_or(0.0, f64::abs));
            let interval = difference.interval(1.0 - FALSE_ALARM / faces);
            violated |= interval.is_some_and(|(low, high)| low > 0.0 || high < 0.0);
            let mut row = vec![strength, (index as f64 + 0.5) * thickness];
            row.extend(cells(&layer.component(COUNT)));
            row.extend(cells(&layer.ratio(MOMENTUM, MASS)));
            row.extend(cells(&temperature(layer, total_mass)));
            row.extend(cells(&layer.component(STRESS)));
            row.push((index as f64 + 1.0) * thickness);
            row.extend(cells(&layer.component(GRADIENT)));
            row.extend(cells(&layer.component(FORCE)));
            rows.push(row);
        }
    }
    if !bath {
        outcome.conditions.insert("momentum_balance_z".to_owned(), worst.into());
    }
    if violated && !bath {
        let warning = format!(
            "the gradient of the stress is not the density of the force, z = {worst:.1}: the time step is too long, or the state \
             not steady"
        );
        outcome.estimate.warnings.push(warning);
    }
    let axis = ["x", "y", "z"][gradient];
    let header = [
        W::IMPOSED.header(),
        format!("{axis} [l]"),
        "density [1/l^3]".to_owned(),
        "standard_error [1/l^3]".to_owned(),
        "velocity [v]".to_owned(),
        "standard_error [v]".to_owned(),
        "temperature [e]".to_owned(),
        "standard_error [e]".to_owned(),
        "stress [e/l^3]".to_owned(),
        "standard_error [e/l^3]".to_owned(),
        format!("upper_{axis} [l]"),
        "stress_gradient [e/l^4]".to_owned(),
        "standard_error [e/l^4]".to_owned(),
        "force_density [e/l^4]".to_owned(),
        "standard_error [e/l^4]".to_owned(),
    ];
    outcome.tables.push(("profile", Table::new(header, rows)));
}
