//! The pairs within the cutoff at the present positions: found once, visited by every pass in one order.

use super::groups::{Groups, portions};
use crate::boundary::PeriodicBox;
use crate::interactions::{Kind, PairTable};
use crate::lanes::{BlockNumbers, Candidates, Lanes, SEARCH_WIDTH, WIDTH};
use crate::vector::{Vector, dot, subtract};
use std::collections::HashMap;
use std::ops::Range;

/// Pairs of particles by their places in storage.
///
/// A few stand in it that are not quite near enough for any law (see the search in `neighbors`); they feel nothing.
///
/// # Order of visits
/// A sweep goes through eight streams in lockstep. With n contacts and l = ⌊n/8⌋ it visits the contacts 0, l, 2l, …, 7l, then
/// 1, l + 1, …, 7l + 1, and so on, at last the rest from 8l on. So contacts that share a particle, neighbors in one stream,
/// are seldom visited one right after the other, and the processor works on several at a time.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    first: Vec<u32>,
    second: Vec<u32>,
    /// Which laws act between them; empty where there is but one kind of pair.
    kind: Vec<Kind>,
    count: usize,
    /// All places are below this, also those that stand behind the last contact.
    places_below: usize,
}

/// So many contacts are few: room for them may be doubled.
const FEW: usize = 4096;

/// Contacts that are worked on together: contact `first + s·stride + k` is entry k < `depth` of stream s < `streams`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    first: usize,
    stride: usize,
    pub streams: usize,
    pub depth: usize,
}

impl Block {
    /// So many rows of eight contacts.
    #[inline(always)]
    pub fn of_rows(rows: Range<usize>) -> Self {
        Self { first: rows.start * WIDTH, stride: WIDTH, streams: rows.len().min(WIDTH), depth: WIDTH }
    }

    /// The index of the first contact of a stream.
    #[inline(always)]
    pub fn stream(&self, stream: usize) -> usize {
        self.first + stream * self.stride
    }
}

/// A law between two particles that follows from their distance.
pub(crate) trait PairLaw {
    /// Its values at a block's distances; zero at and beyond the cutoff.
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers);
}

impl Contacts {
    /// Contacts between the given places.
    #[cfg(test)]
    pub(crate) fn of(pairs: &[[u32; 2]]) -> Self {
        let mut contacts = Self::default();
        let Room { first, second } = contacts.room(pairs.len());
        for (k, pair) in pairs.iter().enumerate() {
            (first[k], second[k]) = (pair[0], pair[1]);
        }
        contacts.finish(pairs.len());
        contacts
    }

    /// The contacts in the order of a forward sweep where friction depends on velocity: group after group (see `pair/groups.rs`).
    pub fn in_groups(&self) -> Vec<usize> {
        let number: HashMap<[usize; 2], usize> = (0..self.count).map(|k| (self.pair(k), k)).collect();
        let (mut groups, mut order) = (Groups::default(), Vec::with_capacity(self.count));
        for portion in portions(self.count, false) {
            groups.arrange(self, portion);
            order.extend((0..groups.count()).flat_map(|group| groups.members(group)).map(|pair| number[&pair]));
        }
        order
    }

    /// Fills rows of eight with copies of one of others' contacts.
    #[inline(always)]
    pub(super) fn begin_rows(&mut self, rows: Range<usize>, others: &Self, contact: usize) {
        let (start, end) = (rows.start * WIDTH, rows.end * WIDTH);
        self.room(end);
        self.first[start..end].fill(others.first[contact]);
        self.second[start..end].fill(others.second[contact]);
        if !others.kind.is_empty() {
            self.kind.resize(self.first.len(), 0);
            self.kind[start..end].fill(others.kind[contact]);
        }
    }

    /// Puts one of others' contacts into a place of a row that was begun.
    #[inline(always)]
    pub(super) fn copy(&mut self, place: usize, others: &Self, contact: usize) {
        (self.first[place], self.second[place]) = (others.first[contact], others.second[contact]);
        if !others.kind.is_empty() {
            self.kind[place] = others.kind[contact];
        }
    }

    /// Ends after so many rows of others' contacts.
    pub(super) fn end_rows(&mut self, rows: usize, others: &Self) {
        self.count = rows * WIDTH;
        self.places_below = others.places_below;
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The places of both particles of a contact.
    pub fn pair(&self, k: usize) -> [usize; 2] {
        [self.first[k] as usize, self.second[k] as usize]
    }

    /// The kind of a contact.
    pub fn kind(&self, k: usize) -> usize {
        self.kind.get(k).map_or(0, |&kind| usize::from(kind))
    }

    /// The contacts in the order of a forward sweep.
    pub fn in_order(&self) -> impl Iterator<Item = usize> {
        self.blocks(false).flat_map(|block| {
            let streams = move |entry| (0..block.streams).map(move |stream| block.stream(stream) + entry);
            (0..block.depth).flat_map(streams)
        })
    }

    /// r and e = (r_first − r_second)/r of a contact at its nearest images; e is zero for coincident particles.
    pub fn separation(&self, k: usize, positions: &[Vector], region: &PeriodicBox) -> (f64, Vector) {
        let [i, j] = self.pair(k);
        let d = region.nearest_image(subtract(positions[i], positions[j]));
        let r = dot(d, d).sqrt();
        (r, if r > 0.0 { d.map(|d| d / r) } else { d })
    }

    /// Room for so many contacts and what is written beyond the last.
    #[inline(always)]
    pub(crate) fn room(&mut self, count: usize) -> Room<'_> {
        if self.first.len() < count + SEARCH_WIDTH {
            self.grow(count + SEARCH_WIDTH);
        }
        let length = self.first.len();
        Room { first: &mut self.first, second: &mut self.second[..length] }
    }

