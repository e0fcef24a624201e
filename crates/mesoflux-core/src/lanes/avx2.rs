//! Lanes in two registers of AVX2 each, with FMA; and a row in one, which AVX-512 uses too.
//!
//! Every function here is called only inside `InstructionSet::run` with a set that has AVX2 and FMA and was detected on the
//! machine: that is why their instructions may be used.

use super::{Candidates, HalfWords, Lanes, Real, Row, RowLanes, SEARCH_WIDTH, Single, WIDTH, Words};
#[allow(clippy::wildcard_imports, reason = "dozens of names that begin alike and mean one thing each")]
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// Eight numbers in two registers.
#[derive(Debug, Clone, Copy)]
pub struct Avx2([__m256d; 2]);

/// Eight words in two registers.
#[derive(Debug, Clone, Copy)]
pub struct Words2([__m256i; 2]);

/// Sixteen numbers in single precision in two registers.
#[derive(Debug, Clone, Copy)]
pub struct Single2([__m256; 2]);

/// Sixteen words of 32 bits in two registers.
#[derive(Debug, Clone, Copy)]
pub struct HalfWords2([__m256i; 2]);

/// An operator that is one instruction for each half.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: AVX2 is there.
                Self(unsafe { [$instruction(self.0[0], other.0[0]), $instruction(self.0[1], other.0[1])] })
            }
        }
    };
}
operator!(Avx2, Add, add, _mm256_add_pd);
operator!(Avx2, Sub, sub, _mm256_sub_pd);
operator!(Avx2, Mul, mul, _mm256_mul_pd);
operator!(Avx2, Div, div, _mm256_div_pd);
operator!(Words2, BitXor, bitxor, _mm256_xor_si256);
operator!(Words2, BitAnd, bitand, _mm256_and_si256);
operator!(Words2, BitOr, bitor, _mm256_or_si256);
operator!(Single2, Add, add, _mm256_add_ps);
operator!(Single2, Sub, sub, _mm256_sub_ps);
operator!(Single2, Mul, mul, _mm256_mul_ps);
operator!(Single2, Div, div, _mm256_div_ps);
operator!(HalfWords2, BitAnd, bitand, _mm256_and_si256);

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe {
            [_mm256_xor_pd(self.0[0], _mm256_set1_pd(-0.0)), _mm256_xor_pd(self.0[1], _mm256_set1_pd(-0.0))]
        })
    }
}

impl Real for Avx2 {
    type Bits = Words2;
    /// All bits set or none in each lane.
    type Mask = [__m256d; 2];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: AVX2 is there.
        Self([unsafe { _mm256_set1_pd(value) }; 2])
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: FMA is there.
        Self(unsafe {
            [_mm256_fmadd_pd(self.0[0], factor.0[0], term.0[0]), _mm256_fmadd_pd(self.0[1], factor.0[1], term.0[1])]
        })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_sqrt_pd(self.0[0]), _mm256_sqrt_pd(self.0[1])] })
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        // SAFETY: AVX2 is there.
        unsafe {
            [_mm256_cmp_pd::<_CMP_LT_OQ>(self.0[0], other.0[0]), _mm256_cmp_pd::<_CMP_LT_OQ>(self.0[1], other.0[1])]
        }
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_blendv_pd(no.0[0], yes.0[0], mask[0]), _mm256_blendv_pd(no.0[1], yes.0[1], mask[1])] })
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        // SAFETY: AVX2 is there.
        Words2(unsafe { [_mm256_castpd_si256(self.0[0]), _mm256_castpd_si256(self.0[1])] })
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_castsi256_pd(bits.0[0]), _mm256_castsi256_pd(bits.0[1])] })
    }
}

impl Words for Words2 {
    #[inline(always)]
    fn splat(value: u64) -> Self {
        // SAFETY: AVX2 is there.
        Self([unsafe { _mm256_set1_epi64x(value as i64) }; 2])
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_add_epi64(self.0[0], other.0[0]), _mm256_add_epi64(self.0[1], other.0[1])] })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_sub_epi64(self.0[0], other.0[0]), _mm256_sub_epi64(self.0[1], other.0[1])] })
    }

    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_mul_epu32(self.0[0], other.0[0]), _mm256_mul_epu32(self.0[1], other.0[1])] })
    }

    #[inline(always)]
    fn shift_up<const BITS: u32>(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe {
            [
                _mm256_sll_epi64(self.0[0], _mm_cvtsi32_si128(BITS as i32)),
                _mm256_sll_epi64(self.0[1], _mm_cvtsi32_si128(BITS as i32)),
            ]
        })
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe {
            [
                _mm256_srl_epi64(self.0[0], _mm_cvtsi32_si128(BITS as i32)),
                _mm256_srl_epi64(self.0[1], _mm_cvtsi32_si128(BITS as i32)),
            ]
        })
    }
}

