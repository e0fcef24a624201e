//! Writing to two particles at once from several threads: allowed because bricks of one color share no particle.

use super::contacts::{CHUNK, Contacts};
use crate::vector::{Vector, add_scaled};
use std::marker::PhantomData;

/// A column that several bricks of one color write to at the same time.
pub(crate) struct Scatter<'a, T> {
    start: *mut T,
    count: usize,
    column: PhantomData<&'a mut [T]>,
}

// SAFETY: a shared `Scatter` only hands out places through `pair`, whose callers promise that no two threads use one place.
unsafe impl<T: Send> Sync for Scatter<'_, T> {}

impl<'a, T: Copy> Scatter<'a, T> {
    pub(crate) fn new(column: &'a mut [T]) -> Self {
        Self { start: column.as_mut_ptr(), count: column.len(), column: PhantomData }
    }

    /// The entries of two different particles.
    ///
    /// # Safety
    /// No other thread may use either place at the same time, and the references must be dropped before the next call
    /// from this thread. Both hold inside `NeighborList::sweep`, which runs bricks of one color only side by side.
    #[inline(always)]
    #[allow(clippy::mut_from_ref, reason = "exclusive access is the caller's promise")]
    pub(crate) unsafe fn pair(&self, first: u32, second: u32) -> (&mut T, &mut T) {
        let (first, second) = (first as usize, second as usize);
        assert!(first < self.count && second < self.count && first != second, "a pair is two particles of the column");
        // SAFETY: both places lie inside the column and differ; exclusive access is the caller's promise.
        unsafe { (&mut *self.start.add(first), &mut *self.start.add(second)) }
    }
}

impl Scatter<'_, Vector> {
    /// Adds f e to the first and −f e to the second particle of every contact of a chunk; only inside a sweep.
    #[inline(always)]
    pub(crate) fn add_opposite(&self, contacts: &Contacts, chunk: &std::ops::Range<usize>, magnitude: &[f64; CHUNK]) {
        let (first, second) = (&contacts.first[chunk.clone()], &contacts.second[chunk.clone()]);
        for (n, &e) in contacts.direction[chunk.clone()].iter().enumerate() {
            // SAFETY: the kernels that call this run inside a sweep.
            let (force, reaction) = unsafe { self.pair(first[n], second[n]) };
            add_scaled(force, magnitude[n], e);
            add_scaled(reaction, -magnitude[n], e);
        }
    }
}
