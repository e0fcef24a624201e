//! Counter-based random numbers: noise as a pure function of who, when and which draw.
//!
//! Philox (Salmon, Moraes, Dror & Shaw, SC 2011) maps a counter and a key to bits that look random; seven rounds are the fewest
//! with which it passes all of BigCrush. The noise of pairs comes from Philox 2×32-7, whose counter holds the two ids, the
//! smaller first; the key, and what the second id is combined with, are mixed from everything else. What is drawn seldom comes
//! from Philox 4×32-7. No stream, no state: the number that a pair receives depends on neither threads nor the order of pairs
//! nor the age of a list.
//!
//! The normal deviates of pairs are worked out in single precision from 31 and 32 random bits: their moments are right to 1e-7,
//! and none is larger than 6.6, which one in 10¹⁰ should be.

use crate::elementary::{ln, sin_half_pi, single};
use crate::lanes::{BlockNumbers, HalfWords, InstructionSet, Kernel, Lanes, Real, Single, Twice, WIDTH, Words};
use serde::{Deserialize, Serialize};

/// Rounds of the bijection.
const ROUNDS: u32 = 7;

/// The Philox 4×32 bijection; the lower half of each word counts.
#[inline(always)]
fn philox<W: Words>(mut counter: [W; 4], mut key: [u32; 2]) -> [W; 4] {
    for _ in 0..ROUNDS {
        let a = counter[0].low_product(W::splat(0xD251_1F53));
        let b = counter[2].low_product(W::splat(0xCD9E_8D57));
        let keys = [W::splat(u64::from(key[0])), W::splat(u64::from(key[1]))];
        counter = [b.shift_down::<32>() ^ counter[1] ^ keys[0], b, a.shift_down::<32>() ^ counter[3] ^ keys[1], a];
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

/// The Philox 2×32 bijection; the lower half of each word counts.
#[inline(always)]
fn philox_of_two<W: Words>([mut a, mut b]: [W; 2], mut key: u32) -> [W; 2] {
    for _ in 0..ROUNDS {
        let product = a.low_product(W::splat(0xD256_D193));
        [a, b] = [product.shift_down::<32>() ^ b ^ W::splat(u64::from(key)), product];
        key = key.wrapping_add(0x9E37_79B9);
    }
    [a, b]
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
    /// A letter's noise on single particles.
    Particle = 3,
    /// The Metropolis tests of a letter's pairs.
    Acceptance = 4,
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
    /// Two independent numbers uniform in [1, 2) for each ordered pair of words.
    #[inline(always)]
    fn uniforms<R: Real>(self, a: R::Bits, b: R::Bits) -> [R; 2] {
        let [w0, w1, w2, w3] = philox([a, a.shift_down::<32>(), b, b.shift_down::<32>()], self.key);
        [one_to_two(w0, w1), one_to_two(w2, w3)]
    }

    /// A number uniform in [0, 1) with 52 bits.
    #[inline(always)]
    pub fn uniform(self, a: u64, b: u64) -> f64 {
        self.uniforms::<f64>(a, b)[0] - 1.0
    }

    /// A normal deviate, mean zero, variance one, for the ordered pair (a, b): Box and Muller's.
    #[inline(always)]
    pub fn gaussian(self, a: u64, b: u64) -> f64 {
        self.normal(a, b)
    }

    /// The normal deviates of one ordered pair of words or of several.
    #[inline(always)]
    pub(crate) fn normal<R: Real>(self, a: R::Bits, b: R::Bits) -> R {
        let [first, second] = self.uniforms::<R>(a, b);
        squared_radius(first).sqrt() * projection(second)
    }

    /// The random words of pairs of ids below 2³², the smaller first.
    #[inline(always)]
    fn pair_words<W: Words>(self, low: W, high: W) -> [W; 2] {
        philox_of_two([low, high ^ W::splat(u64::from(self.key[1]))], self.key[0])
    }

    /// The normal deviates of the block's unordered pairs of particles, given by their ids.
    #[inline(always)]
    pub(crate) fn pair_normals<L: Lanes>(self, streams: usize, ids: &[BlockNumbers; 2], normals: &mut BlockNumbers) {
        for s in (0..streams).step_by(2) {
            let [a, b] = L::sort_words(L::load(&ids[0][s]).to_bits(), L::load(&ids[1][s]).to_bits());
            let [c, d] = L::sort_words(L::load(&ids[0][s + 1]).to_bits(), L::load(&ids[1][s + 1]).to_bits());
            let [x, y] = self.pair_words(Twice(a, c), Twice(b, d));
            let [first, second] = L::widen(normal_of_words(L::lower_halves(x.0, x.1), L::lower_halves(y.0, y.1)));
            first.store(&mut normals[s]);
            second.store(&mut normals[s + 1]);
        }
    }

    /// Numbers uniform in [0, 1) for the block's unordered pairs of particles, given by their ids.
    #[inline(always)]
    pub(crate) fn pair_uniforms<L: Lanes>(self, streams: usize, ids: &[BlockNumbers; 2], uniforms: &mut BlockNumbers) {
        for s in 0..streams {
            let [a, b] = L::sort_words(L::load(&ids[0][s]).to_bits(), L::load(&ids[1][s]).to_bits());
            let [x, y] = self.pair_words(a, b);
            (one_to_two::<L>(x, y) - L::splat(1.0)).store(&mut uniforms[s]);
        }
    }

    /// The normal deviate of an unordered pair of particles with ids below 2³², the same whichever comes first.
    #[inline(always)]
    pub fn pair_gaussian(self, i: u64, j: u64) -> f64 {
        let [x, y] = self.pair_words(i.min(j), i.max(j));
        f64::from(normal_of_words::<f32>(x as u32, y as u32))
    }

    /// A number uniform in [0, 1) for an unordered pair of particles with ids below 2³², the same whichever comes first.
    #[inline(always)]
    pub fn pair_uniform(self, i: u64, j: u64) -> f64 {
        let [x, y] = self.pair_words(i.min(j), i.max(j));
        one_to_two::<f64>(x, y) - 1.0
    }
}

/// The uniform numbers of many unordered pairs of ids at once: the numbers that `Draw::pair_uniform` gives one by one.
#[cfg(test)]
struct PairUniforms<'a> {
    draw: Draw,
    pairs: &'a [[u64; 2]],
    uniforms: &'a mut Vec<f64>,
}

#[cfg(test)]
impl Kernel for PairUniforms<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (mut ids, mut uniforms) = ([BlockNumbers::default(); 2], BlockNumbers::default());
        for pairs in self.pairs.chunks_exact(WIDTH) {
            for (k, pair) in pairs.iter().enumerate() {
                for member in 0..2 {
                    ids[member][0][k] = f64::from_bits(pair[member]);
                }
            }
            self.draw.pair_uniforms::<L>(1, &ids, &mut uniforms);
            self.uniforms.extend_from_slice(&uniforms[0]);
        }
    }
}

