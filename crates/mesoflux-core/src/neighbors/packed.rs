//! Those particles of a row that may be near to a particle of another one, packed together.

use super::rows::{Entries, Rectangle, SearchRow};
use crate::lanes::{Candidates, Lanes, SEARCH_WIDTH};
use std::ops::Range;

/// Entries of a row that lie near to another one's rectangle, in the row's order.
#[derive(Debug, Clone, Default)]
pub struct Packed {
    place: Vec<u32>,
    coordinates: [Vec<f32>; 3],
    count: usize,
    /// For each sixteen entries which of them were taken, and how many before them.
    taken: Vec<(u32, u32)>,
    /// The first entry of the first sixteen.
    first: usize,
}

impl Packed {
    /// Takes those of some entries of a row that lie within a squared distance of a rectangle.
    #[inline(always)]
    pub fn take<L: Lanes>(&mut self, row: &SearchRow, from: Range<usize>, near: &Rectangle, squared: f32) {
        let length = from.len() + 2 * SEARCH_WIDTH;
        if self.place.len() < length {
            self.place.resize(length, 0);
            self.coordinates.iter_mut().for_each(|column| column.resize(length, 0.0));
        }
        self.taken.clear();
        self.first = from.start;
        let mut count = 0;
        let [x, y, z] = &mut self.coordinates;
        let mut entry = from.start;
        while let Some((places, coordinates)) = row.entries().group(entry)
            && entry < from.end
        {
            let group = L::Candidates::load(places, coordinates);
            let inside = u32::MAX >> (32 - (from.end - entry).min(SEARCH_WIDTH));
            let mask = group.near_rectangle(near.low, near.high, squared) & inside;
            self.taken.push((mask, count as u32));
            group.compress(mask, room(&mut self.place, count));
            group.compress_coordinates(mask, [room(x, count), room(y, count), room(z, count)]);
            count += mask.count_ones() as usize;
            entry += SEARCH_WIDTH;
        }
        self.taken.push((0, count as u32));
        *room(x, count) = [f32::NAN; SEARCH_WIDTH];
        self.count = count;
    }

    /// How many were taken.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The taken entries; behind them stand a few that are near to nobody.
    #[inline(always)]
    pub fn entries(&self) -> Entries<'_> {
        let (length, [x, y, z]) = (self.count + SEARCH_WIDTH, &self.coordinates);
        Entries { place: &self.place[..length], x: &x[..length], y: &y[..length], z: &z[..length] }
    }

    /// How many entries before one of the row's were taken.
    #[inline(always)]
    pub fn rank(&self, entry: usize) -> usize {
        let entry = entry - self.first;
        let (mask, before) = self.taken[entry / SEARCH_WIDTH];
        before as usize + (mask & ((1 << (entry % SEARCH_WIDTH)) - 1)).count_ones() as usize
    }
}

/// Room for a group of entries from one on.
#[inline(always)]
fn room<T>(column: &mut [T], from: usize) -> &mut [T; SEARCH_WIDTH] {
    column[from..].first_chunk_mut().expect("room for a whole group behind every entry")
}
