//! One variable x with a free energy and a kinetic coefficient that depends on x: Langevin's equation in explicit steps.
//!
//! The balance asks for dx = (αX + kT ∂α/∂x) dt + √(2kTα) dW (in the sense of Itô), X = −∂F/∂x, so that e^(−F/kT) is stationary.
//! It is the balance of a pair's relative velocity: α stands for the friction and the inverse reduced mass is one.

use crate::friction::fluctuation_dissipation::{Correction, correction, predicted, random_force};
use crate::noise::{NoiseKey, Purpose};

/// x moves as it is; there is no mass to divide by.
const UNIT: f64 = 1.0;

/// The laws of one variable x.
///
/// ```
/// use mesoflux_core::friction::fluctuation_dissipation::Correction;
/// use mesoflux_core::noise::NoiseKey;
/// use mesoflux_core::scalar_langevin::{ScalarLangevin, Variable};
///
/// /// F = ½x², α = 1 + x².
/// struct Spring;
///
/// impl Variable for Spring {
///     fn force(&self, x: f64) -> f64 {
///         -x
///     }
///     fn coefficient(&self, x: f64) -> f64 {
///         1.0 + x * x
///     }
///     fn slope(&self, x: f64) -> f64 {
///         2.0 * x
///     }
/// }
///
/// let dynamics = ScalarLangevin::new(Spring, 1.0, 0.01, Correction::TwoStep)?;
/// let mut copies = [0.0; 100];
/// for step in 0..1000 {
///     dynamics.advance(&mut copies, NoiseKey::new(&[1]), step)?;
/// }
/// # Ok::<(), mesoflux_core::scalar_langevin::ScalarLangevinError>(())
/// ```
pub trait Variable {
    /// X(x) = −∂F/∂x.
    fn force(&self, x: f64) -> f64;

    /// α(x), nowhere negative.
    fn coefficient(&self, x: f64) -> f64;

    /// ∂α/∂x; asked for by [`Correction::Derivative`] alone.
    fn slope(&self, x: f64) -> f64;
}

/// Dynamics that can't be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ScalarLangevinError {
    /// Not a usable parameter.
    #[error("the {name} is {value}: must be positive and finite")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// No noise belongs to such a coefficient.
    #[error("the kinetic coefficient at x = {x} is {value}: must be at least 0 and finite")]
    Coefficient {
        /// Where.
        x: f64,
        /// What it is.
        value: f64,
    },
    /// x left the numbers.
    #[error("a step from x = {x} leads to {after}. Likely cause: the time step is too large for the force there")]
    Escaped {
        /// Where the step began.
        x: f64,
        /// Where it led.
        after: f64,
    },
}

/// Explicit steps of one variable: x' = x + αXδt + δx^R (Naseri et al., eqs 45–52; the sign of eq. 45 is wrong in the paper).
///
/// With ξ a normal number, the noise is
/// - by the derivative, δx^R = Γξ√δt + Λξ²δt, Γ² = 2kTα, Λ = kT ∂α/∂x (eqs 48, 49);
/// - by two steps, δx^R = Γ(x″)ξ√δt with x″ = x + Γ(x)ξ√δt and the same ξ (eqs 50, 51, where it is missing).
///
/// Averages are right up to a term of first order in δt, for both.
#[derive(Debug, Clone, Copy)]
pub struct ScalarLangevin<V> {
    variable: V,
    temperature: f64,
    time_step: f64,
    correction: Correction,
}

