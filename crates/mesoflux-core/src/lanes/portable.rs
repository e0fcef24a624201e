//! Lanes as plain arrays: for machines without vector instructions, and the reference for the others.

use super::{Candidates, HalfWords, Lanes, Real, Row, RowLanes, SEARCH_WIDTH, SINGLE_WIDTH, Single, WIDTH, Words};
use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// Eight numbers in an array.
#[derive(Debug, Clone, Copy)]
pub struct Portable([f64; WIDTH]);

/// Eight words in an array.
#[derive(Debug, Clone, Copy)]
pub struct PortableWords([u64; WIDTH]);

/// Sixteen numbers in single precision in an array.
#[derive(Debug, Clone, Copy)]
pub struct PortableSingle([f32; SINGLE_WIDTH]);

/// Sixteen words of 32 bits in an array.
#[derive(Debug, Clone, Copy)]
pub struct PortableHalfWords([u32; SINGLE_WIDTH]);

/// An operator of two operands, lane by lane.
macro_rules! by_lane {
    ($type:ident, $trait:ident, $method:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|k| $trait::$method(self.0[k], other.0[k])))
            }
        }
    };
}
by_lane!(Portable, Add, add);
by_lane!(Portable, Sub, sub);
by_lane!(Portable, Mul, mul);
by_lane!(Portable, Div, div);
by_lane!(PortableWords, BitXor, bitxor);
by_lane!(PortableWords, BitAnd, bitand);
by_lane!(PortableWords, BitOr, bitor);
by_lane!(PortableSingle, Add, add);
by_lane!(PortableSingle, Sub, sub);
by_lane!(PortableSingle, Mul, mul);
by_lane!(PortableSingle, Div, div);
by_lane!(PortableHalfWords, BitAnd, bitand);

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Real for Portable {
    type Bits = PortableWords;
    type Mask = [bool; WIDTH];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(from_fn(|k| f64::mul_add(self.0[k], factor.0[k], term.0[k])))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        from_fn(|k| self.0[k] < other.0[k])
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(from_fn(|k| if mask[k] { yes.0[k] } else { no.0[k] }))
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        PortableWords(self.0.map(f64::to_bits))
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        Self(bits.0.map(f64::from_bits))
    }
}

impl Words for PortableWords {
    #[inline(always)]
    fn splat(value: u64) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].plus(other.0[k])))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].minus(other.0[k])))
    }

    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].low_product(other.0[k])))
    }

    #[inline(always)]
    fn shift_up<const BITS: u32>(self) -> Self {
        Self(self.0.map(|x| x << BITS))
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        Self(self.0.map(|x| x >> BITS))
    }
}

impl Single for PortableSingle {
    type Bits = PortableHalfWords;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; SINGLE_WIDTH])
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(from_fn(|k| f32::mul_add(self.0[k], factor.0[k], term.0[k])))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn from_integers(integers: Self::Bits) -> Self {
        Self(integers.0.map(f32::from_integers))
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        PortableHalfWords(self.0.map(f32::to_bits))
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        Self(bits.0.map(f32::from_bits))
    }
}

impl HalfWords for PortableHalfWords {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        Self([value; SINGLE_WIDTH])
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k].plus(other.0[k])))
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        Self(self.0.map(|x| x >> BITS))
    }
}

