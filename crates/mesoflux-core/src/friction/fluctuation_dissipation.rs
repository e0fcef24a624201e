//! The one owner of the balance between friction and noise.
//!
//! Users give a friction and a temperature; what noise belongs to them is derived here and nowhere else.
//!
//! For a pair with friction strength Γ = γ ω(r) and reduced mass μ = m_i m_j/(m_i + m_j) the relative velocity along the line
//! of centers, u = e·v_ij, obeys the Ornstein–Uhlenbeck equation du = −(Γ/μ) u dt + √(2 Γ kT)/μ dW (Wu & Shang, eqs 1, 4, 27).

use crate::elementary::{exp, exp_minus_one};
use crate::lanes::Real;
use serde::{Deserialize, Serialize};

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

/// How an explicit scheme takes the noise's own effect on the friction into account, where the friction depends on u.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// By the derivative of the friction: Λ = kT (1/m_i + 1/m_j) ∂Γ/∂u (Naseri et al., eqs 32, 77, 86).
    #[default]
    Derivative,
    /// By two steps with the same random number: the noise is as strong as the friction at the velocity to which a first impulse
    /// leads (Naseri et al., eqs 33–38).
    TwoStep,
}

/// The amplitude of a random force that is constant over one step of an explicit scheme, √(2 Γ kT/Δt) (Wu & Shang, eq. 4).
#[inline(always)]
pub fn random_force<R: Real>(strength: R, temperature: f64, time_step: f64) -> R {
    (strength * R::splat(2.0 * temperature / time_step)).sqrt()
}

/// Λ = kT (1/m_i + 1/m_j) ∂Γ/∂u: the random force is √(2ΓkT/Δt) ξ + Λ ξ² where Γ depends on u (Naseri et al., eqs 13, 77).
///
/// The diffusion of u has the strength kT Γ/μ²; for the Maxwell distribution to be stationary its drift must be
/// −Γu/μ + kT Γ'/μ² (the noise in the sense of Itô), and μΛ⟨ξ²⟩/μ² is the second term.
#[inline(always)]
pub fn correction<R: Real>(slope: R, inverse_reduced_mass: R, temperature: f64) -> R {
    R::splat(temperature) * inverse_reduced_mass * slope
}

/// u after the first of the two steps: the whole random impulse with the friction at u (Naseri et al., eqs 33–35).
#[inline(always)]
pub fn predicted<R: Real>(u: R, random_force: R, inverse_reduced_mass: R, time_step: f64) -> R {
    (R::splat(time_step) * inverse_reduced_mass * random_force) + u
}

/// One proposal for u over a time t, with the friction at u: u + Δ with Δ = (c − 1)u + Sξ + ½D(1 + ξ²).
///
/// c = e^(−Γt/μ), S² = (kT/μ)(1 − c²), D = S ∂S/∂u = (kT/μ²) t c² ∂Γ/∂u. It is Milstein's step, written so that it is the exact
/// solution where Γ is constant. Its drift holds the correction Λ, and its skew ½Dξ² makes forward and backward steps equally likely
/// up to t^(3/2); [`PairStep::accepted`] removes what is left. Derivation and proof are in `book/src/friction.md`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairStep<R> {
    /// c − 1.
    pub decay: R,
    /// S.
    pub spread: R,
    /// D.
    pub skew: R,
}

impl<R: Real> PairStep<R> {
    /// The step with Γ and ∂Γ/∂u at some u.
    #[inline(always)]
    pub fn new(strength: R, slope: R, inverse_reduced_mass: R, temperature: f64, time: f64) -> Self {
        let OrnsteinUhlenbeck { decay, variance } =
            ornstein_uhlenbeck(strength, inverse_reduced_mass, temperature, time);
        let kept = decay + R::splat(1.0);
        let rate = R::splat(temperature * time) * (inverse_reduced_mass * inverse_reduced_mass);
        Self { decay, spread: variance.sqrt(), skew: rate * (kept * kept) * slope }
    }

    /// Δ.
    #[inline(always)]
    pub fn change(&self, u: R, normal: R) -> R {
        let skewed = R::splat(0.5) * self.skew * normal.mul_add(normal, R::splat(1.0));
        self.decay.mul_add(u, self.spread.mul_add(normal, skewed))
    }

    /// ⟨Δ⟩ = (c − 1)u + D.
    #[inline(always)]
    pub fn expected(&self, u: R) -> R {
        self.decay.mul_add(u, self.skew)
    }

    /// Δ where the step is accepted, else zero, so that the Maxwell distribution of u is invariant for every time t.
    ///
    /// `back` is the step with the friction at u + Δ, `uniform` a random number from 0 to 1. With ξ' the number that leads back and
    /// J = ∂u'/∂ξ = S + Dξ, the step is taken with probability min(1, (J/J') e^(½(u² − u'²)μ/kT + ½(ξ² − ξ'²))) where J > 0 and J' > 0:
    /// detailed balance on that branch of the map. No number where the friction at either end is negative or none.
    #[inline(always)]
    pub fn accepted(&self, back: &Self, u: R, normal: R, uniform: R, variance: R) -> R {
        let (zero, half) = (R::splat(0.0), R::splat(0.5));
        let change = self.change(u, normal);
        let after = u + change;
        // ½D'ξ'² + S'ξ' + q = 0, by the root that is small.
        let q = half.mul_add(back.skew, back.decay.mul_add(after, change));
        let squared = back.spread.mul_add(back.spread, R::splat(-2.0) * back.skew * q);
        let (stretch, back_stretch) = (self.skew.mul_add(normal, self.spread), squared.sqrt());
        let back_normal = R::splat(-2.0) * q / (back.spread + back_stretch);
        let energy = -(change * (u + after)) / variance;
        let exponent = half * (normal - back_normal).mul_add(normal + back_normal, energy);
        let taken = R::select((uniform * back_stretch).below(stretch * exp(exponent)), change, zero);
        let taken = R::select(zero.below(stretch), taken, zero);
        let taken = R::select(zero.below(squared), taken, zero);
        // Spreads are no numbers where a friction is negative: a wrong law must not pass for one that never moves.
        let sound = (self.spread + back.spread).below(R::splat(f64::INFINITY));
        R::select(sound, taken, R::splat(f64::NAN))
    }
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
        let explicit = (random_force(strength, temperature, time) * time * inverse_reduced_mass).powi(2);
        assert!((exact / explicit - 1.0).abs() < 1e-8);
    }
}
