//! Elementary functions whose bits depend on nothing but their argument.
//!
//! The system's `exp`, `ln`, `sin` and `cos` differ between libraries, and a trajectory would differ with them.
//! These use only additions, multiplications, divisions, fused multiply-adds and bit operations, each correctly rounded by
//! IEEE 754: every machine gives the same bits, for one number or for eight at a time. They have no branches.

mod anywhere;

pub use anywhere::{absolute, hyperbolic_tangent, logarithm, real_power, sine_ahead, square_root, wrapped};

use crate::lanes::{Real, Words};
use std::f64::consts::{FRAC_PI_2, LOG2_E};

// ln 2 in two parts: the first has 20 trailing zero bits, so that n·LN_2_HIGH is exact for |n| < 2²⁰.
const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
const LN_2_LOW: f64 = f64::from_bits(0x3dea_39ef_3579_3c76);

// Adding and subtracting 1.5·2⁵² rounds to the nearest integer and leaves it in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// The nearest integer, for |x| < 2⁵¹; halves go to the even one.
#[inline(always)]
pub fn nearest_integer<R: Real>(x: R) -> R {
    (x + R::splat(ROUND)) - R::splat(ROUND)
}

/// e^x − 1 for −700 ≤ x ≤ 700, also where x is small; arguments outside are taken as the nearest bound.
///
/// Relative error below 4e-16 (tested).
#[inline(always)]
pub fn exp_minus_one<R: Real>(x: R) -> R {
    let (scale, reduced) = scaled_exponential(x);
    scale.mul_add(reduced, scale - R::splat(1.0))
}

/// e^x for −700 ≤ x ≤ 700; arguments outside are taken as the nearest bound. Relative error below 4e-16 (tested).
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    let (scale, reduced) = scaled_exponential(x);
    scale.mul_add(reduced, scale)
}

/// Taylor's series of (e^r − 1 − r)/r² to r¹¹, the highest power first: with |r| ≤ ½ ln 2 the rest is below 5e-17.
const EXPONENTIAL: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// 2ⁿ and e^r − 1 with e^x = 2ⁿ e^r and |r| ≤ ½ ln 2.
#[inline(always)]
fn scaled_exponential<R: Real>(x: R) -> (R, R) {
    let (low, high) = (R::splat(-700.0), R::splat(700.0));
    let x = R::select(x.below(low), low, x);
    let x = R::select(high.below(x), high, x);
    let shifted = x.mul_add(R::splat(LOG2_E), R::splat(ROUND));
    let n = shifted - R::splat(ROUND);
    let r = n.mul_add(R::splat(-LN_2_LOW), n.mul_add(R::splat(-LN_2_HIGH), x));
    let reduced = (r * r).mul_add(r.polynomial(&EXPONENTIAL), r);
    let scale = shifted.to_bits().shift_up::<52>().plus(R::Bits::splat(1023 << 52));
    (R::from_bits(scale), reduced)
}

/// 1/(1 + m) for ½√2 ≤ m ≤ √2: the best parabola, right to 0.13 %, and three rounds of Newton's.
#[inline(always)]
fn inverse_of_one_plus<R: Real>(m: R) -> R {
    let y = m + R::splat(1.0);
    let mut inverse = y.polynomial(&[0.116_862_890_713_268_52, -0.722_444_113_355_671, 1.477_755_914_724_448_8]);
    for _ in 0..3 {
        let rest = (-y).mul_add(inverse, R::splat(1.0));
        inverse = inverse.mul_add(rest, inverse);
    }
    inverse
}

/// The series of artanh(s)/s − 1 in s², over s².
const LOGARITHM: [f64; 10] = [
    1.0 / 21.0,
    1.0 / 19.0,
    1.0 / 17.0,
    1.0 / 15.0,
    1.0 / 13.0,
    1.0 / 11.0,
    1.0 / 9.0,
    1.0 / 7.0,
    1.0 / 5.0,
    1.0 / 3.0,
];

