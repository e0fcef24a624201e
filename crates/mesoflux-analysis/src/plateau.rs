//! Which level of a blocking to trust: Jonsson's automatic test, with a margin.

use crate::level::ScalarMoments;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Chance of refusing a level whose blocks are in truth independent.
pub(crate) const SIGNIFICANCE: f64 = 0.02;
/// Levels with fewer blocks aren't tested: their autocorrelation is too far from normally distributed.
const TESTABLE_BLOCKS: u64 = 8;
/// Levels climbed above the first one that passes.
const MARGIN_LEVELS: usize = 2;
/// The margin isn't climbed where it would leave fewer blocks: the error itself would be known too badly.
const MARGIN_BLOCKS: u64 = 16;
/// Levels with fewer blocks are no candidate for the error of a series that is too short, if there are others.
const FALLBACK_BLOCKS: u64 = 4;

/// The level whose blocks are taken as independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Plateau {
    /// The test passed.
    Found(usize),
    /// No level passed: this one has the largest variance of the mean.
    TooShort(usize),
    /// Fewer than two blocks at every level.
    NoData,
}

impl ScalarMoments {
    /// Variance of the mean of a series of `samples` values from blocks of 2^`level` values, taken as independent:
    /// 2^level s²/samples with s² = Σ (y − ȳ)²/(n − 1), n the number of blocks.
    ///
    /// Values that didn't fill a block count in `samples`: they are in the mean, too.
    pub(crate) fn variance_of_mean(&self, level: usize, samples: u64) -> f64 {
        self.squares / (self.blocks as f64 - 1.0) * 2f64.powi(level as i32) / samples as f64
    }

    /// Square of the lag-one autocorrelation of the blocks in units of its standard deviation under independence.
    ///
    /// With n blocks and p pairs of neighbors, `r = lag_products/squares` has mean −p/(n(n−1)) and variance
    /// p(n−2)²/(n(n−1))² (Moran, Biometrika 35, 255 (1948), for one series, where p = n−1).
    fn squared_score(&self) -> f64 {
        // A constant series has no fluctuations that could be correlated.
        if self.squares <= 0.0 {
            return 0.0;
        }
        let (n, p) = (self.blocks as f64, self.pairs as f64);
        let excess = self.lag_products / self.squares + p / (n * (n - 1.0));
        excess * excess * (n * (n - 1.0) / (n - 2.0)).powi(2) / p
    }

    /// Enough blocks, most of which have a neighbor (replicas have none across the seam).
    fn testable(&self) -> bool {
        self.blocks >= TESTABLE_BLOCKS && 2 * self.pairs >= self.blocks
    }
}

/// Applies the rule documented at [`Blocking`](crate::Blocking) to the levels, the shortest blocks first.
///
/// Blocks shorter than `minimum_block_length` are passed over as long as [`MARGIN_BLOCKS`] remain.
pub(crate) fn find(levels: &[ScalarMoments], samples: u64, minimum_block_length: u64) -> Plateau {
    let mut statistic = 0.0;
    let mut tested = 0.0;
    let mut first = None;
    for (index, level) in levels.iter().enumerate().rev().filter(|(_, level)| level.testable()) {
        statistic += level.squared_score();
        tested += 1.0;
        if statistic < chi_squared_quantile(tested) {
            first = Some(index);
        }
    }
    if let Some(first) = first {
        let has_room = |&index: &usize| levels[index].blocks >= MARGIN_BLOCKS;
        let target = (first + MARGIN_LEVELS).max(minimum_block_length.next_power_of_two().ilog2() as usize);
        let climbed = (first + 1..levels.len().min(target + 1)).take_while(has_room).last();
        return Plateau::Found(climbed.unwrap_or(first));
    }
    let largest = |at_least: u64| {
        let candidates = levels.iter().enumerate().filter(|(_, level)| level.blocks >= at_least);
        let by_variance = candidates.map(|(index, level)| (index, level.variance_of_mean(index, samples)));
        by_variance.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    };
    largest(FALLBACK_BLOCKS).or_else(|| largest(2)).map_or(Plateau::NoData, Plateau::TooShort)
}

fn chi_squared_quantile(degrees_of_freedom: f64) -> f64 {
    ChiSquared::new(degrees_of_freedom).map_or(0.0, |distribution| distribution.inverse_cdf(1.0 - SIGNIFICANCE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(blocks: u64, correlation: f64) -> ScalarMoments {
        let squares = blocks as f64 - 1.0;
        ScalarMoments { blocks, pairs: blocks - 1, squares, lag_products: correlation * squares }
    }

    #[test]
    fn climbs_two_levels_above_the_first_that_passes() {
        let levels = [level(4096, 0.9), level(2048, 0.5), level(1024, 0.0), level(512, 0.0), level(256, 0.0)];
        assert_eq!(find(&levels, 4096, 1), Plateau::Found(4));
        assert_eq!(find(&levels[..4], 4096, 1), Plateau::Found(3));
    }

    #[test]
    fn a_short_series_keeps_enough_blocks() {
        assert_eq!(find(&[level(40, 0.0), level(20, 0.0), level(10, 0.0), level(5, 0.0)], 40, 1), Plateau::Found(1));
    }

    #[test]
    fn a_minimum_block_length_is_respected_where_blocks_remain() {
        let levels = [level(1024, 0.0), level(512, 0.0), level(256, 0.0), level(128, 0.0), level(64, 0.0)];
        assert_eq!(find(&levels, 1024, 9), Plateau::Found(4));
        assert_eq!(find(&levels, 1024, 8), Plateau::Found(3));
        assert_eq!(find(&levels, 1024, 1000), Plateau::Found(4));
    }

    #[test]
    fn correlation_at_the_last_tested_level_means_too_short() {
        let levels = [level(32, 0.9), level(16, 0.9), level(8, 0.9), level(4, 0.0), level(2, 0.0)];
        assert_eq!(find(&levels, 32, 1), Plateau::TooShort(3));
        assert_eq!(find(&[level(1, 0.0)], 1, 1), Plateau::NoData);
    }
}
