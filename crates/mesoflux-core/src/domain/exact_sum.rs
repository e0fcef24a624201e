//! Sums of floating-point numbers that do not depend on the order of their terms.
//!
//! A fixed-point register as wide as the exponent range of `f64` (Kulisch) adds without rounding. Global sums that reach the
//! trajectory go through it, so that neither threads nor ranks nor the storage order of particles leave a trace in the bits.

/// Digits of 32 bits, each in a 64-bit word: 2³⁰ additions fit before a carry must travel.
const DIGITS: usize = 68;

/// An exact sum of `f64` values.
#[derive(Debug, Clone)]
pub struct ExactSum {
    digits: [i64; DIGITS],
    pending: u32,
    finite: bool,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { digits: [0; DIGITS], pending: 0, finite: true }
    }
}

impl ExactSum {
    /// Adds one term, exactly.
    #[inline]
    pub fn add(&mut self, term: f64) {
        let bits = term.to_bits();
        let biased = (bits >> 52) as usize & 0x7ff;
        if biased == 0x7ff {
            self.finite = false;
            return;
        }
        // The value is mantissa · 2^(exponent − 1075) for the digit position `exponent`; subnormals have no hidden bit.
        let hidden = u64::from(biased != 0) << 52;
        let exponent = biased.max(1);
        let mantissa = u128::from((bits & ((1 << 52) - 1)) | hidden) << (exponent & 31);
        let digit = exponent >> 5;
        let sign = 1 - 2 * ((bits >> 63) as i64);
        self.digits[digit] += sign * i64::from(mantissa as u32);
        self.digits[digit + 1] += sign * i64::from((mantissa >> 32) as u32);
        self.digits[digit + 2] += sign * i64::from((mantissa >> 64) as u32);
        self.pending += 1;
        if self.pending == 1 << 30 {
            self.carry();
        }
    }

    /// Adds all terms of another sum, exactly.
    pub fn merge(&mut self, other: &Self) {
        let mut other = other.clone();
        other.carry();
        self.carry();
        for (digit, more) in self.digits.iter_mut().zip(other.digits) {
            *digit += more;
        }
        self.pending = 2;
        self.finite &= other.finite;
    }

    /// Brings every digit but the last into 0 ≤ digit < 2³²; the last carries the sign.
    fn carry(&mut self) {
        let mut carry = 0;
        for digit in &mut self.digits[..DIGITS - 1] {
            let total = *digit + carry;
            *digit = total & 0xffff_ffff;
            carry = total >> 32;
        }
        self.digits[DIGITS - 1] += carry;
        self.pending = 1;
    }

    /// The sum as a number, its error below one unit in the last place; NaN if a term was not finite.
    pub fn value(&self) -> f64 {
        if !self.finite {
            return f64::NAN;
        }
        let mut normal = self.clone();
        normal.carry();
        let negative = normal.digits[DIGITS - 1] < 0;
        if negative {
            normal.digits.iter_mut().for_each(|digit| *digit = -*digit);
            normal.carry();
        }
        let Some(top) = normal.digits.iter().rposition(|&digit| digit != 0) else {
            return 0.0;
        };
        // The four leading digits hold at least 97 bits; the rest cannot change the rounded value by more than its last bit.
        let low = top.saturating_sub(3);
        let leading = (low..=top).rev().fold(0u128, |sum, digit| (sum << 32) | normal.digits[digit] as u128);
        let magnitude = scale(leading as f64, 32 * low as i32 - 1075);
        if negative { -magnitude } else { magnitude }
    }
}

/// value · 2^exponent, in two exact steps so that no intermediate leaves the range of normal numbers too early.
fn scale(value: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    value * 2f64.powi(half) * 2f64.powi(exponent - half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(terms: &[f64]) -> f64 {
        let mut sum = ExactSum::default();
        terms.iter().for_each(|&term| sum.add(term));
        sum.value()
    }

    #[test]
    fn cancellation_leaves_the_exact_rest() {
        assert_eq!(sum(&[1e100, 1.0, -1e100]), 1.0);
        assert_eq!(sum(&[1e300, -1e-300, -1e300]), -1e-300);
        assert_eq!(sum(&[0.1, 0.2, -0.3]), 2.775_557_561_562_891_4e-17);
        assert_eq!(sum(&[]), 0.0);
        assert_eq!(sum(&[5e-324, 5e-324]), 1e-323);
        assert_eq!(sum(&[-2.5]), -2.5);
        assert!(sum(&[1.0, f64::INFINITY]).is_nan());
    }

    #[test]
    fn the_order_and_the_grouping_of_terms_leave_no_trace() {
        let draw = crate::noise::NoiseKey::new(&[1]).draw(crate::noise::Purpose::Start, 0, 0);
        let terms: Vec<f64> =
            (0..5000).map(|k| draw.gaussian(k, 0) * 10f64.powi((draw.uniform(k, 1) * 40.0) as i32 - 20)).collect();
        let forward = sum(&terms);
        let mut reversed = terms.clone();
        reversed.reverse();
        assert_eq!(forward.to_bits(), sum(&reversed).to_bits());
        let mut merged = ExactSum::default();
        for chunk in terms.chunks(77) {
            let mut part = ExactSum::default();
            chunk.iter().for_each(|&term| part.add(term));
            merged.merge(&part);
        }
        assert_eq!(forward.to_bits(), merged.value().to_bits());
        let plain: f64 = terms.iter().sum();
        assert!((forward / plain - 1.0).abs() < 1e-12);
    }
}
