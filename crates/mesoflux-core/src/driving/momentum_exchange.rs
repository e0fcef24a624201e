//! Momentum exchange: particles of two slabs trade momentum, the shear flow between them answers (Müller-Plathe's method).
//!
//! F. Müller-Plathe, Phys. Rev. E 59, 4894 (1999); C. Nieto-Draghi & J. B. Avalos, Mol. Phys. 101, 2303 (2003) for unequal masses;
//! Naseri et al., section 3.3, for the exchange of any momentum.

use super::{DrivenStep, Driving};
use crate::forcing::{Axis, ForcingError};
use crate::integrate::Change;
use crate::state::Particles;
use crate::system::System;
use serde::{Deserialize, Serialize};

/// What two particles do to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exchange {
    /// They collide elastically along the flow, wherever they are: Δp = 2 (v₂ − v₁)/(1/m₁ + 1/m₂). Equal masses swap their
    /// velocities. Momentum and kinetic energy are conserved.
    Swap,
    /// The first one is given Δp, the second one −Δp: momentum is conserved, energy is not.
    ///
    /// A large Δp puts energy in. A small one takes thermal energy out, in the slabs: it slows the fastest particles down. The thermostat
    /// makes up for it.
    Forced {
        /// Δp > 0.
        momentum: f64,
    },
}

/// The two slabs, and the fluid between them.
///
/// With x ∈ [0, L) the coordinate along the gradient, the slabs are centered at L/4 and 3L/4 (at −L/4 and +L/4 where the center of the
/// box is the origin). Momentum goes in at the first and out at the second: between them the flow is odd about L/2, and beyond them
/// about 0. One flow in two halves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slabs {
    /// The axis of the flow.
    pub flow: Axis,
    /// The axis of the gradient, another one.
    pub gradient: Axis,
    /// w: the thickness of each slab over L, below ½.
    pub width: f64,
}

impl Slabs {
    /// Where a coordinate x stands in the box of side L, from 0 to 1.
    fn share(x: f64, side: f64) -> f64 {
        let share = x / side;
        share - share.floor()
    }

    /// Which slab holds a coordinate, 0 or 1.
    pub fn slab(&self, x: f64, side: f64) -> Option<usize> {
        let share = Self::share(x, side);
        [0.25, 0.75].into_iter().position(|center| (share - center).abs() <= 0.5 * self.width)
    }

    /// How much of one of so many equal bins across the box lies in the slabs, from 0 to 1.
    pub fn share_inside(&self, bin: usize, bins: usize) -> f64 {
        let (low, high) = (bin as f64 / bins as f64, (bin + 1) as f64 / bins as f64);
        let inside = |center: f64| (high.min(center + 0.5 * self.width) - low.max(center - 0.5 * self.width)).max(0.0);
        (inside(0.25) + inside(0.75)) * bins as f64
    }

    /// x in its half of the fluid: the distance ξ ∈ [−L/4, L/4) from the center of the half, and the sign of the flow there.
    ///
    /// The flow times this sign is the same odd function of ξ in both halves, falling where that of the first slab is positive.
    pub fn folded(&self, x: f64, side: f64) -> (f64, f64) {
        let share = Self::share(x, side);
        if (0.25..0.75).contains(&share) {
            return ((share - 0.5) * side, 1.0);
        }
        let beyond = if share < 0.25 { share } else { share - 1.0 };
        (beyond * side, -1.0)
    }

    /// The steady flow at x of a Newtonian fluid whose velocity falls by `gradient` in the fluid between the slabs, momentum going in
    /// and out evenly over their thickness: straight between them, a parabola in each.
    pub fn steady_flow(&self, x: f64, side: f64, gradient: f64) -> f64 {
        let (along, sign) = self.folded(x, side);
        let half_slab = 0.5 * self.width * side;
        // From the edge of the slab on the slope falls linearly to zero at its center.
        let inside = (along.abs() - (0.25 * side - half_slab)).max(0.0);
        let depth = if inside > 0.0 { inside * inside / (2.0 * half_slab) } else { 0.0 };
        -sign * gradient * (along.abs() - depth) * along.signum()
    }
}

/// What the exchanges of one step brought.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Exchanged {
    /// Momentum carried from the second slab to the first.
    pub momentum: f64,
    /// The change of the kinetic energy by that.
    pub work: f64,
    /// The kinetic energy that the thermostat took in the step; of integrators without letters nobody can tell.
    pub heat: Option<f64>,
}

