//! Single precision: sixteen numbers where double precision has eight.

use std::ops::{Add, BitAnd, Div, Mul, Sub};

/// A real number in single precision, or sixteen of them that are worked on together.
pub trait Single: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// The numbers' bits, and integers.
    type Bits: HalfWords;

    /// The same number everywhere.
    fn splat(value: f32) -> Self;
    /// self · factor + term, rounded once.
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The square root, rounded once.
    #[must_use]
    fn sqrt(self) -> Self;
    /// The integers with a sign as numbers, rounded once.
    fn from_integers(integers: Self::Bits) -> Self;
    /// The bits of the numbers.
    fn to_bits(self) -> Self::Bits;
    /// The numbers with these bits.
    fn from_bits(bits: Self::Bits) -> Self;

    /// The value of a polynomial with the given coefficients, the highest power first.
    #[must_use]
    #[inline(always)]
    fn polynomial(self, coefficients: &[f32]) -> Self {
        let mut value = Self::splat(coefficients[0]);
        for &coefficient in &coefficients[1..] {
            value = value.mul_add(self, Self::splat(coefficient));
        }
        value
    }
}

/// Words of 32 bits.
pub trait HalfWords: Copy + BitAnd<Output = Self> {
    /// The same word everywhere.
    fn splat(value: u32) -> Self;
    /// Sum modulo 2³².
    #[must_use]
    fn plus(self, other: Self) -> Self;
    /// Towards the lower bits.
    #[must_use]
    fn shift_down<const BITS: u32>(self) -> Self;
}

impl Single for f32 {
    type Bits = u32;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f32::mul_add(self, factor, term)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn from_integers(integers: u32) -> Self {
        integers.cast_signed() as f32
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }
}

impl HalfWords for u32 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        value
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        self >> BITS
    }
}