/// The normal deviates of many unordered pairs of ids at once: the numbers that `Draw::pair_gaussian` gives one by one.
pub fn pair_gaussians(draw: Draw, pairs: &[[u64; 2]], gaussians: &mut Vec<f64>) {
    gaussians.clear();
    gaussians.resize(pairs.len(), 0.0);
    InstructionSet::detect().run(PairGaussians { draw, pairs, gaussians });
}

/// The work of `pair_gaussians`.
struct PairGaussians<'a> {
    draw: Draw,
    pairs: &'a [[u64; 2]],
    gaussians: &'a mut [f64],
}

impl Kernel for PairGaussians<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (mut ids, mut normals) = ([BlockNumbers::default(); 2], BlockNumbers::default());
        for (pairs, gaussians) in self.pairs.chunks(WIDTH * WIDTH).zip(self.gaussians.chunks_mut(WIDTH * WIDTH)) {
            for (k, pair) in pairs.iter().enumerate() {
                for member in 0..2 {
                    ids[member][k / WIDTH][k % WIDTH] = f64::from_bits(pair[member]);
                }
            }
            self.draw.pair_normals::<L>(WIDTH, &ids, &mut normals);
            for (k, gaussian) in gaussians.iter_mut().enumerate() {
                *gaussian = normals[k / WIDTH][k % WIDTH];
            }
        }
    }
}

/// A normal deviate of two random words (Box & Muller, Ann. Math. Stat. 29, 610 (1958)): the radius from 31 bits of the first,
/// the component of a random direction in the plane, over half the circle, from the second.
#[inline(always)]
fn normal_of_words<S: Single>(first: S::Bits, second: S::Bits) -> S {
    let uniform = S::from_integers(first.shift_down::<1>()) + S::splat(0.5);
    let squared_radius = S::splat(-2.0) * single::ln_of_fraction::<_, 31>(uniform);
    let half_turns = S::from_integers(second) * S::splat(1.0 / (1u64 << 31) as f32);
    squared_radius.sqrt() * single::sin_half_pi(half_turns)
}

/// −2 ln(1 − u) of a number 1 + u uniform in [1, 2): 1 − u lies in (0, 1], its logarithm is finite.
#[inline(always)]
fn squared_radius<R: Real>(uniform: R) -> R {
    R::splat(-2.0) * ln(R::splat(2.0) - uniform)
}

/// The component of a random direction in the plane, from a number 1 + u uniform in [1, 2): sin(π(u − ½)) has the distribution of
/// cos(2πu), over half the circle.
#[inline(always)]
fn projection<R: Real>(uniform: R) -> R {
    sin_half_pi(uniform.mul_add(R::splat(2.0), R::splat(-3.0)))
}

