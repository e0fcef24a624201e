//! Three-component vectors: plain arrays and the four operations on them that the physics needs.

/// A vector in three dimensions, components x, y, z.
pub type Vector = [f64; 3];

/// The zero vector.
pub const ZERO: Vector = [0.0; 3];

/// a · b
#[inline(always)]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a − b
#[inline(always)]
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a × b
#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// target += factor · v
#[inline(always)]
pub fn add_scaled(target: &mut Vector, factor: f64, v: Vector) {
    target[0] += factor * v[0];
    target[1] += factor * v[1];
    target[2] += factor * v[2];
}
