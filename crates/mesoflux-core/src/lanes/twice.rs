//! Two at a time: while one waits for a result, the other goes on.

use super::{Real, Words};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// Two of the same kind, every operation done with both.
///
/// A processor hides the waiting time of long chains of operations only as far as it looks ahead; where a chain is longer, two
/// that are woven into each other take hardly longer than one.
#[derive(Debug, Clone, Copy)]
pub struct Twice<T>(pub T, pub T);

/// An operator done with both.
macro_rules! both {
    ($trait:ident, $method:ident) => {
        impl<T: $trait<Output = T>> $trait for Twice<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    };
}
both!(Add, add);
both!(Sub, sub);
both!(Mul, mul);
both!(Div, div);
both!(BitXor, bitxor);
both!(BitAnd, bitand);
both!(BitOr, bitor);

impl<T: Neg<Output = T>> Neg for Twice<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<R: Real> Real for Twice<R> {
    type Bits = Twice<R::Bits>;
    type Mask = (R::Mask, R::Mask);

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(R::splat(value), R::splat(value))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0), self.1.mul_add(factor.1, term.1))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        (self.0.below(other.0), self.1.below(other.1))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(R::select(mask.0, yes.0, no.0), R::select(mask.1, yes.1, no.1))
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        Twice(self.0.to_bits(), self.1.to_bits())
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        Self(R::from_bits(bits.0), R::from_bits(bits.1))
    }
}

impl<W: Words> Words for Twice<W> {
    #[inline(always)]
    fn splat(value: u64) -> Self {
        Self(W::splat(value), W::splat(value))
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(self.0.plus(other.0), self.1.plus(other.1))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0.minus(other.0), self.1.minus(other.1))
    }

    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        Self(self.0.low_product(other.0), self.1.low_product(other.1))
    }

    #[inline(always)]
    fn shift_up<const BITS: u32>(self) -> Self {
        Self(self.0.shift_up::<BITS>(), self.1.shift_up::<BITS>())
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        Self(self.0.shift_down::<BITS>(), self.1.shift_down::<BITS>())
    }
}
