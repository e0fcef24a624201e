//! Medians and spreads of a handful of timings.

use serde::{Deserialize, Serialize};

/// The median, the smallest and the largest of several numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The one in the middle.
    pub median: f64,
    /// The smallest.
    pub smallest: f64,
    /// The largest.
    pub largest: f64,
}

impl Spread {
    /// Of numbers that are all finite, one at least.
    pub fn of(numbers: &[f64]) -> Self {
        let extreme = |choose: fn(f64, f64) -> f64| numbers.iter().copied().reduce(choose).unwrap_or(f64::NAN);
        Self { median: median(numbers), smallest: extreme(f64::min), largest: extreme(f64::max) }
    }
}

/// The middle of the sorted numbers; of an even count, the mean of the two in the middle.
pub fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => sorted[middle],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_one_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Spread { median: 2.0, smallest: 1.0, largest: 3.0 });
    }
}
