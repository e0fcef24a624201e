//! Numbers eight at a time: one interface, three sets of vector instructions behind it.
//!
//! What is written once over [`Real`] or [`Lanes`] gives the same bits for a single `f64`, for portable arrays, for AVX2 with
//! FMA and for AVX-512: every operation is one correctly rounded operation of IEEE 754, fused where `mul_add` says so and
//! nowhere else, and sums run over eight lanes whatever the registers hold.
//!
//! Code over [`Lanes`] is compiled for a set of instructions only where it becomes part of the function that names the set.
//! So such code is `#[inline(always)]` throughout and uses no closures: a closure that the compiler leaves on its own would
//! make a call of every single instruction.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod instruction_set;
mod portable;
mod real;
mod single;
mod twice;

pub use instruction_set::InstructionSet;
pub(crate) use instruction_set::Kernel;
pub use real::{Real, Words};
pub use single::{HalfWords, Single};
pub use twice::Twice;

use crate::vector::Vector;

/// Numbers in one [`Lanes`].
pub const WIDTH: usize = 8;

/// Numbers in single precision that are worked on together.
pub const SINGLE_WIDTH: usize = 2 * WIDTH;

/// Something for each of up to eight times eight pairs, stream by stream; aligned, so that no load or store crosses a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct BlockOf<T>([[T; WIDTH]; WIDTH]);

/// A number for each pair of a block.
pub type BlockNumbers = BlockOf<f64>;

impl<T> std::ops::Index<usize> for BlockOf<T> {
    type Output = [T; WIDTH];
    #[inline(always)]
    fn index(&self, stream: usize) -> &[T; WIDTH] {
        &self.0[stream]
    }
}

impl<T> std::ops::IndexMut<usize> for BlockOf<T> {
    #[inline(always)]
    fn index_mut(&mut self, stream: usize) -> &mut [T; WIDTH] {
        &mut self.0[stream]
    }
}

/// Particles that a search for neighbors looks at together.
pub const SEARCH_WIDTH: usize = 16;

/// A vector and a fourth number: one register, aligned so that it is loaded and stored whole.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Row(pub [f64; 4]);

impl Row {
    /// The row of a vector and a further number.
    #[inline(always)]
    pub fn new([x, y, z]: Vector, further: f64) -> Self {
        Self([x, y, z, further])
    }

    /// The vector of a row.
    #[inline(always)]
    pub fn vector(self) -> Vector {
        let [x, y, z, _] = self.0;
        [x, y, z]
    }
}

/// Eight numbers.
pub trait Lanes: Real {
    /// Sixteen numbers in single precision.
    type Single: Single;
    /// A row in a register.
    type Row: RowLanes;
    /// Sixteen candidates in registers.
    type Candidates: Candidates;

    /// From memory.
    fn load(from: &[f64; WIDTH]) -> Self;
    /// To memory.
    fn store(self, to: &mut [f64; WIDTH]);
    /// The rows in eight places of a column, component by component.
    ///
    /// Rows are loaded whole and transposed: gathering numbers one by one is several times slower on many processors.
    ///
    /// # Safety
    /// Every place lies inside the column, and there is a row that may be read.
    unsafe fn load_rows(column: *const Row, places: &[u32; WIDTH]) -> [Self; 4];
    /// The numbers in eight places of a column, one by one.
    ///
    /// # Panics
    /// A place beyond the column.
    #[inline(always)]
    fn gather(column: &[f64], places: &[u32; WIDTH]) -> Self {
        let mut numbers = [0.0; WIDTH];
        for k in 0..WIDTH {
            numbers[k] = column[places[k] as usize];
        }
        Self::load(&numbers)
    }

    /// The smaller and the larger of each two words, both below 2⁶³.
    fn sort_words(a: Self::Bits, b: Self::Bits) -> [Self::Bits; 2];
    /// The lower halves of all words, those of `a` first.
    fn lower_halves(a: Self::Bits, b: Self::Bits) -> <Self::Single as Single>::Bits;
    /// The first eight and the last eight numbers in double precision.
    fn widen(numbers: Self::Single) -> [Self; 2];
    /// Those lanes whose kind is the given one.
    fn of_kind(kinds: &[u16; WIDTH], kind: u16) -> Self::Mask;
    /// Lane k as row k: (x_k, y_k, z_k, 0).
    fn rows(vectors: [Self; 3], to: &mut [Row; WIDTH]);
    /// The sum of all lanes: those four apart first, then those two apart, then the rest.
    #[inline(always)]
    fn sum(self) -> f64 {
        let mut x = [0.0; WIDTH];
        self.store(&mut x);
        let [a, b, c, d] = [x[0] + x[4], x[1] + x[5], x[2] + x[6], x[3] + x[7]];
        (a + c) + (b + d)
    }
}

/// factor · v
#[inline(always)]
pub fn scaled<R: Real>(factor: R, v: [R; 3]) -> [R; 3] {
    [factor * v[0], factor * v[1], factor * v[2]]
}

/// a · b
#[inline(always)]
pub fn inner_product<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Sixteen points with their names, of which those near to another are wanted.
pub trait Candidates: Copy {
    /// From memory: names and coordinates.
    fn load(names: &[u32; SEARCH_WIDTH], coordinates: [&[f32; SEARCH_WIDTH]; 3]) -> Self;
    /// Which of them lie within a squared distance of a point; bit k for candidate k.
    fn near(&self, point: [f32; 3], squared: f32) -> u32;
    /// Which of them lie within a squared distance of a rectangle across the first axis; bit k for candidate k.
    fn near_rectangle(&self, low: [f32; 2], high: [f32; 2], squared: f32) -> u32;
    /// Writes the coordinates of those whose bits are set to the front of `to`; what stands behind them means nothing.
    fn compress_coordinates(&self, mask: u32, to: [&mut [f32; SEARCH_WIDTH]; 3]);
    /// Writes the names of those whose bits are set to the front of `to`; what stands behind them means nothing.
    fn compress(&self, mask: u32, to: &mut [u32; SEARCH_WIDTH]);
}

/// A row in a register.
pub trait RowLanes: Copy {
    /// From memory.
    ///
    /// # Safety
    /// There is a row that may be read.
    unsafe fn load(from: *const Row) -> Self;
    /// To memory.
    ///
    /// # Safety
    /// There is a row that may be written.
    unsafe fn store(self, to: *mut Row);
    /// Component by component.
    #[must_use]
    fn add(self, other: Self) -> Self;
    /// Component by component.
    #[must_use]
    fn subtract(self, other: Self) -> Self;
    /// self + factor · direction, rounded once.
    #[must_use]
    fn add_scaled(self, factor: f64, direction: Self) -> Self;
    /// (x·x' + z·z') + (y·y' + w·w').
    fn dot(self, other: Self) -> f64;
}

#[cfg(test)]
mod tests;
