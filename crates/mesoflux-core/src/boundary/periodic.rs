//! The periodic orthorhombic box.

use crate::vector::Vector;
use serde::{Deserialize, Serialize};

/// An orthorhombic box, periodic in all three directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeriodicBox {
    sides: Vector,
}

/// A box that can't be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("side {axis} of the box is {value}: must be positive and finite")]
pub struct BoxError {
    /// x, y or z.
    pub axis: char,
    /// The side that was given.
    pub value: f64,
}

impl PeriodicBox {
    /// A box with the given sides along x, y, z.
    ///
    /// # Errors
    /// A side that is not positive and finite.
    pub fn new(sides: Vector) -> Result<Self, BoxError> {
        for (axis, value) in "xyz".chars().zip(sides) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BoxError { axis, value });
            }
        }
        Ok(Self { sides })
    }

    /// The sides along x, y, z.
    pub fn sides(&self) -> Vector {
        self.sides
    }

    /// The shortest side.
    pub fn shortest_side(&self) -> f64 {
        self.sides.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The volume L_x L_y L_z.
    pub fn volume(&self) -> f64 {
        self.sides.iter().product()
    }

    /// Brings a position into the box and counts the crossings, so that position + image · side stays what it was.
    pub fn wrap(&self, position: &mut Vector, crossings: &mut [i32; 3]) {
        for axis in 0..3 {
            let side = self.sides[axis];
            let copies = (position[axis] / side).floor();
            let mut wrapped = position[axis] - copies * side;
            let mut count = copies as i32;
            // Rounding may leave the upper face itself, which belongs to the next copy.
            if wrapped >= side {
                wrapped = 0.0;
                count += 1;
            } else if wrapped < 0.0 {
                wrapped = 0.0;
            }
            position[axis] = wrapped;
            crossings[axis] += count;
        }
    }

    /// The difference of two positions taken to its nearest image; that of −d is exactly the opposite.
    #[inline(always)]
    pub fn nearest_image(&self, d: Vector) -> Vector {
        std::array::from_fn(|axis| d[axis] - self.sides[axis] * (d[axis] / self.sides[axis]).round())
    }

    /// A position followed through all its crossings.
    pub fn unwrap(&self, position: Vector, crossings: [i32; 3]) -> Vector {
        std::array::from_fn(|axis| position[axis] + f64::from(crossings[axis]) * self.sides[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn wrapping_keeps_the_followed_position(x in -1e3..1e3, y in -30.0..30.0, z in -1e-18..1e-18) {
            let region = PeriodicBox::new([3.0, 7.5, 1.25]).unwrap();
            let (mut position, mut crossings) = ([x, y, z], [0; 3]);
            region.wrap(&mut position, &mut crossings);
            let followed = region.unwrap(position, crossings);
            for axis in 0..3 {
                prop_assert!(position[axis] >= 0.0 && position[axis] < region.sides()[axis]);
                prop_assert!((followed[axis] - [x, y, z][axis]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn impossible_sides_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(PeriodicBox::new([1.0, bad, 1.0]).is_err());
        }
    }
}
