//! A pair potential that the user types.

use super::lennard_jones::Truncation;
use super::{PairPotential, Requirement};
use crate::expression::{self, ExpressionError, Tape};
use crate::lanes::{BlockNumbers, Lanes, Real};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// u(r) as an expression in r, f(r) = −u'(r) by its exact derivative, for r < r_c; nothing beyond, with what the truncation adds.
///
/// `energy = "4*e*((s/r)^12 - (s/r)^6)", parameters = { e = 1.0, s = 1.0 }`; see [`crate::expression`] for the language.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// u(r), before the truncation.
    pub energy: String,
    /// Numbers by the names that the expression gives them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// r_c.
    pub cutoff: f64,
    /// What happens at the cutoff; left out, neither energy nor force jumps.
    #[serde(default)]
    pub truncation: Truncation,
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
    /// u(r), before the truncation.
    energy: Tape,
    /// −u'(r), before the truncation.
    force: Tape,
    /// −u''(r).
    force_derivative: Tape,
    /// What the truncation takes away from the energy, that at the cutoff.
    energy_shift: f64,
    /// What the truncation takes away from the force, that at the cutoff.
    force_shift: f64,
    contact_distance: f64,
}

/// Places at which an expression is looked at before it is used, evenly up to the cutoff.
const SAMPLES: u32 = 1000;

impl Law {
    fn new(source: &Source) -> Result<Self, ExpressionError> {
        let mut expression = expression::Expression::parse(&source.energy, &["r"], &source.parameters)?;
        let energy = expression.value();
        let force = expression.derivative(energy, 0, -1.0);
        let force_derivative = expression.derivative(force, 0, 1.0);
        let mut law = Self {
            energy: expression.tape(energy)?,
            force: expression.tape(force)?,
            force_derivative: expression.tape(force_derivative)?,
            energy_shift: 0.0,
            force_shift: 0.0,
            contact_distance: 0.0,
        };
        if !Requirement::Positive.holds(source.cutoff) {
            return Err(ExpressionError::whole(&source.energy, "needs a cutoff that is positive and finite"));
        }
        let at = |k: u32| source.cutoff * f64::from(k) / f64::from(SAMPLES);
        let named =
            [("energy", &law.energy), ("force", &law.force), ("derivative of the force", &law.force_derivative)];
        for k in 1..=SAMPLES {
            // Nobody asks for the derivative of the force at the cutoff itself, where many a law has none.
            let asked = if k == SAMPLES { 2 } else { 3 };
            for (name, tape) in &named[..asked] {
                let (r, value) = (at(k), tape.value(&[at(k)]));
                if !value.is_finite() {
                    let requirement =
                        format!("must be finite for 0 < r <= cutoff, but at r = {r} the {name} is {value}");
                    return Err(ExpressionError::whole(&source.energy, requirement));
                }
            }
        }
        // A core is hard where the energy at small distances is beyond all comparison with that at large ones.
        let value = |k: u32| law.energy.value(&[at(k)]);
        let scale = (SAMPLES / 2..=SAMPLES).map(|k| value(k).abs()).fold(0.0, f64::max);
        if value(1) > 1e6 * scale {
            law.contact_distance = (1..=SAMPLES).rev().find(|&k| value(k) > 10.0 * scale).map_or(0.0, at);
        }
        let [energy, force] = [&law.energy, &law.force].map(|tape| tape.value(&[source.cutoff]));
        law.energy_shift = if source.truncation == Truncation::Plain { 0.0 } else { energy };
        law.force_shift = if source.truncation == Truncation::ForceShifted { force } else { 0.0 };
        Ok(law)
    }
}

impl From<Source> for Expression {
    /// A source with a fault is kept with it: [`PairPotential::fault`] tells, and its energies and forces are no numbers.
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

impl PairPotential for Expression {
    fn cutoff(&self) -> f64 {
        self.source.cutoff
    }

    fn energy(&self, r: f64) -> f64 {
        self.law.as_ref().map_or(f64::NAN, |law| {
            law.energy.value(&[r]) - law.energy_shift + law.force_shift * (r - self.source.cutoff)
        })
    }

    fn force<R: Real>(&self, r: R) -> R {
        match &self.law {
            Ok(law) => law.force.value(&[r]) - R::splat(law.force_shift),
            Err(_) => R::splat(f64::NAN),
        }
    }

    fn force_derivative(&self, r: f64) -> f64 {
        self.law.as_ref().map_or(f64::NAN, |law| law.force_derivative.value(&[r]))
    }

    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        vec![("cutoff", self.source.cutoff, Requirement::Positive)]
    }

    fn contact_distance(&self) -> f64 {
        self.law.as_ref().map_or(0.0, |law| law.contact_distance)
    }

    fn fault(&self) -> Option<&ExpressionError> {
        self.law.as_ref().err()
    }

