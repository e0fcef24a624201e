//! Who owns which work, and sums over everybody: one process with threads now, ranks of several processes next.
//!
//! Every global sum and every parallel loop of the engine goes through here; no physics file knows how many workers there are.

mod exact_sum;

pub use exact_sum::ExactSum;

use rayon::prelude::*;

/// Particles a worker takes at a time in a loop over particles.
const CHUNK: usize = 2048;

/// How the loops of one simulation are spread over threads. The result of a loop never depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Workers {
    /// Everything on the calling thread: the right choice for small systems, of which many run side by side.
    #[default]
    One,
    /// All threads of the rayon pool in which the simulation is called.
    Pool,
}

impl Workers {
    /// Calls `work(offset, chunk)` for consecutive chunks of a column.
    pub fn for_each_chunk<T: Send>(self, column: &mut [T], work: impl Fn(usize, &mut [T]) + Sync) {
        match self {
            Self::One => work(0, column),
            Self::Pool => column.par_chunks_mut(CHUNK).enumerate().for_each(|(k, chunk)| work(k * CHUNK, chunk)),
        }
    }

    /// Calls `work(offset, chunk, chunk)` for consecutive chunks of two columns of equal length.
    pub fn for_each_chunk_of_two<T: Send, U: Send>(
        self,
        first: &mut [T],
        second: &mut [U],
        work: impl Fn(usize, &mut [T], &mut [U]) + Sync,
    ) {
        match self {
            Self::One => work(0, first, second),
            Self::Pool => {
                let chunks = first.par_chunks_mut(CHUNK).zip(second.par_chunks_mut(CHUNK));
                chunks.enumerate().for_each(|(k, (first, second))| work(k * CHUNK, first, second));
            }
        }
    }

    /// Calls `work(k, item)` for every item, large pieces of work each.
    pub fn for_each<T: Send>(self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        match self {
            Self::One => items.iter_mut().enumerate().for_each(|(k, item)| work(k, item)),
            Self::Pool => items.par_iter_mut().enumerate().for_each(|(k, item)| work(k, item)),
        }
    }

    /// The sum of `term(k)` over 0 ≤ k < `count`, independent of the order of its terms.
    pub fn sum(self, count: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
        let part = |range: std::ops::Range<usize>| {
            let mut sum = ExactSum::default();
            range.for_each(|k| sum.add(term(k)));
            sum
        };
        match self {
            Self::One => part(0..count).value(),
            Self::Pool => (0..count.div_ceil(CHUNK))
                .into_par_iter()
                .map(|k| part(k * CHUNK..((k + 1) * CHUNK).min(count)))
                .reduce(ExactSum::default, |mut a, b| {
                    a.merge(&b);
                    a
                })
                .value(),
        }
    }

    /// The two largest of `value(k)` over 0 ≤ k < `count`, the larger first; a value that isn't a number counts as infinite.
    pub fn two_largest(self, count: usize, value: impl Fn(usize) -> f64 + Sync) -> [f64; 2] {
        let include = |[first, second]: [f64; 2], value: f64| {
            let value = if value.is_nan() { f64::INFINITY } else { value };
            [first.max(value), second.max(first.min(value))]
        };
        let part = |range: std::ops::Range<usize>| range.map(&value).fold([0.0; 2], include);
        match self {
            Self::One => part(0..count),
            Self::Pool => (0..count.div_ceil(CHUNK))
                .into_par_iter()
                .map(|k| part(k * CHUNK..((k + 1) * CHUNK).min(count)))
                .reduce(|| [0.0; 2], |a, b| include(include(a, b[0]), b[1])),
        }
    }
}
