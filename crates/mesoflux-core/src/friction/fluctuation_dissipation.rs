//! The one owner of the balance between friction and noise.
//!
//! Users give a friction and a temperature; what noise belongs to them is derived here and nowhere else.
//!
//! For a pair with friction strength Γ = γ ω(r) and reduced mass μ = m_i m_j/(m_i + m_j) the relative velocity along the line
//! of centers, u = e·v_ij, obeys the Ornstein–Uhlenbeck equation du = −(Γ/μ) u dt + √(2 Γ kT)/μ dW (Wu & Shang, eqs 1, 4, 27).

use crate::elementary::exp_minus_one;
use crate::lanes::Real;

/// The exact solution over a time: u → u + `decay`·u + a normal deviate of the given variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrnsteinUhlenbeck<R> {
    /// e^(−Γt/μ) − 1.
    pub decay: R,
    /// (kT/μ)(1 − e^(−2Γt/μ)).
    pub variance: R,
}

/// The exact pair update over `time` (Wu & Shang, eq. 29), leaving the variance kT/μ of u invariant at any time step.
///
/// With d = e^(−Γt/μ) − 1 the noise needs 1 − (1 + d)² = −d(2 + d): one exponential, and balance to the last bit.
#[inline(always)]
pub fn ornstein_uhlenbeck<R: Real>(
    strength: R,
    inverse_reduced_mass: R,
    temperature: f64,
    time: f64,
) -> OrnsteinUhlenbeck<R> {
    let decay = exp_minus_one(strength * inverse_reduced_mass * R::splat(-time));
    let lost = -decay * (R::splat(2.0) + decay);
    OrnsteinUhlenbeck { decay, variance: R::splat(temperature) * inverse_reduced_mass * lost }
}

/// The variance of the random force over one step of an explicit scheme, 2 Γ kT / Δt (Wu & Shang, eq. 4).
#[inline(always)]
pub fn random_force_variance<R: Real>(strength: R, temperature: f64, time_step: f64) -> R {
    strength * R::splat(2.0 * temperature / time_step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_is_invariant_for_every_time_step_and_noise_vanishes_with_friction() {
        for strength in [0.0, 1e-8, 0.3, 40.5, 1e6] {
            for (inverse_reduced_mass, temperature) in [(2.0, 1.0), (0.3, 0.1)] {
                let update = ornstein_uhlenbeck(strength, inverse_reduced_mass, temperature, 0.01);
                let variance = temperature * inverse_reduced_mass;
                let after = (1.0 + update.decay).powi(2) * variance + update.variance;
                assert!((after / variance - 1.0).abs() < 1e-14, "friction {strength}");
                let expected = (-strength * inverse_reduced_mass * 0.01).exp_m1();
                assert!((update.decay - expected).abs() <= 1e-15);
            }
        }
    }

    #[test]
    fn short_times_give_the_force_of_the_explicit_scheme() {
        // Over a short time the variance of the impulse, μ²·variance, tends to 2 Γ kT Δt = Δt² · that of the random force.
        let (strength, inverse_reduced_mass, temperature, time) = (3.0, 2.0, 0.7, 1e-9);
        let exact = ornstein_uhlenbeck(strength, inverse_reduced_mass, temperature, time).variance;
        let explicit = random_force_variance(strength, temperature, time) * (time * inverse_reduced_mass).powi(2);
        assert!((exact / explicit - 1.0).abs() < 1e-8);
    }
}
