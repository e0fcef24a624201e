//! Who owns which work, and sums over everybody: one process with threads now, ranks of several processes next.
//!
//! Every global sum and every parallel loop of the engine goes through here; no physics file knows how many workers there are.

use rayon::prelude::*;

/// Particles a worker takes at a time in a loop over particles.
const CHUNK: usize = 2048;

/// Sums that are built side by side, so that no addition waits for the one before.
const STREAMS: usize = 8;

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

    /// Calls `work(item)` for every item, large pieces of work each.
    pub fn for_each_shared<T: Sync>(self, items: &[T], work: impl Fn(&T) + Sync + Send) {
        match self {
            Self::One => items.iter().for_each(work),
            Self::Pool => items.par_iter().for_each(work),
        }
    }

    /// The sum of `term(k)` over 0 ≤ k < `count`, to the same bits for any number of threads: the terms are added in a tree that
    /// follows from `count` alone, eight streams in each chunk, then the chunks in their order.
    pub fn sum(self, count: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
        let chunk = |number: usize| {
            let range = number * CHUNK..((number + 1) * CHUNK).min(count);
            let mut streams = [0.0; STREAMS];
            let full = range.len() / STREAMS * STREAMS;
            for k in (range.start..range.start + full).step_by(STREAMS) {
                for (stream, sum) in streams.iter_mut().enumerate() {
                    *sum += term(k + stream);
                }
            }
            let rest: f64 = (range.start + full..range.end).map(&term).sum();
            streams.iter().sum::<f64>() + rest
        };
        let chunks = count.div_ceil(CHUNK);
        match self {
            Self::One => (0..chunks).map(chunk).sum(),
            Self::Pool => (0..chunks).into_par_iter().map(chunk).collect::<Vec<f64>>().iter().sum(),
        }
    }

    /// The least of `key(k)` over 0 ≤ k < `count`, of those there are: the same for any number of threads where no two keys are equal.
    pub fn least<K: PartialOrd + Copy + Send>(
        self,
        count: usize,
        key: impl Fn(usize) -> Option<K> + Sync,
    ) -> Option<K> {
        let lesser = |a: K, b: K| if b < a { b } else { a };
        let part = |range: std::ops::Range<usize>| range.filter_map(&key).reduce(lesser);
        match self {
            Self::One => part(0..count),
            Self::Pool => (0..count.div_ceil(CHUNK))
                .into_par_iter()
                .filter_map(|k| part(k * CHUNK..((k + 1) * CHUNK).min(count)))
                .reduce_with(lesser),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_for_any_number_of_threads_and_are_right() {
        for count in [0, 1, 7, 8, 9, 2047, 2048, 2049, 10_000] {
            let term = |k: usize| ((k * 7919 + 13) % 1000) as f64 / 7.0 - 70.0;
            let one = Workers::One.sum(count, term);
            let exact =
                (0..count).map(|k| ((k * 7919 + 13) % 1000) as i64).sum::<i64>() as f64 / 7.0 - 70.0 * count as f64;
            assert!((one - exact).abs() <= 1e-12 * (1.0 + 70.0 * count as f64), "{count}: {one} for {exact}");
            for threads in [1, 2, 3, 7] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert_eq!(pool.install(|| Workers::Pool.sum(count, term)).to_bits(), one.to_bits());
            }
        }
    }
}
