//! The pairs within the cutoff at the present positions, with distance and direction: found once, used by every pass.

use crate::friction::Friction;
use crate::interactions::{Kind, PairTable};
use crate::neighbors::ListedPair;
use crate::potential::Potential;
use crate::state::Particles;
use crate::vector::{Vector, ZERO};
use std::ops::Range;

/// Contacts are worked on in chunks whose intermediate columns stay in the nearest cache.
pub(crate) const CHUNK: usize = 128;

/// Pairs within the cutoff, in the order of the list they were taken from.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    /// Place of the first particle of each pair.
    pub first: Vec<u32>,
    /// Place of the second particle of each pair.
    pub second: Vec<u32>,
    /// r.
    pub distance: Vec<f64>,
    /// e = (r_first − r_second)/r; zero for coincident particles.
    pub direction: Vec<Vector>,
    /// Which species meet; empty where there is but one.
    pub kind: Vec<Kind>,
}

impl Contacts {
    /// The number of contacts.
    pub fn count(&self) -> usize {
        self.distance.len()
    }

    /// Makes room for so many contacts, so that finding them needs no memory.
    pub(crate) fn reserve(&mut self, count: usize, kinds: bool) {
        fn reserve<T>(column: &mut Vec<T>, count: usize) {
            if column.capacity() < count {
                column.clear();
                column.reserve_exact(count);
            }
        }
        reserve(&mut self.first, count);
        reserve(&mut self.second, count);
        reserve(&mut self.distance, count);
        reserve(&mut self.direction, count);
        if kinds {
            reserve(&mut self.kind, count);
        }
    }

    /// The kind of a contact.
    #[inline(always)]
    pub fn kind(&self, k: usize) -> usize {
        self.kind.get(k).map_or(0, |&kind| usize::from(kind))
    }

    /// Takes from a list the pairs within the cutoff.
    #[inline(always)]
    pub(crate) fn update(
        &mut self,
        listed: &[ListedPair],
        particles: &Particles,
        offsets: &[Vector; 27],
        cutoff: f64,
        kinds: bool,
    ) {
        self.first.clear();
        self.second.clear();
        self.distance.clear();
        self.direction.clear();
        self.kind.clear();
        let mut near = Near::default();
        for chunk in listed.chunks(CHUNK) {
            let count = if kinds {
                near.select::<true>(chunk, particles, offsets, cutoff)
            } else {
                near.select::<false>(chunk, particles, offsets, cutoff)
            };
            near.measure();
            self.first.extend_from_slice(&near.first[..count]);
            self.second.extend_from_slice(&near.second[..count]);
            self.distance.extend_from_slice(&near.distance[..count]);
            self.direction.extend_from_slice(&near.separation[..count]);
            if kinds {
                self.kind.extend_from_slice(&near.kind[..count]);
            }
        }
    }

    /// The chunks of contacts in the order of a forward or backward sweep.
    #[inline(always)]
    pub(crate) fn chunks(&self, backward: bool) -> impl Iterator<Item = Range<usize>> {
        let count = self.count();
        let chunks = count.div_ceil(CHUNK);
        (0..chunks).map(move |k| {
            let k = if backward { chunks - 1 - k } else { k };
            k * CHUNK..((k + 1) * CHUNK).min(count)
        })
    }

    /// The value of a table for each of the chunk's contacts; beyond the chunk, the first value.
    #[inline(always)]
    pub(crate) fn value_by_kind(&self, table: &PairTable<f64>, chunk: &Range<usize>, column: &mut [f64; CHUNK]) {
        column.fill(table.entries()[0]);
        if !self.kind.is_empty() {
            for (value, &kind) in column.iter_mut().zip(&self.kind[chunk.clone()]) {
                *value = table.entries()[usize::from(kind)];
            }
        }
    }

    /// f(r) of each of the chunk's contacts, zero beyond the chunk.
    #[inline(always)]
    pub(crate) fn forces(&self, table: &PairTable<Option<Potential>>, chunk: &Range<usize>, column: &mut [f64; CHUNK]) {
        column.fill(0.0);
        let (distances, column) = (&self.distance[chunk.clone()], &mut column[..chunk.len()]);
        for (kind, law) in laws(table) {
            match self.kind.get(chunk.clone()) {
                Some(kinds) if !kinds.is_empty() => law.add_forces(distances, |k| kinds[k] == kind, column),
                _ => law.add_forces(distances, |_| true, column),
            }
        }
    }

    /// Γ(r) of each of the chunk's contacts, zero beyond the chunk.
    #[inline(always)]
    pub(crate) fn strengths(
        &self,
        table: &PairTable<Option<Friction>>,
        chunk: &Range<usize>,
        column: &mut [f64; CHUNK],
    ) {
        column.fill(0.0);
        let (distances, column) = (&self.distance[chunk.clone()], &mut column[..chunk.len()]);
        for (kind, law) in laws(table) {
            match self.kind.get(chunk.clone()) {
                Some(kinds) if !kinds.is_empty() => law.add_strengths(distances, |k| kinds[k] == kind, column),
                _ => law.add_strengths(distances, |_| true, column),
            }
        }
    }
}

/// The laws of a table with their kinds.
#[inline(always)]
fn laws<L>(table: &PairTable<Option<L>>) -> impl Iterator<Item = (Kind, &L)> {
    table.entries().iter().enumerate().filter_map(|(kind, law)| Some((kind as Kind, law.as_ref()?)))
}

/// The pairs of one chunk of a list that are within the cutoff.
struct Near {
    first: [u32; CHUNK],
    second: [u32; CHUNK],
    kind: [Kind; CHUNK],
    separation: [Vector; CHUNK],
    /// r², then r.
    distance: [f64; CHUNK],
}

impl Default for Near {
    fn default() -> Self {
        Self {
            first: [0; CHUNK],
            second: [0; CHUNK],
            kind: [0; CHUNK],
            separation: [ZERO; CHUNK],
            distance: [0.0; CHUNK],
        }
    }
}

impl Near {
    /// Keeps the pairs within the cutoff, in their order; returns how many.
    #[inline(always)]
    fn select<const KINDS: bool>(
        &mut self,
        chunk: &[ListedPair],
        particles: &Particles,
        offsets: &[Vector; 27],
        cutoff: f64,
    ) -> usize {
        // Every pair is written, and only those within the cutoff advance the place: no branch to mispredict.
        let mut count = 0;
        for pair in chunk {
            let (a, b) = (particles.position[pair.first as usize], particles.position[pair.second as usize]);
            let offset = offsets[usize::from(pair.image)];
            let d = [a[0] - b[0] + offset[0], a[1] - b[1] + offset[1], a[2] - b[2] + offset[2]];
            let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            self.first[count] = pair.first;
            self.second[count] = pair.second;
            if KINDS {
                self.kind[count] = pair.kind;
            }
            self.separation[count] = d;
            self.distance[count] = squared;
            count += usize::from(squared < cutoff * cutoff);
        }
        count
    }

    /// Turns squared distances into distances and separations into directions.
    #[inline(always)]
    fn measure(&mut self) {
        for (distance, separation) in self.distance.iter_mut().zip(&mut self.separation) {
            let r = distance.sqrt();
            let inverse = if r > 0.0 { 1.0 / r } else { 0.0 };
            *distance = r;
            *separation = separation.map(|d| d * inverse);
        }
    }
}
