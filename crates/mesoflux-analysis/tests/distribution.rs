//! p-values of true hypotheses are uniform, those of false ones small; accumulators can be stored.
#![allow(clippy::unwrap_used)] // Helpers of tests unwrap as tests do.

mod common;

use common::Random;
use mesoflux_analysis::{
    Blocking, MeanSquaredDisplacement, chi_squared_p_value, kolmogorov_smirnov_p_value, maxwell_speed_cdf, normal_cdf,
    standard_normal_summary,
};

fn speeds(count: usize, variance: f64, random: &mut Random) -> Vec<f64> {
    let squares = (0..count).map(|_| (0..3).map(|_| random.normal().powi(2)).sum::<f64>());
    let mut speeds: Vec<f64> = squares.map(|square| (variance * square).sqrt()).collect();
    speeds.sort_by(f64::total_cmp);
    speeds
}

/// p-values of 500 trials are themselves a sample of the uniform distribution.
fn assert_uniform(mut p_values: Vec<f64>) {
    p_values.sort_by(f64::total_cmp);
    let p = kolmogorov_smirnov_p_value(&p_values, |p| p.clamp(0.0, 1.0)).unwrap();
    assert!(p > 0.001, "{p}");
}

#[test]
fn maxwell_speeds_pass_and_hot_ones_fail() {
    let p = |seed: u64, variance: f64| {
        let sample = speeds(500, variance, &mut Random::new(seed));
        kolmogorov_smirnov_p_value(&sample, |speed| maxwell_speed_cdf(speed, 1.0)).unwrap()
    };
    assert_uniform((0..500).map(|seed| p(seed, 1.0)).collect());
    assert!((0..20).all(|seed| p(seed, 1.3) < 0.01));
}

#[test]
fn counts_pass_and_biased_ones_fail() {
    let p = |seed: u64, variance: f64| {
        let sample = speeds(1000, variance, &mut Random::new(seed));
        let edges: Vec<f64> = (0..=20).map(|k| 0.25 * f64::from(k)).collect();
        let counts = |(low, high): (f64, f64)| sample.iter().filter(|&&v| low <= v && v < high).count() as f64;
        let expected = |(low, high): (f64, f64)| 1000.0 * (maxwell_speed_cdf(high, 1.0) - maxwell_speed_cdf(low, 1.0));
        let bins: Vec<(f64, f64)> = edges.windows(2).map(|pair| (pair[0], pair[1])).collect();
        let observed: Vec<f64> = bins.iter().map(|&bin| counts(bin)).collect();
        let expected: Vec<f64> = bins.iter().map(|&bin| expected(bin)).collect();
        chi_squared_p_value(&observed, &expected, 1).unwrap()
    };
    assert_uniform((0..500).map(|seed| p(seed, 1.0)).collect());
    assert!((0..20).all(|seed| p(seed, 1.3) < 0.01));
}

#[test]
fn summary_of_normal_scores() {
    let summary = |seed: u64, factor: f64, shift: f64| {
        let mut random = Random::new(seed);
        let scores: Vec<f64> = (0..100).map(|_| shift + factor * random.normal()).collect();
        standard_normal_summary(&scores).unwrap()
    };
    assert_uniform((0..500).map(|seed| summary(seed, 1.0, 0.0).mean_p_value).collect());
    assert_uniform((0..500).map(|seed| summary(seed, 1.0, 0.0).variance_p_value).collect());
    assert_uniform((0..500).map(|seed| summary(seed, 1.0, 0.0).largest_p_value).collect());
    assert_uniform((0..500).map(|seed| summary(seed, 1.0, 0.0).shape_p_value).collect());
    assert!(summary(1, 1.0, 1.0).mean_p_value < 1e-6);
    assert!(summary(1, 2.0, 0.0).variance_p_value < 1e-6);
    assert!(summary(1, 3.0, 0.0).largest_p_value < 1e-3);
    assert!((normal_cdf(0.0) - 0.5).abs() < 1e-15);
}

#[test]
fn accumulators_can_be_stored() {
    fn stored<T: serde::Serialize + serde::de::DeserializeOwned>() {}
    stored::<Blocking>();
    stored::<MeanSquaredDisplacement>();
}