impl<V: Variable> ScalarLangevin<V> {
    /// The dynamics of a variable at kT, by steps δt.
    ///
    /// # Errors
    /// A temperature or a time step that isn't positive.
    pub fn new(
        variable: V,
        temperature: f64,
        time_step: f64,
        correction: Correction,
    ) -> Result<Self, ScalarLangevinError> {
        for (name, value) in [("temperature", temperature), ("time step", time_step)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ScalarLangevinError::Parameter { name, value });
            }
        }
        Ok(Self { variable, temperature, time_step, correction })
    }

    /// x' from x and a normal number ξ.
    ///
    /// # Errors
    /// A kinetic coefficient that is negative, at x or at x″; an x' that is no number.
    pub fn step(&self, x: f64, normal: f64) -> Result<f64, ScalarLangevinError> {
        let coefficient = self.coefficient(x)?;
        let first = random_force(coefficient, self.temperature, self.time_step) * normal;
        let random = match self.correction {
            Correction::Derivative => {
                first + correction(self.variable.slope(x), UNIT, self.temperature) * (normal * normal)
            }
            Correction::TwoStep => {
                let coefficient = self.coefficient(predicted(x, first, UNIT, self.time_step))?;
                random_force(coefficient, self.temperature, self.time_step) * normal
            }
        };
        let after = x + self.time_step * (coefficient * self.variable.force(x) + random);
        if after.is_finite() { Ok(after) } else { Err(ScalarLangevinError::Escaped { x, after }) }
    }

    /// One step of many independent copies of x; copy k draws the noise of particle k at this step.
    ///
    /// # Errors
    /// As for [`Self::step`]; the copies up to the one that failed have then moved.
    pub fn advance(&self, copies: &mut [f64], noise: NoiseKey, step: u64) -> Result<(), ScalarLangevinError> {
        let draw = noise.draw(Purpose::Particle, step, 0);
        for (k, x) in copies.iter_mut().enumerate() {
            *x = self.step(*x, draw.gaussian(k as u64, 0))?;
        }
        Ok(())
    }

    /// α(x), checked.
    fn coefficient(&self, x: f64) -> Result<f64, ScalarLangevinError> {
        let value = self.variable.coefficient(x);
        if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(ScalarLangevinError::Coefficient { x, value }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F = 2x, α = 1 + x².
    #[derive(Debug)]
    struct Slope;

    impl Variable for Slope {
        fn force(&self, _: f64) -> f64 {
            -2.0
        }

        fn coefficient(&self, x: f64) -> f64 {
            1.0 + x * x
        }

        fn slope(&self, x: f64) -> f64 {
            2.0 * x
        }
    }

    fn dynamics(time_step: f64, correction: Correction) -> ScalarLangevin<Slope> {
        ScalarLangevin::new(Slope, 0.5, time_step, correction).unwrap()
    }

    /// x = 2, α = 5, kT = ½: Γ = √5, Λ = 2; δt = 0.04, ξ = 1.5.
    #[test]
    fn a_step_is_the_one_of_the_equations() {
        let by_derivative = dynamics(0.04, Correction::Derivative).step(2.0, 1.5).unwrap();
        let expected = 2.0 - 5.0 * 2.0 * 0.04 + 5f64.sqrt() * 1.5 * 0.2 + 2.0 * 2.25 * 0.04;
        assert!((by_derivative - expected).abs() < 1e-14);
        let by_two_steps = dynamics(0.04, Correction::TwoStep).step(2.0, 1.5).unwrap();
        let middle = 2.0 + 5f64.sqrt() * 1.5 * 0.2;
        let expected = 2.0 - 5.0 * 2.0 * 0.04 + (1.0 + middle * middle).sqrt() * 1.5 * 0.2;
        assert!((by_two_steps - expected).abs() < 1e-14);
    }

    /// Eq. 51: for the same ξ the two ways differ by a term of order δt^(3/2).
    #[test]
    fn both_ways_agree_up_to_the_order_of_the_paper() {
        for normal in [-1.7, -0.4, 0.9, 2.2] {
            let difference = |time_step: f64| {
                let step = |correction| dynamics(time_step, correction).step(0.8, normal).unwrap();
                (step(Correction::TwoStep) - step(Correction::Derivative)).abs()
            };
            let order = (difference(1e-5) / difference(1e-6)).log10();
            assert!((order - 1.5).abs() < 0.02, "order {order} for ξ = {normal}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_value() {
        #[derive(Debug)]
        struct Negative;
        impl Variable for Negative {
            fn force(&self, _: f64) -> f64 {
                0.0
            }
            fn coefficient(&self, x: f64) -> f64 {
                x
            }
            fn slope(&self, _: f64) -> f64 {
                1.0
            }
        }
        let cold = ScalarLangevin::new(Negative, 0.0, 0.1, Correction::TwoStep).unwrap_err();
        assert_eq!(cold.to_string(), "the temperature is 0: must be positive and finite");
        assert!(ScalarLangevin::new(Negative, 1.0, f64::NAN, Correction::TwoStep).is_err());
        let two_step = ScalarLangevin::new(Negative, 1.0, 1.0, Correction::TwoStep).unwrap();
        let error = two_step.step(-0.5, 0.0).unwrap_err();
        assert_eq!(error.to_string(), "the kinetic coefficient at x = -0.5 is -0.5: must be at least 0 and finite");
        let error = two_step.step(0.5, -2.0).unwrap_err();
        assert_eq!(error, ScalarLangevinError::Coefficient { x: -1.5, value: -1.5 }, "where the first step leads");
        let far = ScalarLangevin::new(Slope, 1.0, 1.0, Correction::TwoStep).unwrap();
        assert!(matches!(far.step(1e200, 0.0), Err(ScalarLangevinError::Coefficient { .. })));
    }

    #[test]
    fn noise_follows_from_key_step_and_copy() {
        let dynamics = dynamics(0.01, Correction::TwoStep);
        let run = |seed: u64, step: u64| {
            let mut copies = [0.3; 3];
            dynamics.advance(&mut copies, NoiseKey::new(&[seed]), step).unwrap();
            copies
        };
        let here = run(1, 5);
        assert_eq!(here, run(1, 5));
        assert!(here[0] != here[1] && here[0] != run(1, 6)[0] && here[0] != run(2, 5)[0]);
    }
}