    /// Runs the tape for many pairs at once: each instruction is looked up once for 32 of them.
    #[inline(always)]
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers) {
        let Ok(law) = &self.law else {
            for s in 0..streams {
                L::splat(f64::NAN).store(&mut values[s]);
            }
            return;
        };
        law.force.fill(streams, std::slice::from_ref(distance), values);
        for s in 0..streams {
            let (r, force) = (L::load(&distance[s]), L::load(&values[s]) - L::splat(law.force_shift));
            L::select(r.below(L::splat(self.source.cutoff)), force, L::splat(0.0)).store(&mut values[s]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::lennard_jones::LennardJones;
    use crate::potential::soft::Soft;
    use crate::potential::wca::Wca;

    fn law(energy: &str, parameters: &[(&str, f64)], cutoff: f64, truncation: Truncation) -> Expression {
        let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        Expression::from(Source { energy: energy.to_owned(), parameters, cutoff, truncation })
    }

    /// Energy, force and its derivative of two laws, relative to the size of what the force is made of.
    fn check_equal(expression: &Expression, law: &impl PairPotential, from: f64, size: impl Fn(f64) -> f64) {
        assert_eq!(expression.fault(), None);
        let cutoff = law.cutoff();
        for r in (0..=2000).map(|k| from + (cutoff - from) * f64::from(k) / 2000.0) {
            let close = |found: f64, expected: f64, size: f64| (found - expected).abs() <= 1e-12 * size;
            assert!(close(expression.force(r), law.force(r), size(r)), "force at {r}: {}", expression.force(r));
            assert!(close(expression.energy(r), law.energy(r), r * size(r)), "energy at {r}: {}", expression.energy(r));
            let (found, expected) = (expression.force_derivative(r), law.force_derivative(r));
            assert!(close(found, expected, 20.0 * size(r) / r), "derivative at {r}: {found}");
        }
    }

    #[test]
    fn expressions_of_the_built_in_laws_are_those_laws() {
        let soft = Soft { repulsion: 25.0, cutoff: 1.0 };
        let typed = law("a/2*(1 - r)^2", &[("a", 25.0)], 1.0, Truncation::Plain);
        check_equal(&typed, &soft, 1e-3, |r| soft.force(r) + 1e-300);
        for truncation in [Truncation::Plain, Truncation::Shifted, Truncation::ForceShifted] {
            let built_in = LennardJones { epsilon: 1.5, sigma: 0.9, cutoff: 2.25, truncation };
            let text = "4*epsilon*((sigma/r)^12 - (sigma/r)^6)";
            let typed = law(text, &[("epsilon", 1.5), ("sigma", 0.9)], 2.25, truncation);
            // Repulsion and attraction cancel near the minimum: their sum, not the difference, is what is rounded.
            let size = |r: f64| 24.0 * 1.5 / r * (2.0 * (0.9f64 / r).powi(12) + (0.9 / r).powi(6));
            check_equal(&typed, &built_in, 0.6, size);
            crate::potential::checks::check_law(&typed, 0.7, truncation == Truncation::ForceShifted);
        }
        let wca = Wca { epsilon: 2.0, sigma: 1.1 };
        let typed = law("8*(s^12/r^12 - s^6/r^6)", &[("s", 1.1)], wca.cutoff(), Truncation::Shifted);
        check_equal(&typed, &wca, 0.8, |r| 48.0 / r * (2.0 * (1.1f64 / r).powi(12) + (1.1 / r).powi(6)));
    }

    #[test]
    fn other_laws_pass_the_checker() {
        for (energy, from) in [
            ("exp(-3*r)/r", 0.05),
            ("20*exp(-r^2/0.18) - tanh(r)*cos(4*r)", 0.01),
            ("r^2.5 + ln(r) + sqrt(2 - r) + log10(r + 1)", 0.05),
            ("5*max(0.7 - r, 0)^4 + min(r, 2)^3 + if(r < 2, sin(r), 0)", 0.01),
        ] {
            let law = law(energy, &[], 1.5, Truncation::ForceShifted);
            assert_eq!(law.fault(), None);
            crate::potential::checks::check_law(&law, from, true);
        }
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let fault =
            |energy: &str, cutoff: f64| law(energy, &[], cutoff, Truncation::Plain).fault().unwrap().to_string();
        assert_eq!(
            fault("sqrt(r - 0.25)", 1.0),
            "must be finite for 0 < r <= cutoff, but at r = 0.001 the energy is NaN"
        );
        assert_eq!(fault("1/(r - 0.5)", 1.0), "must be finite for 0 < r <= cutoff, but at r = 0.5 the energy is inf");
        assert_eq!(
            fault("abs(0.5 - r)^1.5", 1.0),
            "must be finite for 0 < r <= cutoff, but at r = 0.5 the derivative of the force is -inf"
        );
        assert_eq!(
            law("(1 - r)^1.5", &[], 1.0, Truncation::Plain).fault(),
            None,
            "only its end has no second derivative"
        );
        assert_eq!(fault("r", f64::NAN), "needs a cutoff that is positive and finite");
        assert!(law("q*r", &[], 1.0, Truncation::Plain).force(0.5).is_nan(), "a law with a fault");
    }

    #[test]
    fn hard_cores_are_recognized() {
        let lennard_jones = law("4*(r^-12 - r^-6)", &[], 2.5, Truncation::ForceShifted);
        assert!((lennard_jones.contact_distance() - 0.89).abs() < 0.01, "{}", lennard_jones.contact_distance());
        assert_eq!(law("12.5*(1 - r)^2", &[], 1.0, Truncation::Plain).contact_distance(), 0.0);
        assert_eq!(law("exp(-r)/r", &[], 1.0, Truncation::Plain).contact_distance(), 0.0);
    }
}
