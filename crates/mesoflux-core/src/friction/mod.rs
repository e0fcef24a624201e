//! Pair friction laws: one file each, their registry, and the owner of the fluctuation–dissipation balance.

pub mod cross;
pub mod dot;
pub mod expression;
pub mod fluctuation_dissipation;
pub mod linear;
pub mod thinning;

use crate::expression::ExpressionError;
use crate::lanes::{BlockNumbers, Lanes, Real};
use crate::pair::PairLaw;
use crate::potential::Requirement;
use crate::vector::{Vector, dot};
use serde::{Deserialize, Serialize};

/// How the particles of a pair move against each other.
#[derive(Debug, Clone, Copy)]
pub struct Motion<R> {
    /// r.
    pub distance: R,
    /// u = e·v_ij: positive where they part.
    pub radial: R,
    /// w² = |v_ij − u e|².
    pub transverse_squared: R,
}

impl Motion<f64> {
    /// Of a pair at distance r along e, moving against each other by v.
    pub fn new(distance: f64, e: Vector, v: Vector) -> Self {
        let radial = dot(e, v);
        Self { distance, radial, transverse_squared: radial.mul_add(-radial, dot(v, v)).max(0.0) }
    }
}

impl<R: Real> Motion<R> {
    /// Along the line of centers only.
    pub fn along(distance: R, radial: R) -> Self {
        Self { distance, radial, transverse_squared: R::splat(0.0) }
    }
}

/// The same for the pairs of a block.
#[derive(Debug, Clone, Default)]
pub struct Motions {
    /// r.
    pub distance: BlockNumbers,
    /// u.
    pub radial: BlockNumbers,
    /// w².
    pub transverse_squared: BlockNumbers,
}

impl Motions {
    /// Eight of them.
    #[inline(always)]
    pub(crate) fn row<L: Lanes>(&self, row: usize) -> Motion<L> {
        Motion {
            distance: L::load(&self.distance[row]),
            radial: L::load(&self.radial[row]),
            transverse_squared: L::load(&self.transverse_squared[row]),
        }
    }
}

/// What a motion makes of a friction.
#[derive(Debug, Clone, Copy)]
pub struct Factor<R> {
    /// f.
    pub value: R,
    /// ∂f/∂u.
    pub slope: R,
}

/// The same for the pairs of a block.
#[derive(Debug, Clone, Default)]
pub struct Factors {
    /// f.
    pub value: BlockNumbers,
    /// ∂f/∂u.
    pub slope: BlockNumbers,
}

impl Factors {
    /// Eight of them.
    #[inline(always)]
    pub(crate) fn row<L: Lanes>(&self, row: usize) -> Factor<L> {
        Factor { value: L::load(&self.value[row]), slope: L::load(&self.slope[row]) }
    }
}

/// What a friction depends on, beside the distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dependence {
    /// Nothing: linear friction.
    Distance,
    /// The transverse relative velocity, which no impulse along the line of centers changes.
    Transverse,
    /// The radial relative velocity, on which the friction itself acts.
    Radial,
}

/// A friction along the line of centers with strength Γ(r, u, w) = A(r) f(r, u, w): the dissipative force on i is −Γ u e.
///
/// All is called for 0 < r < cutoff only. f must be even in u, or detailed balance is lost.
pub trait PairFriction: Clone + Send + Sync {
    /// r_c: no friction at and beyond.
    fn cutoff(&self) -> f64;
    /// A(r): what is known before the velocities are.
    fn amplitude<R: Real>(&self, r: R) -> R;
    /// f and its derivative.
    #[inline(always)]
    fn factor<R: Real>(&self, _motion: Motion<R>) -> Factor<R> {
        Factor { value: R::splat(1.0), slope: R::splat(0.0) }
    }
    /// On what f depends.
    fn dependence(&self) -> Dependence {
        Dependence::Distance
    }
    /// Name, value and requirement of every number that a user gives.
    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)>;
    /// What else a user must change, where a law is more than numbers.
    fn fault(&self) -> Option<&ExpressionError> {
        None
    }
    /// The factors of so many rows of a block.
    #[inline(always)]
    fn fill_factors<L: Lanes>(&self, rows: usize, motions: &Motions, factors: &mut Factors) {
        for row in 0..rows {
            let Factor { value, slope } = self.factor::<L>(motions.row(row));
            value.store(&mut factors.value[row]);
            slope.store(&mut factors.slope[row]);
        }
    }
}

/// Any of the known friction laws, by its name in the input file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Friction {
    /// Linear in the relative velocity.
    Linear(linear::Linear),
    /// Weaker the faster two particles pass each other.
    Cross(cross::Cross),
    /// Weaker the faster two particles approach or part.
    Dot(dot::Dot),
    /// Whatever the user types.
    Expression(expression::Expression),
}

