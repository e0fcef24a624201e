//! An external field that the user types.

use crate::boundary::PeriodicBox;
use crate::expression::{Expression, ExpressionError, Tape, in_box};
use crate::lanes::BlockNumbers;
use crate::vector::Vector;
use std::collections::BTreeMap;

/// u(x, y, z): the energy of a particle as an expression in its place in the box, 0 ≤ x < lx and so on; its force is minus the
/// exact gradient.
///
/// For example `a*cos(2*pi*x/lx)`; see [`crate::expression`] for the language.
#[derive(Debug, Clone)]
pub struct ExpressionField {
    energy: Tape,
    /// −∂u/∂x and so on; nothing along an axis on which the energy doesn't depend.
    force: [Option<Tape>; 3],
    /// ∇²u.
    laplacian: Tape,
}

impl ExpressionField {
    /// The field of an expression in x, y and z in a box, whose sides it may call `lx`, `ly` and `lz`, and parameters by name.
    ///
    /// # Errors
    /// A text that is no expression; an energy or force that isn't finite, or an energy that isn't periodic.
    pub fn new(text: &str, parameters: &BTreeMap<String, f64>, region: &PeriodicBox) -> Result<Self, ExpressionError> {
        let constants = in_box::with_constants(text, parameters, region.sides(), &[])?;
        let mut expression = Expression::parse(text, &["x", "y", "z"], &constants)?;
        let energy = expression.value();
        let mut force = [const { None }; 3];
        let mut laplacian = None;
        for (axis, tape) in force.iter_mut().enumerate() {
            let function = expression.derivative(energy, axis, -1.0);
            if !expression.is_zero(function) {
                *tape = Some(expression.tape(function)?);
            }
            let curvature = expression.derivative(function, axis, -1.0);
            laplacian = Some(laplacian.map_or(curvature, |sum| expression.sum(sum, curvature)));
        }
        let laplacian = expression.tape(laplacian.unwrap_or(energy))?;
        let field = Self { energy: expression.tape(energy)?, force, laplacian };
        let (energy, force) = (|place: &Vector| field.energy(place), |place: &Vector| field.force(place));
        in_box::check(text, region.sides(), ("energy", &energy), ("force", &force))?;
        Ok(field)
    }

    /// Along which axes it may push.
    pub fn pushes(&self) -> [bool; 3] {
        self.force.each_ref().map(Option::is_some)
    }

    /// u at a place in the box.
    pub fn energy(&self, place: &Vector) -> f64 {
        self.energy.value(place)
    }

    /// −∇u at a place in the box.
    pub fn force(&self, place: &Vector) -> Vector {
        self.force.each_ref().map(|tape| tape.as_ref().map_or(0.0, |tape| tape.value(place)))
    }

    /// ∇²u at a place in the box.
    pub fn laplacian(&self, place: &Vector) -> f64 {
        self.laplacian.value(place)
    }

    /// −∇u at a block of places in the box; components along which it doesn't push are left as they are.
    pub(super) fn fill(&self, streams: usize, places: &[BlockNumbers; 3], forces: &mut [BlockNumbers; 3]) {
        for (tape, force) in self.force.iter().zip(forces) {
            if let Some(tape) = tape {
                tape.fill(streams, places, force);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(energy: &str) -> Result<ExpressionField, ExpressionError> {
        let parameters = BTreeMap::from([("a".to_owned(), 0.7)]);
        let region = PeriodicBox::new([4.0, 5.0, 8.0]).unwrap();
        ExpressionField::new(energy, &parameters, &region)
    }

    #[test]
    fn force_and_laplacian_are_those_of_the_energy() {
        let field =
            field("a*cos(2*pi*x/lx)*sin(4*pi*y/ly) + exp(-((x - lx/2)^2 + (z - lz/2)^2)/0.2) + step(y - 6)*z").unwrap();
        assert_eq!(field.pushes(), [true; 3]);
        for k in 0..200 {
            let place = [0.021, 0.024, 0.037].map(|step| step * f64::from(k) + 0.1);
            let h = 1e-3;
            // Central differences of sixth order.
            let slope = |of: &dyn Fn(&Vector) -> f64, axis: usize| {
                let shifted = |steps: f64| {
                    let mut place = place;
                    place[axis] += steps * h;
                    of(&place)
                };
                let difference = |steps: f64| shifted(steps) - shifted(-steps);
                (45.0 * difference(1.0) - 9.0 * difference(2.0) + difference(3.0)) / (60.0 * h)
            };
            let mut laplacian = 0.0;
            for axis in 0..3 {
                let expected = -slope(&|place| field.energy(place), axis);
                assert!((field.force(&place)[axis] - expected).abs() < 1e-10, "force at {place:?}");
                laplacian -= slope(&|place| field.force(place)[axis], axis);
            }
            assert!((field.laplacian(&place) - laplacian).abs() < 1e-8, "Laplacian at {place:?}");
        }
    }

    #[test]
    fn a_field_pushes_only_where_its_energy_changes() {
        assert_eq!(field("a*sin(2*pi*z/lz)").unwrap().pushes(), [false, false, true]);
        assert_eq!(field("a").unwrap().pushes(), [false; 3]);
        // Zero at every sixteenth of the box.
        assert_eq!(field("a*sin(32*pi*z/lz)").unwrap().pushes(), [false, false, true]);
    }

    #[test]
    fn fields_that_jump_or_diverge_are_refused() {
        let refused = |energy: &str| field(energy).unwrap_err();
        assert_eq!(
            refused("a*z").to_string(),
            "must be the same on opposite faces of the box, but the energy jumps by -5.600e0 from z = 8 to z = 0 \
             (at x = 0, y = 0, z = 8)"
        );
        assert_eq!(
            refused("cos(2*pi*x/ly)").help.unwrap(),
            "the sides of the box are lx, ly, lz: cos(2*pi*x/lx) is periodic"
        );
        assert_eq!(refused("1/(z - 4)").to_string(), "must be finite, but at x = 0, y = 0, z = 4 the energy is inf");
        assert_eq!(refused("q + r").unknown.unwrap().name, "q");
        let parameters = BTreeMap::from([("lx".to_owned(), 0.7)]);
        let region = PeriodicBox::new([4.0, 5.0, 8.0]).unwrap();
        let error = ExpressionField::new("x", &parameters, &region).unwrap_err();
        assert_eq!(error.to_string(), "parameter lx: must have another name: this one has a meaning already");
    }
}
