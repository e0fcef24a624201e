//! Forces along one axis that change along another: what all shear forcings have in common (Wu & Shang, section 4.2.2).

use super::{Forcing, ForcingError};
use crate::elementary::{sine_ahead, wrapped};
use crate::state::Particles;
use crate::vector::{Vector, ZERO};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// An axis of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// The directions of a shear flow, and its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wave {
    /// The axis along which the force pushes.
    pub flow: Axis,
    /// The axis along which the force changes; another one.
    pub gradient: Axis,
    /// How many waves fit into the box.
    pub waves: u32,
}

impl Wave {
    /// k = 2πn/L for a box with these sides.
    pub fn wavenumber(&self, sides: Vector) -> f64 {
        TAU * f64::from(self.waves) / sides[self.gradient as usize]
    }
}

/// The shape of a shear force over one wave, and how the response to it is read.
pub trait ShearProfile: std::fmt::Debug + Send + Sync {
    /// F at a phase of 0 to 1 in the wave.
    fn force(phase: f64) -> f64;
    /// |F₁| of eq. 88, F₁ = ∫₀¹ F(φ) exp(2πiφ) dφ.
    const FIRST_COEFFICIENT: f64;
    /// The response is taken along sin(2πφ + this · π/2), so that R = U₁F₁*/|F₁| has the sign of the forcing's magnitude.
    const QUARTERS: u64;
}

/// F_i = F(φ_i) along the flow, where φ = ny/L is the phase of the particle along the gradient; R = U₁F₁*/|F₁| with
/// U₁ = (1/N)Σ v_x exp(2πiφ) (eq. 89).
///
/// The paper takes the imaginary part of U₁ where F₁ is imaginary and the real one where it is real; ours is the same but for
/// the sign of the piecewise linear force, whose F₁ = −4/π² is negative.
#[derive(Debug, Clone, Copy)]
pub struct Shear<P> {
    flow: usize,
    gradient: usize,
    waves_per_length: f64,
    per_particle: f64,
    profile: std::marker::PhantomData<fn() -> P>,
}

impl<P: ShearProfile> Shear<P> {
    /// The forcing of a wave in a box with these sides, which holds so many particles.
    pub fn new(wave: Wave, sides: Vector, particles: usize) -> Self {
        let gradient = wave.gradient as usize;
        Self {
            flow: wave.flow as usize,
            gradient,
            waves_per_length: f64::from(wave.waves) / sides[gradient],
            per_particle: 1.0 / particles as f64,
            profile: std::marker::PhantomData,
        }
    }

    fn phase(&self, particles: &Particles, k: usize) -> f64 {
        wrapped(particles.position[k][self.gradient] * self.waves_per_length, 1.0)
    }
}

impl<P: ShearProfile> Forcing for Shear<P> {
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2] {
        let phase = self.phase(particles, k);
        let (mut force, mut response) = (ZERO, ZERO);
        force[self.flow] = P::force(phase);
        response[self.flow] = self.per_particle * particles.inverse_mass[k] * sine_ahead(TAU * phase, P::QUARTERS);
        [force, response]
    }

    fn depends_on_positions(&self) -> bool {
        true
    }

    fn is_balanced(&self) -> bool {
        false
    }

    fn response_drift(&self, particles: &Particles, k: usize) -> f64 {
        let velocity = particles.velocity(k);
        let slope = TAU * self.waves_per_length * sine_ahead(TAU * self.phase(particles, k), P::QUARTERS + 1);
        self.per_particle * slope * velocity[self.gradient] * velocity[self.flow]
    }

    fn check(&self, particles: usize) -> Result<(), ForcingError> {
        if self.flow == self.gradient {
            return Err(ForcingError::FlowAlongGradient);
        }
        if !(self.waves_per_length > 0.0) {
            return Err(ForcingError::NoWave);
        }
        if particles < 2 {
            return Err(ForcingError::TooFewParticles { needed: 2, found: particles });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PiecewiseConstant, PiecewiseLinear, Sinusoidal};
    use super::*;

    /// The integral of F(φ) times the function by which the response is read, by the midpoint rule.
    fn projected<P: ShearProfile>(ahead: u64) -> f64 {
        let points = 40_000;
        let at = |k: u32| {
            let phase = (f64::from(k) + 0.5) / f64::from(points);
            P::force(phase) * sine_ahead(TAU * phase, P::QUARTERS + ahead) / f64::from(points)
        };
        (0..points).map(at).sum()
    }

    #[test]
    fn first_coefficients_are_those_of_the_forces() {
        fn check<P: ShearProfile>(expected: f64) {
            assert!((P::FIRST_COEFFICIENT - expected).abs() < 1e-15);
            assert!((projected::<P>(0) - expected).abs() < 1e-8);
            // The other part of F₁ vanishes.
            assert!(projected::<P>(1).abs() < 1e-8);
        }
        use std::f64::consts::PI;
        check::<Sinusoidal>(0.5);
        check::<PiecewiseLinear>(4.0 / (PI * PI));
        check::<PiecewiseConstant>(2.0 / PI);
    }

    #[test]
    fn forces_are_those_of_the_paper() {
        // At y = 0, L/4, 3L/8, L/2, 3L/4.
        let phases = [0.0, 0.25, 0.375, 0.5, 0.75];
        assert_eq!(phases.map(PiecewiseLinear::force), [-1.0, 0.0, 0.5, 1.0, 0.0]);
        assert_eq!(phases.map(PiecewiseConstant::force), [1.0, 1.0, 1.0, 1.0, -1.0]);
        for (phase, expected) in phases.into_iter().zip([0.0, 1.0, 0.5f64.sqrt(), 0.0, -1.0]) {
            assert!((Sinusoidal::force(phase) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn response_drift_is_the_rate_at_which_free_flight_changes_the_flux() {
        let sides = [5.0, 4.0, 7.0];
        let wave = Wave { flow: Axis::Z, gradient: Axis::X, waves: 3 };
        let mut particles =
            Particles::at_rest(vec![[0.3, 1.0, 2.0], [4.9, 3.0, 6.5], [2.2, 0.1, 3.0]], vec![0, 1, 0], &[1.0, 2.5]);
        particles.momentum = vec![[0.7, -0.2, 1.3], [-1.9, 0.4, 0.8], [0.5, 0.6, -2.0]];
        let forcing = Shear::<PiecewiseLinear>::new(wave, sides, 3);
        let flux = |time: f64| {
            let mut moved = particles.clone();
            for k in 0..3 {
                let velocity = moved.velocity(k);
                (0..3).for_each(|axis| moved.position[k][axis] += time * velocity[axis]);
            }
            (0..3).map(|k| crate::vector::dot(forcing.at(&moved, k)[1], moved.momentum[k])).sum::<f64>()
        };
        let slope = (flux(1e-5) - flux(-1e-5)) / 2e-5;
        let drift: f64 = (0..3).map(|k| forcing.response_drift(&particles, k)).sum();
        assert!((slope - drift).abs() < 1e-8, "{slope} and {drift}");
        // By hand: G = −cos(kx)/(Nm) e_z.
        let k = TAU * 3.0 / 5.0;
        let by_hand: f64 = (0..3)
            .map(|i| {
                k * (k * particles.position[i][0]).sin() * particles.velocity(i)[0] * particles.velocity(i)[2] / 3.0
            })
            .sum();
        assert!((by_hand - drift).abs() < 1e-12);
    }
}