/// At the end of every so many steps, the particle of the smallest velocity in the first slab and that of the largest in the second
/// exchange momentum along the flow.
///
/// The fluid carries Δp back through two cross sections of the area A, so after exchanges of Σ Δp in the time t the stress is
/// Π = Σ Δp/(2 A t) (Naseri et al., eq. 55). Of particles as fast as each other the one with the smaller id is taken. Where a slab is
/// empty, or a swap would carry momentum the wrong way, nothing is exchanged.
///
/// It acts on momenta between steps, so it works with every integrator. Velocity Verlet has by then worked out the forces of
/// the next step's first kick with the velocities before the exchange: no more than its forces always lag behind its velocities.
#[derive(Debug)]
pub struct MomentumExchange {
    slabs: Slabs,
    exchange: Exchange,
    interval: u64,
    /// How steep the flow is at the start.
    start_gradient: f64,
    /// The kinetic energy before the thermostat under way.
    before: f64,
    /// What thermostats have taken since the beginning of the step.
    heat: Option<f64>,
    exchanged: Exchanged,
}

impl MomentumExchange {
    /// Exchanges every `interval` steps, at least one, of a fluid that starts with the steady flow of a gradient.
    pub fn new(slabs: Slabs, exchange: Exchange, interval: u64, start_gradient: f64) -> Self {
        let interval = interval.max(1);
        Self { slabs, exchange, interval, start_gradient, before: 0.0, heat: None, exchanged: Exchanged::default() }
    }

    /// The particles that are to exchange: their places in storage.
    fn partners(&self, system: &System) -> Option<[usize; 2]> {
        let particles = &system.particles;
        let (flow, gradient) = (self.slabs.flow as usize, self.slabs.gradient as usize);
        let side = system.region.sides()[gradient];
        let extreme = |slab: usize, sign: f64| {
            system.workers.least(particles.count(), |k| {
                let inside = self.slabs.slab(particles.position[k][gradient], side) == Some(slab);
                inside.then(|| (sign * particles.momentum[k][flow] * particles.inverse_mass[k], particles.id[k], k))
            })
        };
        Some([extreme(0, 1.0)?.2, extreme(1, -1.0)?.2])
    }

    fn exchange(&self, system: &mut System) -> Exchanged {
        let Some([first, second]) = self.partners(system) else { return Exchanged::default() };
        let flow = self.slabs.flow as usize;
        let Particles { momentum: momenta, inverse_mass, .. } = &mut system.particles;
        let [a, b] = [first, second].map(|k| momenta[k][flow] * inverse_mass[k]);
        let total = inverse_mass[first] + inverse_mass[second];
        let momentum = match self.exchange {
            Exchange::Swap => (2.0 * (b - a) / total).max(0.0),
            Exchange::Forced { momentum } => momentum,
        };
        momenta[first][flow] += momentum;
        momenta[second][flow] -= momentum;
        // (p + Δp)² − p² over 2m, of both.
        let work = momentum * (a - b + 0.5 * momentum * total);
        Exchanged { momentum, work, heat: None }
    }
}

/// Letters that trade kinetic for potential energy, or for nothing; every other one is a thermostat.
fn is_mechanical(symbol: char) -> bool {
    matches!(symbol, 'A' | 'B')
}

impl Driving for MomentumExchange {
    /// Adds the flow of the start to the momenta, and takes the velocity of its center of mass away.
    fn begin(&mut self, system: &mut System) -> Result<(), ForcingError> {
        let Slabs { flow, gradient, .. } = self.slabs;
        if flow == gradient {
            return Err(ForcingError::FlowAlongGradient);
        }
        if self.start_gradient == 0.0 {
            return Ok(());
        }
        let side = system.region.sides()[gradient as usize];
        let velocity = |particles: &Particles, k: usize| {
            self.slabs.steady_flow(particles.position[k][gradient as usize], side, self.start_gradient)
        };
        let (workers, particles) = (system.workers, &mut system.particles);
        let total = workers.sum(particles.count(), |k| velocity(particles, k) / particles.inverse_mass[k]);
        let drift = total / particles.total_mass(workers);
        for k in 0..particles.count() {
            let added = (velocity(particles, k) - drift) / particles.inverse_mass[k];
            particles.momentum[k][flow as usize] += added;
        }
        Ok(())
    }

    fn needs_word(&self) -> bool {
        false
    }

    fn before_letter(&mut self, system: &mut System, symbol: char, _time: f64) {
        if !is_mechanical(symbol) {
            self.before = 0.5 * system.particles.twice_kinetic_energy(system.workers);
        }
    }

    fn after_letter(&mut self, system: &mut System, symbol: char, _time: f64, _change: Change) {
        let heat = self.heat.get_or_insert_default();
        if !is_mechanical(symbol) {
            *heat += self.before - 0.5 * system.particles.twice_kinetic_energy(system.workers);
        }
    }

    fn end_step(&mut self, system: &mut System, _time_step: f64) -> Option<DrivenStep> {
        let due = system.step.is_multiple_of(self.interval);
        self.exchanged = if due { self.exchange(system) } else { Exchanged::default() };
        self.exchanged.heat = self.heat.take();
        None
    }

