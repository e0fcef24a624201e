//! Lanes in the registers of AVX-512.
//!
//! Every function here is called only inside `InstructionSet::run` with this set, which was detected on the machine: that is
//! why its instructions may be used.

use super::avx2::RowAvx;
use super::{Candidates, HalfWords, Lanes, Real, Row, SEARCH_WIDTH, Single, WIDTH, Words};
#[allow(clippy::wildcard_imports, reason = "dozens of names that begin alike and mean one thing each")]
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// Eight numbers in a register.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(__m512d);

/// Eight words in a register.
#[derive(Debug, Clone, Copy)]
pub struct Words512(__m512i);

/// Sixteen numbers in single precision in a register.
#[derive(Debug, Clone, Copy)]
pub struct Single512(__m512);

/// Sixteen words of 32 bits in a register.
#[derive(Debug, Clone, Copy)]
pub struct HalfWords512(__m512i);

/// An operator that is one instruction.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: AVX-512 is there.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}
operator!(Avx512, Add, add, _mm512_add_pd);
operator!(Avx512, Sub, sub, _mm512_sub_pd);
operator!(Avx512, Mul, mul, _mm512_mul_pd);
operator!(Avx512, Div, div, _mm512_div_pd);
operator!(Words512, BitXor, bitxor, _mm512_xor_si512);
operator!(Words512, BitAnd, bitand, _mm512_and_si512);
operator!(Words512, BitOr, bitor, _mm512_or_si512);
operator!(Single512, Add, add, _mm512_add_ps);
operator!(Single512, Sub, sub, _mm512_sub_ps);
operator!(Single512, Mul, mul, _mm512_mul_ps);
operator!(Single512, Div, div, _mm512_div_ps);
operator!(HalfWords512, BitAnd, bitand, _mm512_and_si512);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Real for Avx512 {
    type Bits = Words512;
    type Mask = __mmask8;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        // SAFETY: AVX-512 is there.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        // SAFETY: AVX-512 is there.
        Words512(unsafe { _mm512_castpd_si512(self.0) })
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_castsi512_pd(bits.0) })
    }
}

impl Words for Words512 {
    #[inline(always)]
    fn splat(value: u64) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_set1_epi64(value as i64) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_add_epi64(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_sub_epi64(self.0, other.0) })
    }

    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_mul_epu32(self.0, other.0) })
    }

    #[inline(always)]
    fn shift_up<const BITS: u32>(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_slli_epi64::<BITS>(self.0) })
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_srli_epi64::<BITS>(self.0) })
    }
}

impl Single for Single512 {
    type Bits = HalfWords512;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_set1_ps(value) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_fmadd_ps(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn from_integers(integers: Self::Bits) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_cvtepi32_ps(integers.0) })
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        // SAFETY: AVX-512 is there.
        HalfWords512(unsafe { _mm512_castps_si512(self.0) })
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_castsi512_ps(bits.0) })
    }
}

impl HalfWords for HalfWords512 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_set1_epi32(value.cast_signed()) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_add_epi32(self.0, other.0) })
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        // SAFETY: AVX-512 is there.
        Self(unsafe { _mm512_srli_epi32::<BITS>(self.0) })
    }
}

/// Index that joins the quarters 0 of two registers, then their quarters 2.
#[inline(always)]
fn even_quarters() -> __m512i {
    // SAFETY: AVX-512 is there.
    unsafe { _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13) }
}

/// Index that joins the quarters 1 of two registers, then their quarters 3.
#[inline(always)]
fn odd_quarters() -> __m512i {
    // SAFETY: AVX-512 is there.
    unsafe { _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15) }
}