impl Lanes for Portable {
    type Single = PortableSingle;
    type Row = [f64; 4];
    type Candidates = PortableCandidates;

    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        *to = self.0;
    }

    #[inline(always)]
    unsafe fn load_rows(column: *const Row, places: &[u32; WIDTH]) -> [Self; 4] {
        // SAFETY: the caller's promise.
        let rows = places.map(|place| unsafe { (*column.add(place as usize)).0 });
        from_fn(|component| Self(rows.map(|row| row[component])))
    }

    #[inline(always)]
    fn sort_words(a: Self::Bits, b: Self::Bits) -> [Self::Bits; 2] {
        [PortableWords(from_fn(|k| a.0[k].min(b.0[k]))), PortableWords(from_fn(|k| a.0[k].max(b.0[k])))]
    }

    #[inline(always)]
    fn lower_halves(a: Self::Bits, b: Self::Bits) -> PortableHalfWords {
        PortableHalfWords(from_fn(|k| if k < WIDTH { a.0[k] as u32 } else { b.0[k - WIDTH] as u32 }))
    }

    #[inline(always)]
    fn widen(numbers: PortableSingle) -> [Self; 2] {
        [Self(from_fn(|k| f64::from(numbers.0[k]))), Self(from_fn(|k| f64::from(numbers.0[WIDTH + k])))]
    }

    #[inline(always)]
    fn of_kind(kinds: &[u16; WIDTH], kind: u16) -> Self::Mask {
        kinds.map(|other| other == kind)
    }

    #[inline(always)]
    fn rows([x, y, z]: [Self; 3], to: &mut [Row; WIDTH]) {
        for (k, row) in to.iter_mut().enumerate() {
            *row = Row([x.0[k], y.0[k], z.0[k], 0.0]);
        }
    }
}

/// Sixteen candidates in arrays.
#[derive(Debug, Clone, Copy)]
pub struct PortableCandidates {
    names: [u32; SEARCH_WIDTH],
    coordinates: [[f32; SEARCH_WIDTH]; 3],
}

impl Candidates for PortableCandidates {
    #[inline(always)]
    fn load(names: &[u32; SEARCH_WIDTH], coordinates: [&[f32; SEARCH_WIDTH]; 3]) -> Self {
        Self { names: *names, coordinates: coordinates.map(|column| *column) }
    }

    #[inline(always)]
    fn near(&self, point: [f32; 3], squared: f32) -> u32 {
        let mut mask = 0;
        for k in 0..SEARCH_WIDTH {
            let d: [f32; 3] = from_fn(|axis| point[axis] - self.coordinates[axis][k]);
            mask |= u32::from((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2] < squared) << k;
        }
        mask
    }

    #[inline(always)]
    fn near_rectangle(&self, low: [f32; 2], high: [f32; 2], squared: f32) -> u32 {
        let mut mask = 0;
        for k in 0..SEARCH_WIDTH {
            let [a, b] = from_fn(|axis| {
                let x = self.coordinates[axis + 1][k];
                (low[axis] - x).max(x - high[axis]).max(0.0)
            });
            mask |= u32::from(a * a + b * b < squared) << k;
        }
        mask
    }

    #[inline(always)]
    fn compress_coordinates(&self, mask: u32, to: [&mut [f32; SEARCH_WIDTH]; 3]) {
        for (to, from) in to.into_iter().zip(&self.coordinates) {
            let mut count = 0;
            for k in 0..SEARCH_WIDTH {
                // `count` is at most k, and below the width.
                to[count] = from[k];
                count += (mask >> k & 1) as usize;
            }
        }
    }

    #[inline(always)]
    fn compress(&self, mask: u32, to: &mut [u32; SEARCH_WIDTH]) {
        let mut count = 0;
        for k in 0..SEARCH_WIDTH {
            // `count` is at most k, and below the width.
            to[count] = self.names[k];
            count += (mask >> k & 1) as usize;
        }
    }
}

impl RowLanes for [f64; 4] {
    #[inline(always)]
    unsafe fn load(from: *const Row) -> Self {
        // SAFETY: the caller's promise.
        unsafe { (*from).0 }
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut Row) {
        // SAFETY: the caller's promise.
        unsafe { *to = Row(self) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        from_fn(|k| self[k] + other[k])
    }

    #[inline(always)]
    fn subtract(self, other: Self) -> Self {
        from_fn(|k| self[k] - other[k])
    }

    #[inline(always)]
    fn add_scaled(self, factor: f64, direction: Self) -> Self {
        from_fn(|k| f64::mul_add(factor, direction[k], self[k]))
    }

    #[inline(always)]
    fn dot(self, other: Self) -> f64 {
        let [x, y, z, w]: [f64; 4] = from_fn(|k| self[k] * other[k]);
        (x + z) + (y + w)
    }
}