    fn exchanged(&self) -> Option<Exchanged> {
        Some(self.exchanged)
    }
}

/// The shear viscosity that a fluid without correlations between its particles would have: Σ_ab over the species of
///
/// (2π/15) ρ_a ρ_b ∫₀^∞ r⁴ Γ_ab(r) dr by friction, and Σ_a ½ m_a ρ_a D_a by the flight of particles, D_a = 3 kT/(4π Σ_b ρ_b ∫ r² Γ_ab dr)
///
/// (Groot & Warren 1997; Marsh, Backx & Ernst 1997). A guess for the start of a run: it knows nothing of potentials, and where
/// friction is strong it is too large. `None` without any friction.
pub fn mean_field_viscosity(system: &System, temperature: f64) -> Option<f64> {
    const POINTS: u32 = 200;
    let particles = &system.particles;
    let volume = system.region.volume();
    // Number density and mass density of each species.
    let mut densities = [[0.0; 2]; 256];
    for (&species, &inverse_mass) in particles.species.iter().zip(&particles.inverse_mass) {
        let [number, mass] = &mut densities[usize::from(species)];
        *number += 1.0 / volume;
        *mass += 1.0 / (inverse_mass * volume);
    }
    let density = |species: u8| densities[usize::from(species)][0];
    let species: Vec<u8> = (0..=u8::MAX).filter(|&species| density(species) > 0.0).collect();
    let frictions = &system.interactions.frictions;
    let moment = |a: u8, b: u8, power: i32| {
        frictions.get(a, b).as_ref().map_or(0.0, |friction| {
            let width = friction.cutoff() / f64::from(POINTS);
            let at = |k: u32| width * (f64::from(k) + 0.5);
            (0..POINTS).map(|k| width * at(k).powi(power) * friction.at_rest(at(k))).sum()
        })
    };
    let mut viscosity = 0.0;
    for &a in &species {
        let over_others = |power: i32| -> f64 { species.iter().map(|&b| density(b) * moment(a, b, power)).sum() };
        let drag = 4.0 / 3.0 * std::f64::consts::PI * over_others(2);
        if !(drag > 0.0) {
            return None;
        }
        let flight = 0.5 * densities[usize::from(a)][1] * temperature / drag;
        viscosity += 2.0 * std::f64::consts::PI / 15.0 * density(a) * over_others(4) + flight;
    }
    Some(viscosity)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slabs() -> Slabs {
        Slabs { flow: Axis::Z, gradient: Axis::X, width: 0.1 }
    }

    #[test]
    fn slabs_stand_a_quarter_off_the_center_and_are_as_thick_as_told() {
        // With the center of the box as origin: |x ± L/4| ≤ L/20.
        let side = 8.0;
        for k in -4000..12_000 {
            let x = f64::from(k) * 0.002 + 0.0007;
            let centered = (x - 0.5 * side) - ((x - 0.5 * side) / side).round() * side;
            let expected = if (centered + 0.25 * side).abs() <= 0.05 * side {
                Some(0)
            } else if (centered - 0.25 * side).abs() <= 0.05 * side {
                Some(1)
            } else {
                None
            };
            assert_eq!(slabs().slab(x, side), expected, "{x}");
        }
    }

    #[test]
    fn bins_know_their_share_of_the_slabs() {
        // Of eight bins the slabs, from 0.2 to 0.3 and from 0.7 to 0.8, touch two each.
        let shares: Vec<f64> = (0..8).map(|bin| slabs().share_inside(bin, 8)).collect();
        for (share, expected) in shares.iter().zip([0.0, 0.4, 0.4, 0.0, 0.0, 0.4, 0.4, 0.0]) {
            assert!((share - expected).abs() < 1e-12, "{shares:?}");
        }
        assert!((slabs().share_inside(12, 50) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn both_halves_are_one_flow() {
        let side = 8.0;
        for x in [0.3, 1.5, 2.3, 3.1, 4.7, 5.9, 6.4, 7.7, -0.8, 9.1] {
            let flow = |x: f64| slabs().steady_flow(x, side, 0.7);
            // Odd about the center, of the opposite sign half a box away, and smooth.
            assert!((flow(side - x) + flow(x)).abs() < 1e-12);
            assert!((flow(x + 0.5 * side) + flow(x)).abs() < 1e-12);
            assert!((flow(x + 1e-7) - flow(x - 1e-7)).abs() < 0.7 * 2.1e-7);
            let (along, sign) = slabs().folded(x, side);
            if along.abs() < 0.2 * side {
                assert!((sign * flow(x) + 0.7 * along).abs() < 1e-12, "{x}");
            }
        }
        // It goes where the first slab is pushed, and is 0.7 (0.2 L + ¼ of 0.1 L) there.
        assert!((slabs().steady_flow(2.0, side, 0.7) - 0.7 * 0.225 * side).abs() < 1e-12);
    }
}
