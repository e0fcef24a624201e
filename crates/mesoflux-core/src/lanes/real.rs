//! One number or several: what the laws and the elementary functions are written over.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// A real number in double precision, or a row of them that are worked on together.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The numbers' bits.
    type Bits: Words;
    /// For each number yes or no.
    type Mask: Copy;

    /// The same number everywhere.
    fn splat(value: f64) -> Self;
    /// self · factor + term, rounded once.
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The square root, rounded once.
    #[must_use]
    fn sqrt(self) -> Self;
    /// self < other; no where either is no number.
    fn below(self, other: Self) -> Self::Mask;
    /// `yes` where the mask says so, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The bits of the numbers.
    fn to_bits(self) -> Self::Bits;
    /// The numbers with these bits.
    fn from_bits(bits: Self::Bits) -> Self;

    /// The value of a polynomial with the given coefficients, at least two, the highest power first.
    ///
    /// Even and odd powers form two chains, each half as long as one would be, that a processor works on at the same time.
    #[must_use]
    #[inline(always)]
    fn polynomial(self, coefficients: &[f64]) -> Self {
        let square = self * self;
        let mut chains = [Self::splat(coefficients[0]), Self::splat(coefficients[1])];
        for k in 2..coefficients.len() {
            chains[k % 2] = chains[k % 2].mul_add(square, Self::splat(coefficients[k]));
        }
        let [even, odd] = if coefficients.len().is_multiple_of(2) { [chains[1], chains[0]] } else { chains };
        odd.mul_add(self, even)
    }
}

/// Words of 64 bits.
pub trait Words: Copy + BitXor<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// The same word everywhere.
    fn splat(value: u64) -> Self;
    /// Sum modulo 2⁶⁴.
    #[must_use]
    fn plus(self, other: Self) -> Self;
    /// Difference modulo 2⁶⁴.
    #[must_use]
    fn minus(self, other: Self) -> Self;
    /// The product of the lower halves.
    #[must_use]
    fn low_product(self, other: Self) -> Self;
    /// Towards the higher bits.
    #[must_use]
    fn shift_up<const BITS: u32>(self) -> Self;
    /// Towards the lower bits.
    #[must_use]
    fn shift_down<const BITS: u32>(self) -> Self;
}

impl Real for f64 {
    type Bits = u64;
    type Mask = bool;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f64::mul_add(self, factor, term)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn to_bits(self) -> u64 {
        f64::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u64) -> Self {
        f64::from_bits(bits)
    }
}

impl Words for u64 {
    #[inline(always)]
    fn splat(value: u64) -> Self {
        value
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }

    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        u64::from(self as u32) * u64::from(other as u32)
    }

    #[inline(always)]
    fn shift_up<const BITS: u32>(self) -> Self {
        self << BITS
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        self >> BITS
    }
}