    #[cold]
    fn grow(&mut self, length: usize) {
        // A little room for the next time, but no doubling where there are many: contacts are much of what a simulation holds.
        let length = (length + length / 16).max((2 * self.first.len()).min(FEW));
        for column in [&mut self.first, &mut self.second] {
            column.reserve_exact(length - column.len());
            column.resize(length, 0);
        }
    }

    /// Ends a search that found so many.
    pub(crate) fn finish(&mut self, count: usize) {
        self.room(count);
        let mut largest = 0;
        for column in [&self.first, &self.second] {
            for &place in &column[..count + WIDTH] {
                largest = largest.max(place);
            }
        }
        self.places_below = largest as usize + 1;
        self.count = count;
        self.kind.clear();
    }

    /// Gives every contact its kind.
    pub(crate) fn set_kinds(&mut self, kind: impl Fn(u32, u32) -> Kind) {
        let pairs = self.first[..self.count].iter().zip(&self.second);
        self.kind.extend(pairs.map(|(&i, &j)| kind(i, j)));
        self.kind.resize(self.count + WIDTH, 0);
    }

    /// The blocks in the order of a forward or backward sweep.
    #[inline(always)]
    pub(crate) fn blocks(&self, backward: bool) -> impl Iterator<Item = Block> + use<> {
        let stride = self.count / WIDTH;
        let (full, rest) = (stride.div_ceil(WIDTH), self.count - stride * WIDTH);
        let total = full + usize::from(rest > 0);
        (0..total).map(move |n| {
            let n = if backward { total - 1 - n } else { n };
            if n < full {
                let first = n * WIDTH;
                Block { first, stride, streams: WIDTH, depth: (stride - first).min(WIDTH) }
            } else {
                Block { first: stride * WIDTH, stride: 0, streams: 1, depth: rest }
            }
        })
    }

    /// The places of eight contacts from one on; those beyond the last are places too.
    #[inline(always)]
    pub(crate) fn places(&self, from: usize) -> [&[u32; WIDTH]; 2] {
        [group(&self.first, from), group(&self.second, from)]
    }

    /// The kinds of eight contacts from one on, where there is more than one.
    #[inline(always)]
    pub(crate) fn kinds(&self, from: usize) -> Option<&[Kind; WIDTH]> {
        if self.kind.is_empty() { None } else { Some(group(&self.kind, from)) }
    }

    /// The values of a table's laws at the distances of a block's contacts, each by its kind; zero where there is no law.
    #[inline(always)]
    pub(crate) fn by_kind<L: Lanes, T: PairLaw>(
        &self,
        block: &Block,
        table: &PairTable<Option<T>>,
        distance: &BlockNumbers,
        values: &mut BlockNumbers,
    ) {
        if self.kind.is_empty() {
            match &table.entries()[0] {
                Some(law) => law.fill::<L>(block.streams, distance, values),
                None => *values = BlockNumbers::default(),
            }
            return;
        }
        *values = BlockNumbers::default();
        let mut of_law = BlockNumbers::default();
        for (kind, law) in table.entries().iter().enumerate() {
            if let Some(law) = law {
                law.fill::<L>(block.streams, distance, &mut of_law);
                for s in 0..block.streams {
                    let chosen = L::of_kind(group(&self.kind, block.stream(s)), kind as Kind);
                    L::select(chosen, L::load(&of_law[s]), L::load(&values[s])).store(&mut values[s]);
                }
            }
        }
    }

    /// All places are below this.
    pub(crate) fn places_below(&self) -> usize {
        self.places_below
    }
}

/// Where a search writes contacts.
pub(crate) struct Room<'a> {
    first: &'a mut [u32],
    second: &'a mut [u32],
}

impl Room<'_> {
    /// Writes one particle's contacts with those candidates that the mask names to the places from `from` on; returns how many.
    #[inline(always)]
    pub fn append<L: Lanes>(&mut self, from: usize, first: u32, candidates: &L::Candidates, mask: u32) -> usize {
        assert!(from + SEARCH_WIDTH <= self.first.len().min(self.second.len()), "no room for contacts");
        // SAFETY: there is room for as many as are written, as was just checked.
        unsafe {
            *self.first.as_mut_ptr().add(from).cast::<[u32; SEARCH_WIDTH]>() = [first; SEARCH_WIDTH];
            candidates.compress(mask, &mut *self.second.as_mut_ptr().add(from).cast());
        }
        mask.count_ones() as usize
    }
}

/// Eight entries of a column from one on.
#[inline(always)]
fn group<T>(column: &[T], from: usize) -> &[T; WIDTH] {
    column[from..].first_chunk().expect("room for a whole group behind every contact")
}
