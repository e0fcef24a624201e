//! A forcing and its response that the user types.

use super::{Forcing, ForcingError};
use crate::elementary::wrapped;
use crate::expression::{Expression, ExpressionError, Tape, in_box};
use crate::state::Particles;
use crate::vector::{Vector, dot};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// F_i = `force`, and what multiplies the velocity v_i in the flux R = Σ_i `response`·v_i, so that G_i = `response`/m_i.
///
/// Each is three expressions in the place x, y, z of a particle in the box, 0 ≤ x < lx and so on, the sides lx, ly, lz of the box, the
/// number n of particles, `color`, 1 for even ids and −1 for odd ones, and parameters by name: `force = ["sin(2*pi*y/ly)", "0", "0"],
/// response = ["sin(2*pi*y/ly)/n", "0", "0"]` is the sinusoidal forcing. See [`crate::expression`] for the language.
///
/// Both must be the same on opposite faces of the box. A response should not jump within it either: the drift (∇G p)·M⁻¹p of
/// Wu & Shang's eq. 13 has no part for jumps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpressionSource {
    /// F.
    #[serde(deserialize_with = "components")]
    pub force: [String; 3],
    /// m G.
    #[serde(deserialize_with = "components")]
    pub response: [String; 3],
    /// Numbers by the names that the expressions give them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
}

/// Reads three texts, no more and no fewer.
fn components<'de, D: Deserializer<'de>>(input: D) -> Result<[String; 3], D::Error> {
    let given = Vec::<String>::deserialize(input)?;
    let expected = &"three expressions, along x, y and z";
    given.try_into().map_err(|given: Vec<String>| serde::de::Error::invalid_length(given.len(), expected))
}

impl ExpressionSource {
    /// Numbers that tell it from all others: texts, names and values, each text after its length.
    pub(super) fn identity(&self) -> Vec<u64> {
        let text = |text: &String| {
            let bytes = text.bytes().map(u64::from);
            std::iter::once(text.len() as u64).chain(bytes).collect::<Vec<u64>>()
        };
        let mut numbers: Vec<u64> = self.force.iter().chain(&self.response).flat_map(text).collect();
        for (name, value) in &self.parameters {
            numbers.extend(text(name));
            numbers.push(value.to_bits());
        }
        numbers
    }
}

/// Three functions of x, y, z and the color; nothing where one is zero.
type Components = [Option<Tape>; 3];

/// An [`ExpressionSource`] in a box, and what follows from it.
#[derive(Debug, Clone)]
pub struct ExpressionForcing {
    sides: Vector,
    /// F.
    force: Components,
    /// m G.
    response: Components,
    /// The gradient of every component of m G.
    gradients: [Components; 3],
}

impl ExpressionForcing {
    /// The forcing of a source for so many particles in a box with these sides.
    ///
    /// # Errors
    /// A text that is no expression, values that aren't finite or not periodic; a force or response that is zero.
    pub fn new(source: &ExpressionSource, sides: Vector, particles: usize) -> Result<Self, ForcingError> {
        let empty = || [const { None }; 3];
        let (mut force, mut response, mut gradients) = (empty(), empty(), [empty(), empty(), empty()]);
        for axis in 0..3 {
            let wrong = |key| move |error| ForcingError::Expression { key, axis, error: Box::new(error) };
            let read = |key, text| component(key, text, source, sides, particles).map_err(wrong(key));
            (force[axis], _) = read("force", &source.force[axis])?;
            (response[axis], gradients[axis]) = read("response", &source.response[axis])?;
        }
        for (key, components) in [("force", &force), ("response", &response)] {
            if components.iter().all(Option::is_none) {
                return Err(ForcingError::Vanishing(key));
            }
        }
        Ok(Self { sides, force, response, gradients })
    }

    /// x, y, z and the color of the particle in place k.
    fn variables(&self, particles: &Particles, k: usize) -> [f64; 4] {
        let [x, y, z] = std::array::from_fn(|axis| wrapped(particles.position[k][axis], self.sides[axis]));
        [x, y, z, if particles.id[k].is_multiple_of(2) { 1.0 } else { -1.0 }]
    }
}

/// A component of the force or the response and its gradient, finite and periodic.
fn component(
    key: &str,
    text: &str,
    source: &ExpressionSource,
    sides: Vector,
    particles: usize,
) -> Result<(Option<Tape>, Components), ExpressionError> {
    let constants = in_box::with_constants(text, &source.parameters, sides, &[("n", particles as f64)])?;
    let mut expression = Expression::parse(text, &["x", "y", "z", "color"], &constants)?;
    let function = expression.value();
    if expression.is_zero(function) {
        return Ok((None, [const { None }; 3]));
    }
    let value = expression.tape(function)?;
    let mut gradient = [const { None }; 3];
    // Of a force, which may have kinks of any kind, nobody asks for the gradient.
    for (axis, slope) in gradient.iter_mut().enumerate().filter(|_| key == "response") {
        let function = expression.derivative(function, axis, 1.0);
        if !expression.is_zero(function) {
            *slope = Some(expression.tape(function)?);
        }
    }
    let has_color = text.contains("color");
    for color in if has_color { &[1.0, -1.0][..] } else { &[1.0] } {
        let of = if has_color { format!(" of color {color}") } else { String::new() };
        let at = |&[x, y, z]: &Vector| value.value(&[x, y, z, *color]);
        let slopes = |&[x, y, z]: &Vector| values(&gradient, &[x, y, z, *color]);
        in_box::check(text, sides, (&format!("{key}{of}"), &at), (&format!("slope of the {key}{of}"), &slopes))?;
    }
    Ok((Some(value), gradient))
}

fn values(components: &Components, variables: &[f64; 4]) -> Vector {
    components.each_ref().map(|tape| tape.as_ref().map_or(0.0, |tape| tape.value(variables)))
}

impl Forcing for ExpressionForcing {
    fn at(&self, particles: &Particles, k: usize) -> [Vector; 2] {
        let variables = self.variables(particles, k);
        let response = values(&self.response, &variables);
        [values(&self.force, &variables), response.map(|component| component * particles.inverse_mass[k])]
    }

    fn depends_on_positions(&self) -> bool {
        true
    }

    fn is_balanced(&self) -> bool {
        false
    }

    /// Σ_ab v_a v_b ∂(mG_a)/∂q_b.
    fn response_drift(&self, particles: &Particles, k: usize) -> f64 {
        let (variables, velocity) = (self.variables(particles, k), particles.velocity(k));
        let rates = self.gradients.each_ref().map(|gradient| dot(values(gradient, &variables), velocity));
        dot(rates, velocity)
    }

    fn check(&self, particles: usize) -> Result<(), ForcingError> {
        if particles < 2 {
            return Err(ForcingError::TooFewParticles { needed: 2, found: particles });
        }
        Ok(())
    }
}
