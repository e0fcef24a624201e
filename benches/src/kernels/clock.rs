//! The frequency at which the core runs at the moment, from a chain of operations of one cycle each.

use std::hint::black_box;
use std::time::Instant;

/// Rounds of the chain: a few milliseconds.
const ROUNDS: u64 = 1_000_000;
/// Three shifts and three exclusive ors, each waiting for the one before and done in one cycle by every common processor.
const CYCLES: f64 = 6.0;

/// Cycles per nanosecond; the fastest of a few trials, so that a busy machine does not make the core look slow.
pub fn gigahertz() -> f64 {
    let trial = |seed: u64| {
        let begin = Instant::now();
        let mut state = black_box(seed | 1);
        for _ in 0..ROUNDS {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
        }
        black_box(state);
        CYCLES * ROUNDS as f64 / begin.elapsed().as_nanos() as f64
    };
    (1..=5).map(trial).fold(0.0, f64::max)
}
