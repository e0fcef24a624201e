//! Histograms: counts by hand, densities of known distributions, errors of correlated series.

#![allow(clippy::unwrap_used)] // Only tests call these functions.

mod common;

use common::{Autoregressive, Random};
use mesoflux_analysis::{AnalysisError, Estimate, Histogram, normal_cdf};

fn recorded(memory: f64, length: usize, seed: u64) -> Histogram {
    let mut random = Random::new(seed);
    let mut series = Autoregressive::new(memory, &mut random);
    let mut histogram = Histogram::new(-2.0, 2.0, 8).unwrap();
    (0..length).for_each(|_| histogram.record(series.next(&mut random)).unwrap());
    histogram
}

fn exact(low: f64, high: f64) -> f64 {
    (normal_cdf(high) - normal_cdf(low)) / (high - low)
}

#[test]
fn every_value_is_counted_once() {
    let mut histogram = Histogram::new(0.0, 1.0, 4).unwrap();
    for value in [-0.1, 0.0, 0.24, 0.25, 0.999_999_999_999_999_9, 1.0, f64::INFINITY, f64::NEG_INFINITY] {
        histogram.record(value).unwrap();
    }
    assert!(histogram.record(f64::NAN).is_err());
    let bins = histogram.bins();
    assert_eq!(bins.iter().map(|bin| bin.count).collect::<Vec<_>>(), [2, 1, 0, 1]);
    assert_eq!((histogram.underflow(), histogram.overflow(), histogram.count()), (2, 2, 8));
    assert_eq!((bins[1].low, bins[1].high, bins[0].density.value), (0.25, 0.5, Some(1.0)));
}

#[test]
fn densities_of_correlated_series_are_covered() {
    for memory in [0.0, 0.95] {
        let (mut hits, mut number) = (0, 0);
        for seed in 0..200 {
            for bin in recorded(memory, 8000, seed).bins() {
                let truth = exact(bin.low, bin.high);
                hits += u32::from(bin.density.interval(0.95).is_some_and(|(low, high)| low < truth && truth < high));
                number += 1;
            }
        }
        let share = f64::from(hits) / f64::from(number);
        assert!((0.93..=0.97).contains(&share), "{memory}: {share}");
    }
}

#[test]
fn counting_errors_of_independent_values_would_not_cover() {
    let histogram = recorded(0.95, 8000, 1);
    let density = &histogram.bins()[3].density;
    let poisson = (density.value.unwrap() / 0.5 / 8000.0).sqrt();
    assert!(density.standard_error.unwrap() > 2.0 * poisson);
}

#[test]
fn a_linear_functional_is_a_probability() {
    let histogram = recorded(0.5, 50_000, 2);
    let positive = histogram.linear(&[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
    assert!(positive.z_score_against(normal_cdf(2.0) - 0.5, 0.0).unwrap().abs() < 3.0, "{positive:?}");
    assert!(histogram.linear(&[1.0]).is_err());
}

#[test]
fn merging_pools_counts_and_keeps_replicas_apart() {
    let (left, right) = (recorded(0.9, 5000, 3), recorded(0.9, 4000, 4));
    let mut merged = left.clone();
    merged.merge(&right).unwrap();
    for ((merged, left), right) in merged.bins().iter().zip(left.bins()).zip(right.bins()) {
        assert_eq!(merged.count, left.count + right.count);
    }
    assert_eq!((merged.count(), merged.underflow()), (9000, left.underflow() + right.underflow()));
}

#[test]
fn a_trend_is_too_short() {
    let mut histogram = Histogram::new(0.0, 1000.0, 2).unwrap();
    (0..1000).for_each(|n| histogram.record(f64::from(n)).unwrap());
    let density: &Estimate = &histogram.bins()[0].density;
    assert!(density.warnings[0].starts_with("too short"), "{density:?}");
    assert!(Histogram::new(0.0, 1.0, 1).unwrap().bins()[0].density.value.is_none());
}

#[test]
fn other_ranges_are_refused() {
    assert!(Histogram::new(0.0, 1.0, 0).is_err());
    assert!(Histogram::new(1.0, 1.0, 3).is_err());
    assert!(Histogram::new(f64::NAN, 1.0, 3).is_err());
    assert!(Histogram::new(0.0, f64::INFINITY, 3).is_err());
    assert!(Histogram::new(-f64::MAX, f64::MAX, 3).is_err());
    assert!(Histogram::new(1.0, 1.0 + 1e-15, 1000).is_err());
    let histogram = recorded(0.0, 100, 1);
    assert!(Histogram::new(-2.0, 2.0, 8).unwrap().accepts(&histogram));
    for other in [Histogram::new(-2.0, 2.0, 9).unwrap(), Histogram::new(-2.0, 3.0, 8).unwrap()] {
        assert!(!other.accepts(&histogram));
        assert!(matches!(histogram.clone().merge(&other), Err(AnalysisError::Mismatch { .. })));
    }
}
