//! The pairs within the cutoff at the present positions, with distance and direction: found once, used by every pass.

use crate::interactions::{Kind, PairTable};
use crate::neighbors::ListedPair;
use crate::state::Particles;
use crate::vector::{Vector, ZERO};

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

    /// The kind of a contact.
    #[inline(always)]
    pub fn kind(&self, k: usize) -> usize {
        self.kind.get(k).map_or(0, |&kind| usize::from(kind))
    }

    /// Takes from a list the pairs within the cutoff.
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
        let (mut near, mut separation, mut squared) = ([(0, 0); CHUNK], [ZERO; CHUNK], [0.0; CHUNK]);
        for chunk in listed.chunks(CHUNK) {
            // Every pair is written, and only those within the cutoff advance the place: no branch to mispredict.
            let mut count = 0;
            for pair in chunk {
                let (a, b) = (
                    particles.position[pair.first as usize],
                    particles.position[pair.second as usize],
                );
                let offset = offsets[usize::from(pair.image)];
                let d = [
                    a[0] - b[0] + offset[0],
                    a[1] - b[1] + offset[1],
                    a[2] - b[2] + offset[2],
                ];
                let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                near[count] = (pair.first, pair.second);
                separation[count] = d;
                squared[count] = r2;
                count += usize::from(r2 < cutoff * cutoff);
            }
            for k in 0..count {
                let r = squared[k].sqrt();
                let inverse = if r > 0.0 { 1.0 / r } else { 0.0 };
                self.first.push(near[k].0);
                self.second.push(near[k].1);
                self.distance.push(r);
                self.direction.push(separation[k].map(|d| d * inverse));
            }
        }
        if kinds {
            let kind = |(&a, &b): (&u32, &u32)| {
                PairTable::<()>::kind(particles.species[a as usize], particles.species[b as usize])
            };
            self.kind.extend(self.first.iter().zip(&self.second).map(kind));
        }
    }

    /// The chunks of contacts in the order of a forward or backward sweep.
    #[inline(always)]
    pub(crate) fn chunks(&self, backward: bool) -> impl Iterator<Item = std::ops::Range<usize>> {
        let count = self.count();
        let chunks = count.div_ceil(CHUNK);
        (0..chunks).map(move |k| {
            let k = if backward { chunks - 1 - k } else { k };
            k * CHUNK..((k + 1) * CHUNK).min(count)
        })
    }

    /// Lets every law of a table add its value to a column for the chunk's contacts of the law's kind.
    #[inline(always)]
    pub(crate) fn add_by_kind<L>(
        &self,
        table: &PairTable<Option<L>>,
        chunk: &std::ops::Range<usize>,
        column: &mut [f64; CHUNK],
        add: impl Fn(&L, &[f64], Option<(&[Kind], Kind)>, &mut [f64]),
    ) {
        let distances = &self.distance[chunk.clone()];
        let column = &mut column[..distances.len()];
        column.fill(0.0);
        for (kind, law) in table.entries().iter().enumerate() {
            if let Some(law) = law {
                let kinds = if self.kind.is_empty() {
                    None
                } else {
                    Some((&self.kind[chunk.clone()], kind as Kind))
                };
                add(law, distances, kinds, column);
            }
        }
    }
}