/// A number in [1, 2) from all 32 bits of one half word and 20 of another.
#[inline(always)]
fn one_to_two<R: Real>(high: R::Bits, low: R::Bits) -> R {
    let upper = high.shift_up::<20>() & R::Bits::splat((1 << 52) - 1);
    R::from_bits(upper | (low & R::Bits::splat((1 << 20) - 1)) | R::Bits::splat(1023 << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers published with Random123 (`kat_vectors`, philox4x32 with 7 rounds).
    #[test]
    fn philox_gives_the_published_answers() {
        let cases = [
            ([0; 4], [0; 2], [0x5f6f_b709, 0x0d89_3f64, 0x4f12_1f81, 0x4f73_0a48]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x5207_ddc2, 0x4516_5e59, 0x4d8e_e751, 0x8c52_f662]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0x4dfc_caba, 0x190a_87f0, 0xc473_62ba, 0xb6b5_242a],
            ),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(
                philox(counter.map(|word: u32| u64::from(word)), key).map(|word| word as u32),
                expected.map(|word: u32| word)
            );
        }
    }

    /// The same for `philox2x32` with 7 rounds.
    #[test]
    fn philox_of_two_gives_the_published_answers() {
        let cases = [
            ([0; 2], 0, [0x257a_3673, 0xcd26_be2a]),
            ([u32::MAX; 2], u32::MAX, [0xab30_2c4d, 0x3dc9_d239]),
            ([0x243f_6a88, 0x85a3_08d3], 0x1319_8a2e, [0xbedb_be6b, 0xe4c7_70b3]),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(philox_of_two(counter.map(u64::from), key).map(|word| word as u32), expected);
        }
    }

    #[test]
    fn gaussians_have_the_moments_of_normal_deviates() {
        let key = NoiseKey::new(&[1]);
        let (start, pair) = (key.draw(Purpose::Start, 0, 0), key.draw(Purpose::Pair, 5, 1));
        let sequences: [(&str, &dyn Fn(u64) -> f64); 4] = [
            ("of one particle each", &|k| start.gaussian(k, 7)),
            ("of pairs of one particle", &|k| pair.pair_gaussian(7, k + 8)),
            ("of neighboring pairs", &|k| pair.pair_gaussian(k, k + 1)),
            ("of one pair at all times", &|k| key.draw(Purpose::Pair, k, 0).pair_gaussian(3, 7)),
        ];
        let n = 1_000_000;
        for (name, deviate) in sequences {
            let (mut power_sums, mut products, mut last) = ([0.0; 5], [0.0; 2], 0.0);
            for k in 0..n {
                let g = deviate(k);
                for (power, sum) in power_sums.iter_mut().enumerate() {
                    *sum += g.powi(power as i32);
                }
                products[0] += g * last;
                products[1] += (g * g - 1.0) * (last * last - 1.0);
                last = g;
            }
            // Moments 0, 1, 0, 3 of order 1 to 4 and the variances of their estimates: 1, 2, 15, 96 over n.
            for (order, moment, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
                let z = (power_sums[order] / n as f64 - moment) / f64::sqrt(variance / n as f64);
                assert!(z.abs() < 4.0, "{name}, moment {order}: z = {z}");
            }
            // Successive ones are independent, and so are their sizes.
            for (sum, variance) in products.into_iter().zip([1.0, 4.0]) {
                let z = sum / f64::sqrt(variance * n as f64);
                assert!(z.abs() < 4.0, "{name}, correlation: z = {z}");
            }
        }
    }

    #[test]
    fn many_pairs_at_once_draw_what_each_draws_alone() {
        let draw = NoiseKey::new(&[9]).draw(Purpose::Pair, 3, 1);
        let pairs: Vec<[u64; 2]> = (0..1000u64).map(|k| [k * k + (k << 20), 7 * k + 1]).collect();
        let expected: Vec<u64> = pairs.iter().map(|&[i, j]| draw.pair_gaussian(i, j).to_bits()).collect();
        for set in InstructionSet::available() {
            let mut gaussians = vec![0.0; pairs.len()];
            set.run(PairGaussians { draw, pairs: &pairs, gaussians: &mut gaussians });
            let found: Vec<u64> = gaussians.iter().map(|gaussian| gaussian.to_bits()).collect();
            assert_eq!(found, expected, "{set:?}");
            let mut uniforms = Vec::new();
            set.run(PairUniforms { draw, pairs: &pairs, uniforms: &mut uniforms });
            let expected: Vec<f64> = pairs.iter().map(|&[i, j]| draw.pair_uniform(i, j)).collect();
            assert_eq!(uniforms, expected, "{set:?}");
        }
    }

    #[test]
    fn uniforms_of_pairs_are_uniform() {
        let draw = NoiseKey::new(&[4]).draw(Purpose::Acceptance, 5, 1);
        let n = 1_000_000;
        let mut sums = [0.0; 3];
        for k in 0..n {
            let x = draw.pair_uniform(k, k + 3);
            assert!((0.0..1.0).contains(&x));
            for (power, sum) in sums.iter_mut().enumerate() {
                *sum += (x - 0.5).powi(power as i32 + 1);
            }
        }
        // Mean and variance of the first three central powers of a uniform number: 0, 1/12, 0 and 1/12, 1/180, 1/448.
        for (sum, (mean, variance)) in
            sums.into_iter().zip([(0.0, 1.0 / 12.0), (1.0 / 12.0, 1.0 / 180.0), (0.0, 1.0 / 448.0)])
        {
            let z = (sum / n as f64 - mean) / f64::sqrt(variance / n as f64);
            assert!(z.abs() < 4.0, "z = {z}");
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
