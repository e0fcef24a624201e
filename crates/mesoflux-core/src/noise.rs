//! Counter-based random numbers: noise as a pure function of who, when and which draw.
//!
//! Philox 4×32-10 (Salmon, Moraes, Dror & Shaw, SC 2011) maps a 128-bit counter and a 64-bit key to 128 random bits.
//! The counter holds the two ids of a pair, the smaller first; the key is mixed from everything else. No stream, no state:
//! the number that a pair receives depends on neither threads nor the order of pairs nor the age of a list.

use crate::elementary::{cos_two_pi, ln};
use serde::{Deserialize, Serialize};

/// The Philox 4×32 bijection with ten rounds.
#[inline(always)]
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let a = u64::from(counter[0]) * 0xD251_1F53;
        let b = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [(b >> 32) as u32 ^ counter[1] ^ key[0], b as u32, (a >> 32) as u32 ^ counter[3] ^ key[1], a as u32];
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

/// A bijection of 64 bits whose outputs look independent (the finalizer of `SplitMix64`, Steele, Lea & Flood 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// What a random number is for; different purposes never share noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Positions and momenta at the start.
    Start = 1,
    /// A letter's or integrator's pair noise.
    Pair = 2,
}

/// The identity of one run among all runs of a job: seed, sweep point, route, point of the route, replica.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct NoiseKey {
    run: u64,
}

impl NoiseKey {
    /// Mixes the numbers that identify a run, in their order, into its key.
    ///
    /// Two runs that differ in any one of them draw different noise.
    pub fn new(identity: &[u64]) -> Self {
        let run = identity
            .iter()
            .fold(0x6D65_736F_666C_7578, |key, &number| mix(key ^ mix(number.wrapping_add(0x9E37_79B9_7F4A_7C15))));
        Self { run }
    }

    /// The draw of a letter: `step` of the run, `place` of the letter in its word (below 2¹²).
    ///
    /// Within a run the map from (purpose, step, place) to keys is one to one for steps below 2⁴⁸.
    pub fn draw(&self, purpose: Purpose, step: u64, place: u64) -> Draw {
        let counter = (step << 16) ^ (place << 4) ^ purpose as u64;
        let key = mix(self.run.wrapping_add(counter.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        Draw { key: [key as u32, (key >> 32) as u32] }
    }
}

/// One use of randomness: a function from pairs (or particle and index) to numbers.
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    key: [u32; 2],
}

impl Draw {
    /// Two independent 64-bit words for an ordered pair of numbers.
    #[inline(always)]
    fn words(self, a: u64, b: u64) -> [u64; 2] {
        let r = philox([a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32], self.key);
        [u64::from(r[0]) | u64::from(r[1]) << 32, u64::from(r[2]) | u64::from(r[3]) << 32]
    }

    /// A number uniform in [0, 1) with 52 bits.
    #[inline(always)]
    pub fn uniform(self, a: u64, b: u64) -> f64 {
        unit_interval(self.words(a, b)[0])
    }

    /// A normal deviate, mean zero, variance one, for the ordered pair (a, b): Box and Muller's first one.
    #[inline(always)]
    pub fn gaussian(self, a: u64, b: u64) -> f64 {
        let [first, second] = self.words(a, b);
        box_muller(first, second)
    }

    /// The normal deviates of up to `N` unordered pairs of particles, given by their places in the column of ids.
    ///
    /// The same numbers as `pair_gaussian` gives one by one; three plain loops that become vector instructions.
    #[inline(always)]
    pub fn pair_gaussians<const N: usize>(self, id: &[u64], first: &[u32], second: &[u32]) -> [f64; N] {
        let (mut smaller, mut larger) = ([0; N], [0; N]);
        for ((&i, &j), (a, b)) in first.iter().zip(second).zip(smaller.iter_mut().zip(&mut larger)) {
            let (i, j) = (id[i as usize], id[j as usize]);
            (*a, *b) = (i.min(j), i.max(j));
        }
        // A whole number of vectors, filled or not; beyond the pairs the numbers mean nothing.
        let count = first.len().next_multiple_of(8).min(N);
        let mut words = [[0; N]; 2];
        for n in 0..count {
            let [a, b] = self.words(smaller[n], larger[n]);
            words[0][n] = a;
            words[1][n] = b;
        }
        let mut gaussians = [0.0; N];
        for n in 0..count {
            gaussians[n] = box_muller(words[0][n], words[1][n]);
        }
        gaussians
    }

    /// The normal deviate of an unordered pair of particles, the same whichever comes first.
    #[inline(always)]
    pub fn pair_gaussian(self, i: u64, j: u64) -> f64 {
        self.gaussian(i.min(j), i.max(j))
    }
}

/// One normal deviate from two random words (Box & Muller, Ann. Math. Stat. 29, 610 (1958)).
#[inline(always)]
fn box_muller(first: u64, second: u64) -> f64 {
    // 1 − u lies in (0, 1]: its logarithm is finite.
    (-2.0 * ln(1.0 - unit_interval(first))).sqrt() * cos_two_pi(unit_interval(second))
}

/// The upper 52 bits of a word as a number in [0, 1).
#[inline(always)]
fn unit_interval(word: u64) -> f64 {
    f64::from_bits((word >> 12) | (1023 << 52)) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers published with Random123 (`kat_vectors`, philox4x32 with 10 rounds).
    #[test]
    fn philox_gives_the_published_answers() {
        let cases = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(philox(counter, key), expected);
        }
    }

    #[test]
    fn gaussian_has_the_moments_of_a_normal_deviate() {
        let draw = NoiseKey::new(&[1]).draw(Purpose::Pair, 0, 0);
        let n = 1_000_000;
        let mut power_sums = [0.0; 5];
        for k in 0..n {
            let g = draw.gaussian(k, 7);
            for (power, sum) in power_sums.iter_mut().enumerate() {
                *sum += g.powi(power as i32);
            }
        }
        // Moments 0, 1, 0, 3 of order 1 to 4 and the variances of their estimates: 1, 2, 15, 96 over n.
        for (order, moment, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let z = (power_sums[order] / n as f64 - moment) / (variance / n as f64).sqrt();
            assert!(z.abs() < 4.0, "moment {order}: z = {z}");
        }
    }

    #[test]
    fn a_pair_draws_the_same_number_in_both_orders_and_another_at_every_other_use() {
        let key = NoiseKey::new(&[1, 2, 3]);
        let here = key.draw(Purpose::Pair, 10, 2);
        let number = here.pair_gaussian(3, 11);
        assert_eq!(number, here.pair_gaussian(11, 3));
        let others = [
            key.draw(Purpose::Pair, 11, 2),
            key.draw(Purpose::Pair, 10, 3),
            key.draw(Purpose::Start, 10, 2),
            NoiseKey::new(&[1, 3, 2]).draw(Purpose::Pair, 10, 2),
        ];
        for other in others {
            assert_ne!(number, other.pair_gaussian(3, 11));
        }
        assert_ne!(number, here.pair_gaussian(3, 12));
    }
}