/// ln u for a positive, finite, normal u.
///
/// Relative error below 5e-16 away from u = 1, absolute error below 3e-16 near it (tested).
#[inline(always)]
pub fn ln<R: Real>(u: R) -> R {
    // u = 2^e m with ½√2 ≤ m < √2: subtracting the bits of ½√2 puts the exponent of m's interval into the high bits, with 1024
    // more to keep it positive, and leaves the place of m in the interval in the low ones.
    const HALF_SQRT_2: u64 = 0x3fe6_a09e_667f_3bcd;
    let place = u.to_bits().plus(R::Bits::splat((1024 << 52) - HALF_SQRT_2));
    let m = R::from_bits((place & R::Bits::splat((1 << 52) - 1)).plus(R::Bits::splat(HALF_SQRT_2)));
    // A small integer becomes a number by way of the rounding constant: no conversion instruction is needed.
    let e = R::from_bits(place.shift_down::<52>().plus(R::Bits::splat(ROUND.to_bits()))) - R::splat(ROUND + 1024.0);
    let s = (m - R::splat(1.0)) * inverse_of_one_plus(m);
    let z = s * s;
    let twice = s + s;
    let ln_m = (twice * z).mul_add(z.polynomial(&LOGARITHM), twice);
    e.mul_add(R::splat(LN_2_HIGH), e.mul_add(R::splat(LN_2_LOW), ln_m))
}

/// 1/√x for a positive, normal x, without square root and division, which take their time one after the other.
///
/// Relative error below 4e-16 (tested); for x = 0 a large number.
#[inline(always)]
pub fn inverse_sqrt<R: Real>(x: R) -> R {
    // Half the exponent, and what then stands in the mantissa, is right to 3.5 %; each round of Newton's squares the error.
    let halved = x.to_bits().shift_down::<1>();
    let mut y = R::from_bits(R::Bits::splat(0x5fe6_eb50_c7b5_37a9).minus(halved));
    let half = x * R::splat(-0.5);
    for _ in 0..3 {
        y = y * (half * y).mul_add(y, R::splat(1.5));
    }
    // The last round as a small correction, so that its rounding hardly counts.
    let rest = (half * y).mul_add(y, R::splat(0.5));
    y.mul_add(rest, y)
}