impl Lanes for Avx512 {
    type Single = Single512;
    type Row = RowAvx;
    type Candidates = Candidates512;

    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        // SAFETY: AVX-512 is there; eight numbers are loaded from an array of eight.
        Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        // SAFETY: AVX-512 is there; eight numbers are stored to an array of eight.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    unsafe fn load_rows(column: *const Row, places: &[u32; WIDTH]) -> [Self; 4] {
        // SAFETY: AVX-512 is there; the caller promises that every place lies inside the column; rows are aligned.
        unsafe {
            let place = |k: usize| -> *const f64 { column.add(places[k] as usize).cast() };
            let places = [place(0), place(1), place(2), place(3), place(4), place(5), place(6), place(7)];
            let mut rows = [_mm512_setzero_pd(); 4];
            for k in 0..4 {
                // Rows k and k + 4, one in each half.
                let low = _mm512_castpd256_pd512(_mm256_load_pd(places[k]));
                rows[k] = _mm512_insertf64x4::<1>(low, _mm256_load_pd(places[k + 4]));
            }
            // Quarters: x of rows k and k + 1, z of them, and the same for the rows four further on; y and w likewise.
            let (xz_0, xz_2) = (_mm512_unpacklo_pd(rows[0], rows[1]), _mm512_unpacklo_pd(rows[2], rows[3]));
            let (yw_0, yw_2) = (_mm512_unpackhi_pd(rows[0], rows[1]), _mm512_unpackhi_pd(rows[2], rows[3]));
            let (low, high) = (even_quarters(), odd_quarters());
            [
                Self(_mm512_permutex2var_pd(xz_0, low, xz_2)),
                Self(_mm512_permutex2var_pd(yw_0, low, yw_2)),
                Self(_mm512_permutex2var_pd(xz_0, high, xz_2)),
                Self(_mm512_permutex2var_pd(yw_0, high, yw_2)),
            ]
        }
    }

    #[inline(always)]
    fn sort_words(a: Self::Bits, b: Self::Bits) -> [Self::Bits; 2] {
        // SAFETY: AVX-512 is there.
        unsafe { [Words512(_mm512_min_epu64(a.0, b.0)), Words512(_mm512_max_epu64(a.0, b.0))] }
    }

    #[inline(always)]
    fn lower_halves(a: Self::Bits, b: Self::Bits) -> HalfWords512 {
        // SAFETY: AVX-512 is there.
        unsafe {
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            HalfWords512(_mm512_permutex2var_epi32(a.0, even, b.0))
        }
    }

    #[inline(always)]
    fn widen(numbers: Single512) -> [Self; 2] {
        // SAFETY: AVX-512 is there.
        unsafe {
            let (first, second) = (_mm512_castps512_ps256(numbers.0), _mm512_extractf32x8_ps::<1>(numbers.0));
            [Self(_mm512_cvtps_pd(first)), Self(_mm512_cvtps_pd(second))]
        }
    }

    #[inline(always)]
    fn of_kind(kinds: &[u16; WIDTH], kind: u16) -> Self::Mask {
        // SAFETY: AVX-512 is there; eight kinds are loaded from an array of eight.
        unsafe { _mm_cmpeq_epi16_mask(_mm_loadu_si128(kinds.as_ptr().cast()), _mm_set1_epi16(kind as i16)) }
    }

    #[inline(always)]
    fn rows([x, y, z]: [Self; 3], to: &mut [Row; WIDTH]) {
        // SAFETY: AVX-512 is there; each of the four stores covers two of the eight rows.
        unsafe {
            let zero = _mm512_setzero_pd();
            // In each quarter of the register: x_a y_a, x_b y_b, z_a 0, z_b 0.
            let (xy_even, xy_odd) = (_mm512_unpacklo_pd(x.0, y.0), _mm512_unpackhi_pd(x.0, y.0));
            let (z_even, z_odd) = (_mm512_unpacklo_pd(z.0, zero), _mm512_unpackhi_pd(z.0, zero));
            let (low, high) = (even_quarters(), odd_quarters());
            let (rows_0_4, rows_2_6) =
                (_mm512_permutex2var_pd(xy_even, low, z_even), _mm512_permutex2var_pd(xy_even, high, z_even));
            let (rows_1_5, rows_3_7) =
                (_mm512_permutex2var_pd(xy_odd, low, z_odd), _mm512_permutex2var_pd(xy_odd, high, z_odd));
            let start = to.as_mut_ptr();
            let rows = [rows_0_4, rows_1_5, rows_2_6, rows_3_7];
            for k in 0..4 {
                _mm256_store_pd(start.add(k).cast(), _mm512_castpd512_pd256(rows[k]));
                _mm256_store_pd(start.add(k + 4).cast(), _mm512_extractf64x4_pd::<1>(rows[k]));
            }
        }
    }
}

