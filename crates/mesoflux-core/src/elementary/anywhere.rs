//! Functions for any argument: no number where they are undefined, for those who can't promise where they are called.

use super::{ROUND, exp, exp_minus_one, inverse_sqrt, ln, nearest_integer};
use crate::lanes::{Real, Words};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// What π/2 in double precision lacks.
const FRAC_PI_2_LOW: f64 = 6.123_233_995_736_766e-17;

/// The series of sin(x)/x − 1 in x², over x², to x¹⁷: with |x| ≤ π/4 the next terms are below 1e-19.
const SINE: [f64; 8] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// The series of cos(x) − 1 in x², over x², to x¹⁶.
const COSINE: [f64; 8] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -0.5,
];

/// sin(x + quarters · π/2) for |x| < 10⁹, no number beyond. Absolute error below 4e-16 (tested).
#[inline(always)]
pub fn sine_ahead<R: Real>(x: R, quarters: u64) -> R {
    // The number of quarters nearest to x stands in the low bits of the shifted number; what is left is exact but for its last bit.
    let shifted = x.mul_add(R::splat(FRAC_2_PI), R::splat(ROUND));
    let n = shifted - R::splat(ROUND);
    let rest = n.mul_add(R::splat(-FRAC_PI_2_LOW), n.mul_add(R::splat(-FRAC_PI_2), x));
    let square = rest * rest;
    let sine = (rest * square).mul_add(square.polynomial(&SINE), rest);
    let cosine = square.mul_add(square.polynomial(&COSINE), R::splat(1.0));
    let quarter = shifted.to_bits().plus(R::Bits::splat(quarters));
    let is_odd = R::from_bits((quarter & R::Bits::splat(1)).shift_up::<62>());
    let sign = (quarter & R::Bits::splat(2)).shift_up::<62>();
    let value = R::select(R::splat(0.0).below(is_odd), cosine, sine);
    let value = R::from_bits(value.to_bits() ^ sign);
    // Beyond, the number of quarters has too many digits for what is left to mean anything.
    R::select(absolute(x).below(R::splat(1e9)), value, R::splat(f64::NAN))
}

/// |x|.
#[inline(always)]
pub fn absolute<R: Real>(x: R) -> R {
    R::from_bits(x.to_bits() & R::Bits::splat(u64::MAX >> 1))
}

/// tanh x. Relative error below 1e-15 (tested).
#[inline(always)]
pub fn hyperbolic_tangent<R: Real>(x: R) -> R {
    let m = exp_minus_one(R::splat(-2.0) * absolute(x));
    let size = -m / (m + R::splat(2.0));
    R::from_bits(size.to_bits() | (x.to_bits() & R::Bits::splat(1 << 63)))
}

/// ln x; −∞ at zero and, as if they were zero, below the smallest normal number; no number for x < 0.
#[inline(always)]
pub fn logarithm<R: Real>(x: R) -> R {
    let zero = R::splat(0.0);
    let value = R::select(absolute(x).below(R::splat(f64::INFINITY)), ln(x), x);
    let value = R::select(x.below(R::splat(f64::MIN_POSITIVE)), R::splat(f64::NEG_INFINITY), value);
    R::select(x.below(zero), R::splat(f64::NAN), value)
}

/// √x; zero below the smallest normal number; no number for x < 0. Relative error below 4e-16.
#[inline(always)]
pub fn square_root<R: Real>(x: R) -> R {
    let zero = R::splat(0.0);
    let value = R::select(x.below(R::splat(f64::MIN_POSITIVE)), zero, x * inverse_sqrt(x));
    R::select(x.below(zero), R::splat(f64::NAN), value)
}

/// x^s for x ≥ 0 and any s; no number for x < 0.
#[inline(always)]
pub fn real_power<R: Real>(x: R, s: R) -> R {
    let zero = R::splat(0.0);
    let at_zero = R::select(zero.below(s), zero, R::select(s.below(zero), R::splat(f64::INFINITY), R::splat(1.0)));
    let logarithm = logarithm(x);
    let value = exp(s * logarithm);
    R::select(logarithm.below(R::splat(f64::MIN)), at_zero, value)
}