impl Single for Single2 {
    type Bits = HalfWords2;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX2 is there.
        Self([unsafe { _mm256_set1_ps(value) }; 2])
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: FMA is there.
        Self(unsafe {
            [_mm256_fmadd_ps(self.0[0], factor.0[0], term.0[0]), _mm256_fmadd_ps(self.0[1], factor.0[1], term.0[1])]
        })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_sqrt_ps(self.0[0]), _mm256_sqrt_ps(self.0[1])] })
    }

    #[inline(always)]
    fn from_integers(integers: Self::Bits) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_cvtepi32_ps(integers.0[0]), _mm256_cvtepi32_ps(integers.0[1])] })
    }

    #[inline(always)]
    fn to_bits(self) -> Self::Bits {
        // SAFETY: AVX2 is there.
        HalfWords2(unsafe { [_mm256_castps_si256(self.0[0]), _mm256_castps_si256(self.0[1])] })
    }

    #[inline(always)]
    fn from_bits(bits: Self::Bits) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_castsi256_ps(bits.0[0]), _mm256_castsi256_ps(bits.0[1])] })
    }
}

impl HalfWords for HalfWords2 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        // SAFETY: AVX2 is there.
        Self([unsafe { _mm256_set1_epi32(value.cast_signed()) }; 2])
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe { [_mm256_add_epi32(self.0[0], other.0[0]), _mm256_add_epi32(self.0[1], other.0[1])] })
    }

    #[inline(always)]
    fn shift_down<const BITS: u32>(self) -> Self {
        // SAFETY: AVX2 is there.
        Self(unsafe {
            [
                _mm256_srl_epi32(self.0[0], _mm_cvtsi32_si128(BITS as i32)),
                _mm256_srl_epi32(self.0[1], _mm_cvtsi32_si128(BITS as i32)),
            ]
        })
    }
}

/// The lower halves of eight words in two registers.
#[inline(always)]
fn lower_halves(words: Words2) -> __m256i {
    // SAFETY: AVX2 is there.
    unsafe {
        let [a, b] = [_mm256_castsi256_ps(words.0[0]), _mm256_castsi256_ps(words.0[1])];
        // Of words 0, 1, 4, 5, 2, 3, 6, 7.
        let even = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
        _mm256_permute4x64_epi64::<0b11_01_10_00>(even)
    }
}