/// Sixteen candidates in four registers.
#[derive(Debug, Clone, Copy)]
pub struct Candidates512 {
    names: __m512i,
    coordinates: [__m512; 3],
}

impl Candidates for Candidates512 {
    #[inline(always)]
    fn load(names: &[u32; SEARCH_WIDTH], [x, y, z]: [&[f32; SEARCH_WIDTH]; 3]) -> Self {
        // SAFETY: AVX-512 is there; sixteen words are loaded from arrays of sixteen.
        unsafe {
            Self {
                names: _mm512_loadu_si512(names.as_ptr().cast()),
                coordinates: [_mm512_loadu_ps(x.as_ptr()), _mm512_loadu_ps(y.as_ptr()), _mm512_loadu_ps(z.as_ptr())],
            }
        }
    }

    #[inline(always)]
    fn near(&self, point: [f32; 3], squared: f32) -> u32 {
        // SAFETY: AVX-512 is there.
        unsafe {
            let x = _mm512_sub_ps(_mm512_set1_ps(point[0]), self.coordinates[0]);
            let y = _mm512_sub_ps(_mm512_set1_ps(point[1]), self.coordinates[1]);
            let z = _mm512_sub_ps(_mm512_set1_ps(point[2]), self.coordinates[2]);
            let sum = _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(x, x), _mm512_mul_ps(y, y)), _mm512_mul_ps(z, z));
            u32::from(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(sum, _mm512_set1_ps(squared)))
        }
    }

    #[inline(always)]
    fn near_rectangle(&self, low: [f32; 2], high: [f32; 2], squared: f32) -> u32 {
        // SAFETY: AVX-512 is there.
        unsafe {
            let mut squares = [_mm512_setzero_ps(); 2];
            for axis in 0..2 {
                let x = self.coordinates[axis + 1];
                let (below, above) =
                    (_mm512_sub_ps(_mm512_set1_ps(low[axis]), x), _mm512_sub_ps(x, _mm512_set1_ps(high[axis])));
                let distance = _mm512_max_ps(_mm512_max_ps(below, above), _mm512_setzero_ps());
                squares[axis] = _mm512_mul_ps(distance, distance);
            }
            let sum = _mm512_add_ps(squares[0], squares[1]);
            u32::from(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(sum, _mm512_set1_ps(squared)))
        }
    }

    #[inline(always)]
    fn compress_coordinates(&self, mask: u32, to: [&mut [f32; SEARCH_WIDTH]; 3]) {
        let [x, y, z] = to;
        // SAFETY: AVX-512 is there; sixteen numbers are stored to each array of sixteen.
        unsafe {
            _mm512_storeu_ps(x.as_mut_ptr(), _mm512_maskz_compress_ps(mask as u16, self.coordinates[0]));
            _mm512_storeu_ps(y.as_mut_ptr(), _mm512_maskz_compress_ps(mask as u16, self.coordinates[1]));
            _mm512_storeu_ps(z.as_mut_ptr(), _mm512_maskz_compress_ps(mask as u16, self.coordinates[2]));
        }
    }

    #[inline(always)]
    fn compress(&self, mask: u32, to: &mut [u32; SEARCH_WIDTH]) {
        // SAFETY: AVX-512 is there; sixteen words are stored to an array of sixteen.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(mask as u16, self.names)) }
    }
}
