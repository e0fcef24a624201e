//! A friction that the user types.

use super::{Dependence, Factor, Factors, Motion, Motions, PairFriction};
use crate::expression::{self, ExpressionError, Tape};
use crate::lanes::{BlockNumbers, Lanes, Real};
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// γ(r, u, w) as an expression in `r`, `radial` (u = e·v_ij) and `transverse` (w = |v_ij − u e|), for r < r_c; nothing beyond.
///
/// `friction = "5*(1 - r)^2/(1 + radial^2)", cutoff = 1`; see [`crate::expression`] for the language. It must not change when
/// `radial` changes its sign: a friction that tells coming from going breaks detailed balance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// γ(r, u, w).
    pub friction: String,
    /// Numbers by the names that the expression gives them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// r_c.
    pub cutoff: f64,
}

/// A [`Source`] and what follows from it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Source", into = "Source")]
pub struct Expression {
    source: Source,
    law: Result<Arc<Law>, ExpressionError>,
}

/// What the kernels need of an expression.
#[derive(Debug)]
struct Law {
    /// γ(r, u, w).
    friction: Tape,
    /// ∂γ/∂u, where it isn't zero everywhere.
    slope: Option<Tape>,
    dependence: Dependence,
}

/// Distances at which an expression is looked at before it is used, evenly up to the cutoff.
const DISTANCES: u32 = 50;

/// Speeds at which it is looked at: zero, and powers of two up and down from one.
fn speeds() -> impl Iterator<Item = f64> {
    std::iter::once(0.0).chain((0..=10).chain(-20..0).map(|power| f64::powi(2.0, power)))
}

impl Law {
    fn new(source: &Source) -> Result<Self, ExpressionError> {
        let variables = ["r", "radial", "transverse"];
        let mut expression = expression::Expression::parse(&source.friction, &variables, &source.parameters)?;
        let friction = expression.value();
        let slope = expression.derivative(friction, 1, 1.0);
        let transverse = expression.derivative(friction, 2, 1.0);
        let [flat, still] = [slope, transverse].map(|derivative| expression.is_zero(derivative));
        let dependence = match (flat, still) {
            (true, true) => Dependence::Distance,
            (true, false) => Dependence::Transverse,
            (false, _) => Dependence::Radial,
        };
        let law = Self {
            friction: expression.tape(friction)?,
            slope: if flat { None } else { Some(expression.tape(slope)?) },
            dependence,
        };
        let whole = |requirement: String| Err(ExpressionError::whole(&source.friction, requirement));
        if !Requirement::Positive.holds(source.cutoff) {
            return whole("needs a cutoff that is positive and finite".into());
        }
        for k in 1..DISTANCES {
            let r = source.cutoff * f64::from(k) / f64::from(DISTANCES);
            for radial in speeds() {
                for transverse in speeds() {
                    let there = || format!("at r = {r}, radial = {radial}, transverse = {transverse}");
                    let [here, opposite] = [radial, -radial].map(|u| law.friction.value(&[r, u, transverse]));
                    if !(here.is_finite() && here >= 0.0) {
                        return whole(format!("must be finite and at least zero, but {} it is {here}", there()));
                    }
                    if (here - opposite).abs() > 1e-9 * here.abs() {
                        let change = format!("but {} it is {here}, and {opposite} when they part as fast", there());
                        return whole(format!("must not change with the sign of radial, {change}"));
                    }
                    let slope = law.slope.as_ref().map_or(0.0, |slope| slope.value(&[r, radial, transverse]));
                    if !slope.is_finite() {
                        let requirement =
                            format!("must have a finite derivative with respect to radial, but {}", there());
                        return whole(format!("{requirement} it is {slope}"));
                    }
                }
            }
        }
        Ok(law)
    }
}

impl From<Source> for Expression {
    /// A source with a fault is kept with it: [`PairFriction::fault`] tells, and its friction is no number.
    fn from(source: Source) -> Self {
        let law = Law::new(&source).map(Arc::new);
        Self { source, law }
    }
}

