//! Conservative pair laws: one file each, and the registry that the input file, the kernels and the manual share.

pub mod expression;
pub mod fene;
pub mod harmonic;
pub mod lennard_jones;
pub mod soft;
pub mod wca;

use crate::expression::ExpressionError;
use crate::lanes::{BlockNumbers, Lanes, Real};
use crate::pair::PairLaw;
use serde::{Deserialize, Serialize};

/// A radial pair potential u(r) with force f(r) = −u'(r), positive where it repels.
///
/// The functions are called for 0 < r < cutoff only.
pub trait PairPotential: Clone + Send + Sync {
    /// r_c: no interaction at and beyond.
    fn cutoff(&self) -> f64;
    /// u(r).
    fn energy(&self, r: f64) -> f64;
    /// f(r) = −u'(r).
    fn force<R: Real>(&self, r: R) -> R;
    /// f'(r) = −u''(r), without a delta function where the force jumps at the cutoff.
    fn force_derivative(&self, r: f64) -> f64;
    /// Name, value and requirement of every number that a user gives.
    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)>;
    /// Below this distance two particles overlap so that a start must separate them; zero for soft laws.
    fn contact_distance(&self) -> f64 {
        0.0
    }
    /// What else a user must change, where a law is more than numbers.
    fn fault(&self) -> Option<&ExpressionError> {
        None
    }
    /// The forces at a block's distances, zero at and beyond the cutoff.
    #[inline(always)]
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers) {
        for s in 0..streams {
            let r = L::load(&distance[s]);
            L::select(r.below(L::splat(self.cutoff())), self.force(r), L::splat(0.0)).store(&mut values[s]);
        }
    }
}

/// What a parameter must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Requirement {
    /// Any finite number.
    Finite,
    /// Finite and at least zero.
    NotNegative,
    /// Finite and above zero.
    Positive,
}

impl Requirement {
    /// Whether a value meets the requirement.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::NotNegative => value >= 0.0,
                Self::Positive => value > 0.0,
            }
    }
}

impl std::fmt::Display for Requirement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Finite => "must be a finite number",
            Self::NotNegative => "must be at least zero and finite",
            Self::Positive => "must be positive and finite",
        })
    }
}

/// Any of the known pair potentials, by its name in the input file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Potential {
    /// Groot and Warren's soft repulsion.
    Soft(soft::Soft),
    /// Lennard-Jones with a truncation.
    LennardJones(lennard_jones::LennardJones),
    /// Weeks, Chandler and Andersen.
    Wca(wca::Wca),
    /// Whatever the user types.
    Expression(expression::Expression),
}

/// Evaluates `$body` with the concrete law, so that a loop inside is compiled for that law alone.
macro_rules! with_law {
    ($potential:expr, $law:ident => $body:expr) => {
        match $potential {
            Potential::Soft($law) => $body,
            Potential::LennardJones($law) => $body,
            Potential::Wca($law) => $body,
            Potential::Expression($law) => $body,
        }
    };
}

impl Potential {
    /// r_c.
    pub fn cutoff(&self) -> f64 {
        with_law!(self, law => law.cutoff())
    }

    /// u(r), zero at and beyond the cutoff.
    pub fn energy(&self, r: f64) -> f64 {
        with_law!(self, law => if r < law.cutoff() { law.energy(r) } else { 0.0 })
    }

    /// f(r), zero at and beyond the cutoff.
    #[inline(always)]
    pub fn force<R: Real>(&self, r: R) -> R {
        with_law!(self, law => R::select(r.below(R::splat(law.cutoff())), law.force(r), R::splat(0.0)))
    }

    /// f'(r), zero at and beyond the cutoff.
    pub fn force_derivative(&self, r: f64) -> f64 {
        with_law!(self, law => if r < law.cutoff() { law.force_derivative(r) } else { 0.0 })
    }

    /// Name, value and requirement of every number that a user gives.
    pub fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        with_law!(self, law => law.parameters())
    }

    /// Below this distance two particles overlap so that a start must separate them; zero for soft laws.
    pub fn contact_distance(&self) -> f64 {
        with_law!(self, law => law.contact_distance())
    }

    /// What else a user must change, where a law is more than numbers.
    pub fn fault(&self) -> Option<&ExpressionError> {
        with_law!(self, law => law.fault())
    }

    /// The jump of the energy at the cutoff, u(r_c⁻).
    pub fn energy_jump(&self) -> f64 {
        with_law!(self, law => law.energy(law.cutoff()))
    }

    /// The jump of the force at the cutoff, f(r_c⁻).
    pub fn force_jump(&self) -> f64 {
        with_law!(self, law => law.force(law.cutoff()))
    }
}

impl PairLaw for Potential {
    #[inline(always)]
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers) {
        with_law!(self, law => law.fill::<L>(streams, distance, values));
    }
}

#[cfg(test)]
pub(crate) mod checks {
    //! The checker that every law passes.

    use super::PairPotential;

    /// The force is minus the gradient, its derivative is its derivative, and where promised nothing jumps at the cutoff.
    pub fn check_law(law: &impl PairPotential, from: f64, continuous: bool) {
        let cutoff = law.cutoff();
        check_gradients(law, from, cutoff - 1e-3);
        if continuous {
            let scale = law.energy(0.9 * cutoff).abs() + law.force(0.9 * cutoff).abs();
            assert!(law.energy(cutoff).abs() < 1e-12 * scale && law.force(cutoff).abs() < 1e-12 * scale);
        }
    }

    /// The force is minus the gradient and its derivative is its derivative between two distances.
    pub fn check_gradients(law: &impl PairPotential, from: f64, to: f64) {
        for k in 0..400 {
            let r = from + (to - from) * f64::from(k) / 400.0;
            // Central differences of fourth order.
            let h = 2e-4 * r;
            let slope =
                |g: &dyn Fn(f64) -> f64| (8.0 * (g(r + h) - g(r - h)) - (g(r + 2.0 * h) - g(r - 2.0 * h))) / (12.0 * h);
            let force = -slope(&|r| law.energy(r));
            let scale = law.energy(r).abs() / r + law.force(r).abs() + 1e-6;
            assert!((law.force(r) - force).abs() < 1e-9 * scale, "r = {r}: force {} against {force}", law.force(r));
            let derivative = slope(&|r| law.force(r));
            let scale = law.force(r).abs() / r + law.force_derivative(r).abs() + 1e-6;
            assert!((law.force_derivative(r) - derivative).abs() < 1e-9 * scale, "r = {r}: derivative of the force");
        }
    }
}
