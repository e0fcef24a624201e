//! Symmetric tensors of second rank, such as the stress, and the combinations of their components that viscosities need.

use crate::vector::Vector;
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Sub};

/// The components xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SymmetricTensor(pub [f64; 6]);

/// The two axes of each component.
pub const AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

impl SymmetricTensor {
    /// v_a v_b
    #[inline(always)]
    pub fn square(v: Vector) -> Self {
        Self(AXES.map(|[a, b]| v[a] * v[b]))
    }

    /// The component of two axes, 0 to 2 for x to z.
    pub fn component(&self, a: usize, b: usize) -> f64 {
        self.0[if a == b { a } else { a + b + 2 }]
    }

    /// xx + yy + zz.
    pub fn trace(&self) -> f64 {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// The five independent components of the traceless part: xy, xz, yz, (xx − yy)/2, (xx + yy − 2zz)/(2√3).
    ///
    /// Normalized so that in an isotropic fluid all five have the same correlations: an isotropic tensor of fourth rank has
    /// C_xxxx − C_xxyy = 2 C_xyxy, whence ⟨(xx − yy)²⟩/4 = ⟨(xx + yy − 2zz)²⟩/12 = ⟨xy²⟩.
    pub fn shear(&self) -> [f64; 5] {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        [xy, xz, yz, 0.5 * (xx - yy), (xx + yy - 2.0 * zz) / 12.0_f64.sqrt()]
    }
}

impl Add for SymmetricTensor {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl AddAssign for SymmetricTensor {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for SymmetricTensor {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul<SymmetricTensor> for f64 {
    type Output = SymmetricTensor;
    fn mul(self, tensor: SymmetricTensor) -> SymmetricTensor {
        SymmetricTensor(tensor.0.map(|component| self * component))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_those_of_their_axes() {
        let v = [2.0, 3.0, 5.0];
        let tensor = SymmetricTensor::square(v);
        for a in 0..3 {
            for b in 0..3 {
                assert_eq!(tensor.component(a, b), v[a] * v[b]);
            }
        }
        assert_eq!(tensor.trace(), 38.0);
    }

    /// Half the squared norm of the traceless part, whatever the direction: the five are an orthogonal basis of equal norms.
    #[test]
    fn the_five_shear_components_have_equal_norms() {
        for e in [[1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.48, 0.6, 0.64], [-0.48, 0.64, 0.6]] {
            let squares: f64 = SymmetricTensor::square(e).shear().iter().map(|component| component * component).sum();
            assert!((squares - 1.0 / 3.0).abs() < 1e-15, "{e:?}: {squares}");
        }
    }
}