impl From<Expression> for Source {
    fn from(expression: Expression) -> Self {
        expression.source
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.source == other.source
    }
}

impl PairFriction for Expression {
    fn cutoff(&self) -> f64 {
        self.source.cutoff
    }

    /// Nothing can be told apart from the velocities: all stands in the factor.
    #[inline(always)]
    fn amplitude<R: Real>(&self, _r: R) -> R {
        R::splat(1.0)
    }

    fn factor<R: Real>(&self, motion: Motion<R>) -> Factor<R> {
        let variables = [motion.distance, motion.radial, motion.transverse_squared.sqrt()];
        let Ok(law) = &self.law else {
            return Factor { value: R::splat(f64::NAN), slope: R::splat(f64::NAN) };
        };
        let slope = law.slope.as_ref().map_or(R::splat(0.0), |slope| slope.value(&variables));
        Factor { value: law.friction.value(&variables), slope }
    }

    fn dependence(&self) -> Dependence {
        // Even a friction by distance alone is worked out with the factors: one tape, one place.
        self.law.as_ref().map_or(Dependence::Radial, |law| law.dependence.max(Dependence::Transverse))
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        vec![("cutoff", self.source.cutoff, Requirement::Positive)]
    }

    fn fault(&self) -> Option<&ExpressionError> {
        self.law.as_ref().err()
    }

    /// Runs the tapes for many pairs at once.
    #[inline(always)]
    fn fill_factors<L: Lanes>(&self, rows: usize, motions: &Motions, factors: &mut Factors) {
        let mut variables = [motions.distance, motions.radial, motions.transverse_squared];
        for s in 0..rows {
            L::load(&motions.transverse_squared[s]).sqrt().store(&mut variables[2][s]);
        }
        let Ok(law) = &self.law else {
            for s in 0..rows {
                L::splat(f64::NAN).store(&mut factors.value[s]);
            }
            return;
        };
        law.friction.fill(rows, &variables, &mut factors.value);
        match &law.slope {
            Some(slope) => slope.fill(rows, &variables, &mut factors.slope),
            None => factors.slope = BlockNumbers::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(friction: &str) -> Expression {
        Source { friction: friction.into(), parameters: [("g".to_owned(), 5.0)].into(), cutoff: 1.0 }.into()
    }

    #[test]
    fn typed_laws_are_those_of_the_paper() {
        let cross = law("g*(1 - r)^2*exp(-0.7*(r*transverse)^2)");
        assert_eq!(cross.dependence(), Dependence::Transverse);
        crate::friction::checks::check_law(&cross, |r, _, w| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * w).powi(2)).exp());
        let dot = law("g*(1 - r)^2*exp(-0.7*(r*radial)^2)");
        assert_eq!(dot.dependence(), Dependence::Radial);
        crate::friction::checks::check_law(&dot, |r, u, _| 5.0 * (1.0 - r).powi(2) * (-0.7 * (r * u).powi(2)).exp());
        let both = law("g*(1 - r)^2/(1 + radial^2*transverse)");
        crate::friction::checks::check_law(&both, |r, u, w| 5.0 * (1.0 - r).powi(2) / (1.0 + u * u * w));
    }

    #[test]
    fn what_breaks_the_balance_is_refused() {
        let fault = |friction: &str| law(friction).fault().expect("a fault").to_string();
        assert!(fault("g*(1 - r)^2*exp(-0.1*tanh(radial))").starts_with("must not change with the sign of radial"));
        assert!(fault("g*(0.5 - r)").starts_with("must be finite and at least zero, but at r = 0.52"));
        assert!(fault("g*(2 - transverse)").starts_with("must be finite and at least zero"));
        assert!(fault("sqrt(abs(radial))").starts_with("must have a finite derivative with respect to radial"));
        assert!(fault("g*speed").contains("speed"));
        assert!(law("g*speed").amplitude(0.5) > 0.0 && law("g*speed").factor(Motion::along(0.5, 0.1)).value.is_nan());
        assert!(law("abs(radial)").fault().is_none(), "a kink is no fault");
    }
}