impl Lanes for Avx2 {
    type Single = Single2;
    type Row = RowAvx;
    type Candidates = Candidates2;

    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        // SAFETY: AVX2 is there; eight numbers are loaded from an array of eight.
        Self(unsafe { [_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))] })
    }

    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        // SAFETY: AVX2 is there; eight numbers are stored to an array of eight.
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0[0]);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.0[1]);
        }
    }

    #[inline(always)]
    unsafe fn load_rows(column: *const Row, places: &[u32; WIDTH]) -> [Self; 4] {
        let mut lanes = [Self::splat(0.0); 4];
        for half in 0..2 {
            // SAFETY: AVX2 is there; the caller promises that every place lies inside the column; rows are aligned.
            unsafe {
                let mut rows = [_mm256_setzero_pd(); 4];
                for k in 0..4 {
                    rows[k] = _mm256_load_pd(column.add(places[4 * half + k] as usize).cast());
                }
                let (xz_0, xz_2) = (_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3]));
                let (yw_0, yw_2) = (_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3]));
                lanes[0].0[half] = _mm256_permute2f128_pd::<0x20>(xz_0, xz_2);
                lanes[1].0[half] = _mm256_permute2f128_pd::<0x20>(yw_0, yw_2);
                lanes[2].0[half] = _mm256_permute2f128_pd::<0x31>(xz_0, xz_2);
                lanes[3].0[half] = _mm256_permute2f128_pd::<0x31>(yw_0, yw_2);
            }
        }
        lanes
    }

    #[inline(always)]
    fn sort_words(a: Self::Bits, b: Self::Bits) -> [Self::Bits; 2] {
        // SAFETY: AVX2 is there. The words are below 2⁶³, so that a comparison with sign is right.
        unsafe {
            let larger = [_mm256_cmpgt_epi64(a.0[0], b.0[0]), _mm256_cmpgt_epi64(a.0[1], b.0[1])];
            let [mut low, mut high] = [a; 2];
            for k in 0..2 {
                low.0[k] = _mm256_blendv_epi8(a.0[k], b.0[k], larger[k]);
                high.0[k] = _mm256_blendv_epi8(b.0[k], a.0[k], larger[k]);
            }
            [low, high]
        }
    }

    #[inline(always)]
    fn lower_halves(a: Self::Bits, b: Self::Bits) -> HalfWords2 {
        HalfWords2([lower_halves(a), lower_halves(b)])
    }

    #[inline(always)]
    fn widen(numbers: Single2) -> [Self; 2] {
        let mut wide = [Self::splat(0.0); 2];
        for half in 0..2 {
            // SAFETY: AVX2 is there.
            unsafe {
                let (lower, upper) =
                    (_mm256_castps256_ps128(numbers.0[half]), _mm256_extractf128_ps::<1>(numbers.0[half]));
                wide[half] = Self([_mm256_cvtps_pd(lower), _mm256_cvtps_pd(upper)]);
            }
        }
        wide
    }

    #[inline(always)]
    fn of_kind(kinds: &[u16; WIDTH], kind: u16) -> Self::Mask {
        // SAFETY: AVX2 is there; eight kinds are loaded from an array of eight.
        unsafe {
            let equal = _mm_cmpeq_epi16(_mm_loadu_si128(kinds.as_ptr().cast()), _mm_set1_epi16(kind as i16));
            let upper = _mm_unpackhi_epi64(equal, equal);
            [_mm256_castsi256_pd(_mm256_cvtepi16_epi64(equal)), _mm256_castsi256_pd(_mm256_cvtepi16_epi64(upper))]
        }
    }

    #[inline(always)]
    fn rows([x, y, z]: [Self; 3], to: &mut [Row; WIDTH]) {
        for half in 0..2 {
            let (x, y, z) = (x.0[half], y.0[half], z.0[half]);
            // SAFETY: AVX2 is there; each of the eight stores covers one row, which is aligned.
            unsafe {
                let zero = _mm256_setzero_pd();
                let (xy_even, xy_odd) = (_mm256_unpacklo_pd(x, y), _mm256_unpackhi_pd(x, y));
                let (z_even, z_odd) = (_mm256_unpacklo_pd(z, zero), _mm256_unpackhi_pd(z, zero));
                let rows = [
                    _mm256_permute2f128_pd::<0x20>(xy_even, z_even),
                    _mm256_permute2f128_pd::<0x20>(xy_odd, z_odd),
                    _mm256_permute2f128_pd::<0x31>(xy_even, z_even),
                    _mm256_permute2f128_pd::<0x31>(xy_odd, z_odd),
                ];
                for (k, row) in rows.into_iter().enumerate() {
                    _mm256_store_pd(to[4 * half + k].0.as_mut_ptr(), row);
                }
            }
        }
    }
}

/// Sixteen candidates in eight registers.
#[derive(Debug, Clone, Copy)]
pub struct Candidates2 {
    names: [__m256i; 2],
    coordinates: [[__m256; 2]; 3],
}

impl Candidates for Candidates2 {
    #[inline(always)]
    fn load(names: &[u32; SEARCH_WIDTH], coordinates: [&[f32; SEARCH_WIDTH]; 3]) -> Self {
        // SAFETY: AVX2 is there; eight words are loaded from each half of arrays of sixteen.
        unsafe {
            let mut candidates =
                Self { names: [_mm256_setzero_si256(); 2], coordinates: [[_mm256_setzero_ps(); 2]; 3] };
            for half in 0..2 {
                candidates.names[half] = _mm256_loadu_si256(names.as_ptr().add(8 * half).cast());
                for axis in 0..3 {
                    candidates.coordinates[axis][half] = _mm256_loadu_ps(coordinates[axis].as_ptr().add(8 * half));
                }
            }
            candidates
        }
    }