/// The series of sin(x)/x − 1 in x², over x², to x²¹: with |x| ≤ π/2 the next terms are below 2e-18.
const SINE: [f64; 10] = [
    1.0 / 51_090_942_171_709_440_000.0,
    -1.0 / 121_645_100_408_832_000.0,
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// sin(π/2 · x) for −1 ≤ x ≤ 1. Absolute error below 4e-16 (tested).
#[inline(always)]
pub fn sin_half_pi<R: Real>(x: R) -> R {
    let angle = x * R::splat(FRAC_PI_2);
    let z = angle * angle;
    (angle * z).mul_add(z.polynomial(&SINE), angle)
}

/// cos(2π u) for 0 ≤ u ≤ 1. Absolute error below 1e-15.
pub fn cos_two_pi(u: f64) -> f64 {
    sin_half_pi(4.0 * (u - 0.5).abs() - 1.0)
}

/// x^s for x ≥ 0 and s > 0.
#[inline(always)]
pub fn power<R: Real>(x: R, s: f64) -> R {
    let smallest = R::splat(f64::MIN_POSITIVE);
    let positive = smallest.below(x);
    let value = exp(R::splat(s) * ln(R::select(positive, x, smallest)));
    R::select(positive, value, R::splat(0.0))
}

/// The same in single precision, as random numbers need it.
pub mod single {
    use crate::lanes::{HalfWords, Single};
    use std::f32::consts::{FRAC_PI_2, LN_2};

    /// The series of artanh(s)/s − 1 in s², over s².
    const LOGARITHM: [f32; 4] = [1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0];

    /// The series of sin(x)/x − 1 in x², over x², to x¹¹: with |x| ≤ π/2 the next term is below 6e-8.
    const SINE: [f32; 5] = [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5_040.0, 1.0 / 120.0, -1.0 / 6.0];

    /// ln(u/2ⁿ) for ½ ≤ u ≤ 2ⁿ. Relative error below 4e-7 (tested).
    #[inline(always)]
    pub fn ln_of_fraction<S: Single, const N: u32>(u: S) -> S {
        // As in double precision: u = 2^e m with ½√2 ≤ m < √2.
        const HALF_SQRT_2: u32 = 0x3f35_04f3;
        let place = u.to_bits().plus(S::Bits::splat((64u32 << 23).wrapping_sub(HALF_SQRT_2)));
        let m = S::from_bits((place & S::Bits::splat((1 << 23) - 1)).plus(S::Bits::splat(HALF_SQRT_2)));
        let e = S::from_integers(place.shift_down::<23>()) - S::splat((64 + N) as f32);
        let s = (m - S::splat(1.0)) / (m + S::splat(1.0));
        let z = s * s;
        let twice = s + s;
        e.mul_add(S::splat(LN_2), (twice * z).mul_add(z.polynomial(&LOGARITHM), twice))
    }

    /// sin(π/2 · x) for −1 ≤ x ≤ 1. Absolute error below 3e-7 (tested).
    #[inline(always)]
    pub fn sin_half_pi<S: Single>(x: S) -> S {
        let angle = x * S::splat(FRAC_PI_2);
        let z = angle * angle;
        (angle * z).mul_add(z.polynomial(&SINE), angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(low: f64, high: f64) -> impl Iterator<Item = f64> {
        let n = 200_001;
        (0..n).map(move |k| low + (high - low) * f64::from(k) / f64::from(n - 1))
    }

    #[test]
    fn exponential_agrees_with_the_system_library() {
        for x in grid(-40.0, 1.0).chain(grid(-1e-3, 1e-3)).filter(|x| *x != 0.0) {
            let error = (exp_minus_one(x) / x.exp_m1() - 1.0).abs();
            assert!(error < 4e-16, "x = {x}: relative error {error}");
            assert!((exp(x) / x.exp() - 1.0).abs() < 4e-16, "x = {x}");
        }
        assert_eq!(exp_minus_one(0.0), 0.0);
        assert_eq!(exp_minus_one(-1e9), -1.0);
    }

    #[test]
    fn logarithm_agrees_with_the_system_library() {
        for u in grid(1e-12, 1.0).chain(grid(0.5, 3.0)).chain((1..=52).map(|e| 2f64.powi(-e))) {
            let (value, expected) = (ln(u), u.ln());
            let error = (value - expected).abs() / expected.abs().max(0.6);
            assert!(error < 5e-16, "u = {u}: error {error}");
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn sine_agrees_with_the_system_library() {
        for x in grid(-1.0, 1.0) {
            let error = (sin_half_pi(x) - (FRAC_PI_2 * x).sin()).abs();
            assert!(error < 4e-16, "x = {x}: error {error}");
        }
    }

    #[test]
    fn inverse_square_root_agrees_with_the_system_library() {
        for x in grid(0.25, 4.0).chain(grid(1e-6, 1.0)).chain((-1000..1000).map(|e| 1.37 * 2f64.powi(e))) {
            let error = (inverse_sqrt(x) * x.sqrt() - 1.0).abs();
            assert!(error < 4e-16, "x = {x}: relative error {error}");
        }
    }

    #[test]
    fn single_precision_agrees_with_the_system_library() {
        for k in 0..200_000u32 {
            let u = (k * 10_737) as f32 + 0.5;
            for u in [u, (k + 1) as f32 - 0.5, 2_147_483_648.0 - 128.0 * k as f32] {
                let (value, expected) =
                    (f64::from(single::ln_of_fraction::<_, 31>(u)), (f64::from(u) / 2f64.powi(31)).ln());
                assert!((value - expected).abs() <= 4e-7 * expected.abs(), "u = {u}: {value} for {expected}");
            }
            let x = k as f32 / 100_000.0 - 1.0;
            let error = (f64::from(single::sin_half_pi(x)) - (FRAC_PI_2 * f64::from(x)).sin()).abs();
            assert!(error < 3e-7, "x = {x}: error {error}");
        }
    }

    #[test]
    fn power_agrees_with_the_system_library() {
        for x in grid(1e-9, 1.0) {
            for s in [0.25, 0.5, 1.0, 3.0] {
                let error = (power(x, s) / x.powf(s) - 1.0).abs();
                assert!(error < 1e-14, "x = {x}, s = {s}: relative error {error}");
            }
        }
        assert_eq!(power(0.0, 0.5), 0.0);
    }
}