/// x − L ⌊x/L⌋ for |x/L| < 2⁵¹: from 0 to L, rounding may leave L itself.
#[inline(always)]
pub fn wrapped<R: Real>(x: R, side: f64) -> R {
    let copies = x * R::splat(1.0 / side);
    let nearest = nearest_integer(copies);
    let below = R::select(copies.below(nearest), nearest - R::splat(1.0), nearest);
    let wrapped = (-below).mul_add(R::splat(side), x);
    let (zero, side) = (R::splat(0.0), R::splat(side));
    let wrapped = R::select(wrapped.below(zero), zero, wrapped);
    R::select(side.below(wrapped), side, wrapped)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(low: f64, high: f64) -> impl Iterator<Item = f64> {
        let n = 100_001;
        (0..n).map(move |k| low + (high - low) * f64::from(k) / f64::from(n - 1))
    }

    fn sine(x: f64) -> f64 {
        sine_ahead(x, 0)
    }

    fn cosine(x: f64) -> f64 {
        sine_ahead(x, 1)
    }

    #[test]
    fn sine_and_cosine_agree_with_the_system_library() {
        for x in grid(-10.0, 10.0).chain(grid(-1e5, 1e5)).chain(grid(9e8, 9.9e8)) {
            assert!((sine(x) - x.sin()).abs() < 4e-16, "sin {x}");
            assert!((cosine(x) - x.cos()).abs() < 4e-16, "cos {x}");
        }
        assert_eq!((sine(0.0), cosine(0.0)), (0.0, 1.0));
        assert!((sine(std::f64::consts::PI) / std::f64::consts::PI.sin() - 1.0).abs() < 1e-15, "what π lacks");
        assert!(sine(1e9).is_nan() && cosine(f64::NAN).is_nan() && sine(f64::NEG_INFINITY).is_nan());
    }

    #[test]
    fn hyperbolic_tangent_agrees_with_the_system_library() {
        for x in grid(-25.0, 25.0).chain(grid(-1e-3, 1e-3)).filter(|x| *x != 0.0) {
            assert!((hyperbolic_tangent(x) / x.tanh() - 1.0).abs() < 1e-15, "{x}: {}", hyperbolic_tangent(x));
        }
        assert_eq!((hyperbolic_tangent(0.0), hyperbolic_tangent(1e300), hyperbolic_tangent(-1e300)), (0.0, 1.0, -1.0));
        assert!(hyperbolic_tangent(f64::NAN).is_nan());
    }

    #[test]
    fn what_is_undefined_is_no_number() {
        assert!(logarithm(-1.0).is_nan() && logarithm(f64::NAN).is_nan());
        assert_eq!((logarithm(0.0), logarithm(f64::INFINITY)), (f64::NEG_INFINITY, f64::INFINITY));
        assert!(square_root(-1e-300).is_nan() && square_root(f64::NAN).is_nan());
        assert_eq!((square_root(0.0), square_root(-0.0)), (0.0, 0.0));
        assert!(real_power(-1.0, 2.5).is_nan() && real_power(f64::NAN, 1.0).is_nan());
        assert_eq!((real_power(0.0, 0.3), real_power(0.0, -0.3), real_power(0.0, 0.0)), (0.0, f64::INFINITY, 1.0));
        for x in grid(1e-3, 100.0) {
            assert!((logarithm(x) - x.ln()).abs() <= 5e-16 * x.ln().abs().max(0.6), "ln {x}");
            assert!((square_root(x) / x.sqrt() - 1.0).abs() < 5e-16, "√{x}");
            assert!((real_power(x, -1.7) / x.powf(-1.7) - 1.0).abs() < 1e-14, "{x}^−1.7");
        }
    }

    #[test]
    fn wrapped_coordinates_lie_in_the_box() {
        for x in grid(-30.0, 30.0) {
            let found = wrapped(x, 2.7);
            assert!((0.0..=2.7).contains(&found), "{x} to {found}");
            let copies = (x - found) / 2.7;
            assert!((copies - copies.round()).abs() < 1e-13, "{x} to {found}");
        }
        assert_eq!((wrapped(1.0, 2.7), wrapped(0.0, 2.7)), (1.0, 0.0));
    }
}