    #[inline(always)]
    fn near(&self, point: [f32; 3], squared: f32) -> u32 {
        let mut mask = 0;
        for half in 0..2 {
            // SAFETY: AVX2 is there.
            let near = unsafe {
                let x = _mm256_sub_ps(_mm256_set1_ps(point[0]), self.coordinates[0][half]);
                let y = _mm256_sub_ps(_mm256_set1_ps(point[1]), self.coordinates[1][half]);
                let z = _mm256_sub_ps(_mm256_set1_ps(point[2]), self.coordinates[2][half]);
                let sum = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(sum, _mm256_set1_ps(squared)))
            };
            mask |= (near as u32) << (8 * half);
        }
        mask
    }

    #[inline(always)]
    fn near_rectangle(&self, low: [f32; 2], high: [f32; 2], squared: f32) -> u32 {
        let mut mask = 0;
        for half in 0..2 {
            // SAFETY: AVX2 is there.
            let near = unsafe {
                let mut squares = [_mm256_setzero_ps(); 2];
                for axis in 0..2 {
                    let x = self.coordinates[axis + 1][half];
                    let (below, above) =
                        (_mm256_sub_ps(_mm256_set1_ps(low[axis]), x), _mm256_sub_ps(x, _mm256_set1_ps(high[axis])));
                    let distance = _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
                    squares[axis] = _mm256_mul_ps(distance, distance);
                }
                let sum = _mm256_add_ps(squares[0], squares[1]);
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(sum, _mm256_set1_ps(squared)))
            };
            mask |= (near as u32) << (8 * half);
        }
        mask
    }

    #[inline(always)]
    fn compress_coordinates(&self, mask: u32, to: [&mut [f32; SEARCH_WIDTH]; 3]) {
        for (axis, to) in to.into_iter().enumerate() {
            // SAFETY: AVX2 is there.
            let halves = unsafe {
                let [a, b] = self.coordinates[axis];
                [_mm256_castps_si256(a), _mm256_castps_si256(b)]
            };
            compress_halves(halves, mask, to.as_mut_ptr().cast());
        }
    }

    #[inline(always)]
    fn compress(&self, mask: u32, to: &mut [u32; SEARCH_WIDTH]) {
        compress_halves(self.names, mask, to.as_mut_ptr());
    }
}

/// Writes those of sixteen words whose bits are set to the front of the room for sixteen words at `to`.
#[inline(always)]
fn compress_halves(halves: [__m256i; 2], mask: u32, to: *mut u32) {
    let mut count = 0;
    for half in 0..2 {
        let set = mask as usize >> (8 * half) & 0xff;
        // SAFETY: AVX2 is there; eight words are loaded from the table, and stored to at most place eight, the count of the
        // first half, and the seven after it.
        unsafe {
            let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(SET_LANES[set].as_ptr().cast()));
            let packed = _mm256_permutevar8x32_epi32(halves[half], order);
            _mm256_storeu_si256(to.add(count).cast(), packed);
        }
        count += set.count_ones() as usize;
    }
}

/// For each set of lanes the lanes that are in it, in order.
static SET_LANES: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// A row in a register.
#[derive(Debug, Clone, Copy)]
pub struct RowAvx(__m256d);

impl RowLanes for RowAvx {
    #[inline(always)]
    unsafe fn load(from: *const Row) -> Self {
        // SAFETY: AVX is there; a row holds four numbers and is aligned; that it is there is the caller's promise.
        Self(unsafe { _mm256_load_pd(from.cast()) })
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut Row) {
        // SAFETY: as above.
        unsafe { _mm256_store_pd(to.cast(), self.0) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: AVX is there.
        Self(unsafe { _mm256_add_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn subtract(self, other: Self) -> Self {
        // SAFETY: AVX is there.
        Self(unsafe { _mm256_sub_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn add_scaled(self, factor: f64, direction: Self) -> Self {
        // SAFETY: FMA is there.
        Self(unsafe { _mm256_fmadd_pd(_mm256_set1_pd(factor), direction.0, self.0) })
    }

    #[inline(always)]
    fn dot(self, other: Self) -> f64 {
        // SAFETY: AVX is there.
        unsafe {
            let products = _mm256_mul_pd(self.0, other.0);
            let halves = _mm_add_pd(_mm256_castpd256_pd128(products), _mm256_extractf128_pd::<1>(products));
            _mm_cvtsd_f64(_mm_add_sd(halves, _mm_unpackhi_pd(halves, halves)))
        }
    }
}