/// Evaluates `$body` with the concrete law, so that a loop inside is compiled for that law alone.
macro_rules! with_law {
    ($friction:expr, $law:ident => $body:expr) => {
        match $friction {
            Friction::Linear($law) => $body,
            Friction::Cross($law) => $body,
            Friction::Dot($law) => $body,
            Friction::Expression($law) => $body,
        }
    };
}

impl Friction {
    /// r_c.
    pub fn cutoff(&self) -> f64 {
        with_law!(self, law => law.cutoff())
    }

    /// Γ(r, u, w), zero at and beyond the cutoff.
    pub fn strength(&self, motion: Motion<f64>) -> f64 {
        let inside = motion.distance < self.cutoff();
        with_law!(self, law => if inside { law.amplitude(motion.distance) * law.factor(motion).value } else { 0.0 })
    }

    /// ∂Γ/∂u, zero at and beyond the cutoff.
    pub fn slope(&self, motion: Motion<f64>) -> f64 {
        let inside = motion.distance < self.cutoff();
        with_law!(self, law => if inside { law.amplitude(motion.distance) * law.factor(motion).slope } else { 0.0 })
    }

    /// Γ of two particles that don't move against each other.
    pub fn at_rest(&self, r: f64) -> f64 {
        self.strength(Motion::along(r, 0.0))
    }

    /// On what it depends beside the distance.
    pub fn dependence(&self) -> Dependence {
        with_law!(self, law => law.dependence())
    }

    /// Name, value and requirement of every number that a user gives.
    pub fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        with_law!(self, law => law.parameters())
    }

    /// What else a user must change, where a law is more than numbers.
    pub fn fault(&self) -> Option<&ExpressionError> {
        with_law!(self, law => law.fault())
    }

    /// The factors of so many rows of a block.
    #[inline(always)]
    pub(crate) fn fill_factors<L: Lanes>(&self, rows: usize, motions: &Motions, factors: &mut Factors) {
        with_law!(self, law => law.fill_factors::<L>(rows, motions, factors));
    }
}

/// A loop over a block's amplitudes, compiled for one law.
#[inline(always)]
fn fill_amplitudes<L: Lanes>(
    law: &impl PairFriction,
    streams: usize,
    distance: &BlockNumbers,
    values: &mut BlockNumbers,
) {
    for s in 0..streams {
        let r = L::load(&distance[s]);
        L::select(r.below(L::splat(law.cutoff())), law.amplitude(r), L::splat(0.0)).store(&mut values[s]);
    }
}

impl PairLaw for Friction {
    /// The amplitudes A(r).
    #[inline(always)]
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers) {
        let at_rest = match self {
            Self::Linear(law) => *law,
            Self::Cross(law) => law.0.at_rest(),
            Self::Dot(law) => law.0.at_rest(),
            Self::Expression(law) => return fill_amplitudes::<L>(law, streams, distance, values),
        };
        if at_rest.exponent == 2.0 {
            fill_amplitudes::<L>(&at_rest.quadratic(), streams, distance, values);
        } else {
            fill_amplitudes::<L>(&at_rest, streams, distance, values);
        }
    }
}

#[cfg(test)]
pub(crate) mod checks {
    //! The checker that every law passes.

    use super::{Dependence, Motion, PairFriction};

    /// The law is the expected one at many motions, even in u, its slope the derivative, and it depends on no more than it says.
    pub fn check_law(law: &impl PairFriction, expected: impl Fn(f64, f64, f64) -> f64) {
        let strength = |distance: f64, radial: f64, w: f64| {
            let motion = Motion { distance, radial, transverse_squared: w * w };
            (law.amplitude(distance) * law.factor(motion).value, law.amplitude(distance) * law.factor(motion).slope)
        };
        for r in [0.05, 0.3, 0.77, 0.99] {
            for u in [0.0, 1e-3, 0.4, -0.9, 2.0] {
                for w in [0.0, 0.2, 1.5] {
                    let ((value, slope), h) = (strength(r, u, w), 1e-5);
                    assert!((value - expected(r, u, w)).abs() < 1e-13, "r = {r}, u = {u}, w = {w}: {value}");
                    let difference = (expected(r, u + h, w) - expected(r, u - h, w)) / (2.0 * h);
                    assert!((slope - difference).abs() < 1e-8, "r = {r}, u = {u}, w = {w}: slope {slope}");
                    assert!(value >= 0.0 && value == strength(r, -u, w).0 && slope == -strength(r, -u, w).1);
                    assert!(law.dependence() == Dependence::Radial || slope == 0.0);
                }
            }
        }
    }
}
