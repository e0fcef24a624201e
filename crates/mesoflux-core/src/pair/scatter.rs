//! Writing to two particles at once from several threads: allowed because bricks of one color share no particle.

use super::contacts::{Block, Contacts};
use super::separations::Separations;
use crate::lanes::{BlockOf, Lanes, Row, RowLanes, WIDTH};
use std::marker::PhantomData;

/// A column of rows that several bricks of one color write to at the same time.
pub(crate) struct Scatter<'a> {
    start: *mut Row,
    count: usize,
    column: PhantomData<&'a mut [Row]>,
}

// SAFETY: a shared `Scatter` only hands out addresses; those who use them are inside a sweep, where no two threads have a particle in
// common.
unsafe impl Sync for Scatter<'_> {}

/// Rows of the pairs of a block, stream by stream.
pub(crate) type BlockRows = BlockOf<Row>;

impl<'a> Scatter<'a> {
    pub fn new(column: &'a mut [Row]) -> Self {
        Self { start: column.as_mut_ptr(), count: column.len(), column: PhantomData }
    }

    /// Where the rows of the two particles of a contact are.
    ///
    /// # Safety
    /// Both places lie inside the column.
    #[inline(always)]
    pub unsafe fn pair(&self, [first, second]: [u32; 2]) -> [*mut Row; 2] {
        // SAFETY: the caller's promise.
        unsafe { [self.start.add(first as usize), self.start.add(second as usize)] }
    }

    /// The rows of eight particles, component by component.
    ///
    /// # Safety
    /// All places lie inside the column, and no other thread writes to them.
    #[inline(always)]
    pub unsafe fn load<L: Lanes>(&self, places: &[u32; WIDTH]) -> [L; 4] {
        // SAFETY: the caller's promise.
        unsafe { L::load_rows(self.start, places) }
    }

    /// Makes sure that the contacts are of the column's particles.
    #[inline(always)]
    pub fn check(&self, contacts: &Contacts) {
        assert!(contacts.places_below() <= self.count, "contacts of other particles");
    }

    /// Adds a row to the first and subtracts it from the second particle of every contact of a block; only inside a sweep, and
    /// with checked contacts.
    #[inline(always)]
    pub fn add_opposite<L: Lanes>(&self, block: &Block, pairs: &Separations, rows: &BlockRows) {
        if block.streams == WIDTH {
            for k in 0..block.depth.min(WIDTH) {
                for s in 0..WIDTH {
                    self.add_row::<L>(pairs, s, k, rows);
                }
            }
        } else {
            for k in 0..block.depth.min(WIDTH) {
                for s in 0..block.streams.min(WIDTH) {
                    self.add_row::<L>(pairs, s, k, rows);
                }
            }
        }
    }

    #[inline(always)]
    fn add_row<L: Lanes>(&self, pairs: &Separations, s: usize, k: usize, rows: &BlockRows) {
        // SAFETY: the places were checked, and inside a sweep no other thread uses them.
        unsafe {
            let [force, reaction] = self.pair([pairs.places[0][s][k], pairs.places[1][s][k]]);
            let row = L::Row::load(&raw const rows[s][k]);
            L::Row::load(force).add(row).store(force);
            L::Row::load(reaction).subtract(row).store(reaction);
        }
    }
}
