//! Calibration of the errors found by blocking, on series whose exact errors are known.

mod common;

use common::{Autoregressive, Random, recorded_autoregressive};
use mesoflux_analysis::{Blocking, Estimate};

const TRIALS: u64 = 1000;

fn contains(estimate: &Estimate, truth: f64) -> bool {
    estimate.interval(0.95).is_some_and(|(low, high)| low <= truth && truth <= high)
}

/// Share of trials whose 95 % interval contains the truth.
fn coverage(mut trial: impl FnMut(&mut Random) -> (Estimate, f64)) -> f64 {
    let hits = (0..TRIALS).filter(|&seed| {
        let (estimate, truth) = trial(&mut Random::new(seed));
        contains(&estimate, truth)
    });
    hits.count() as f64 / TRIALS as f64
}

#[test]
fn intervals_cover_the_mean_of_autoregressive_series() {
    for memory in [0.0, 0.5, 0.9, 0.97] {
        for length in [1 << 14, 11_000] {
            let share = coverage(|random| (recorded_autoregressive(memory, length, random).estimate(), 0.0));
            assert!((0.93..=0.97).contains(&share), "memory {memory}, length {length}: {share}");
        }
    }
}

#[test]
fn intervals_cover_for_pooled_replicas() {
    for memory in [0.0, 0.9, 0.97] {
        let share = coverage(|random| {
            let mut pooled = recorded_autoregressive(memory, 1 << 12, random);
            for _ in 1..4 {
                pooled.merge(&recorded_autoregressive(memory, 1 << 12, random)).unwrap();
            }
            (pooled.estimate(), 0.0)
        });
        assert!((0.93..=0.97).contains(&share), "memory {memory}: {share}");
    }
}

/// The interval from independent samples of equal number shows that the tests above can fail.
#[test]
fn errors_without_blocking_would_not_cover() {
    let share = coverage(|random| {
        let blocking = recorded_autoregressive(0.9, 1 << 12, random);
        let naive = blocking.variance_of_mean_by_level(&[1.0]).unwrap()[0];
        (Estimate::new(blocking.mean().unwrap()[0], naive.variance_of_mean.sqrt(), naive.blocks as f64), 0.0)
    });
    assert!(share < 0.5, "{share}");
}

#[test]
fn white_noise_has_the_textbook_error() {
    let (length, trials) = (10_000, 200);
    let mean_square: f64 = (0..trials)
        .map(|seed| recorded_autoregressive(0.0, length, &mut Random::new(seed)).estimate().standard_error.unwrap())
        .map(|error| error * error * length as f64 / trials as f64)
        .sum();
    assert!((mean_square - 1.0).abs() < 0.03, "{mean_square}");
}

#[test]
fn correlation_time_of_an_autoregressive_series() {
    for memory in [0.0, 0.9] {
        let exact = 0.5 * (1.0 + memory) / (1.0 - memory);
        let mean: f64 = (0..100)
            .map(|seed| recorded_autoregressive(memory, 1 << 15, &mut Random::new(seed)).correlation_time(&[1.0]))
            .map(|time| time.value.unwrap() / exact / 100.0)
            .sum();
        assert!((mean - 1.0).abs() < 0.05, "memory {memory}: {mean}");
    }
}

#[test]
fn a_huge_mean_costs_no_digits() {
    let mut plain = Blocking::new(1).unwrap();
    let mut shifted = Blocking::new(1).unwrap();
    let mut random = Random::new(1);
    let mut series = Autoregressive::new(0.9, &mut random);
    for _ in 0..5000 {
        // Multiples of 2^-20 are exact beside 2^30, so that both series hold the same numbers.
        let value = (series.next(&mut random) * 1_048_576.0).round() / 1_048_576.0;
        plain.record(&[value]).unwrap();
        shifted.record(&[value + 1_073_741_824.0]).unwrap();
    }
    let (plain, shifted) = (plain.estimate(), shifted.estimate());
    assert!((plain.standard_error.unwrap() / shifted.standard_error.unwrap() - 1.0).abs() < 1e-9);
    assert!((shifted.value.unwrap() - 1_073_741_824.0 - plain.value.unwrap()).abs() < 1e-6);
}

#[test]
fn a_linear_functional_equals_the_recorded_combination() {
    let mut random = Random::new(3);
    let (mut slow, mut fast) = (Autoregressive::new(0.95, &mut random), Autoregressive::new(0.2, &mut random));
    let (mut vector, mut scalar) = (Blocking::new(2).unwrap(), Blocking::new(1).unwrap());
    for _ in 0..3000 {
        let (a, b) = (slow.next(&mut random), fast.next(&mut random));
        vector.record(&[a + b, b - 3.0]).unwrap();
        scalar.record(&[2.0 * (a + b) - 0.5 * (b - 3.0)]).unwrap();
    }
    let (functional, direct) = (vector.linear(&[2.0, -0.5]), scalar.estimate());
    assert!((functional.value.unwrap() - direct.value.unwrap()).abs() < 1e-12);
    assert!((functional.standard_error.unwrap() / direct.standard_error.unwrap() - 1.0).abs() < 1e-9);
    assert_eq!(functional.effective_samples, direct.effective_samples);
}

#[test]
fn ratios_and_functions_are_calibrated() {
    // x = 2y + z with ⟨y⟩ = 5: strongly correlated, so independent errors would be far too large.
    let record = |random: &mut Random| {
        let mut blocking = Blocking::new(2).unwrap();
        let (mut y, mut z) = (Autoregressive::new(0.9, random), Autoregressive::new(0.5, random));
        for _ in 0..4096 {
            let denominator = 5.0 + y.next(random);
            blocking.record(&[2.0 * denominator + 0.1 * z.next(random), denominator]).unwrap();
        }
        blocking
    };
    let ratio = coverage(|random| (record(random).ratio(0, 1), 2.0));
    assert!((0.93..=0.97).contains(&ratio), "{ratio}");
    let product = coverage(|random| (record(random).function(|m| m[0] * m[1], |m| vec![m[1], m[0]]), 50.0));
    assert!((0.93..=0.97).contains(&product), "{product}");
    let blocking = record(&mut Random::new(0));
    let as_function = blocking.function(|m| m[0] / m[1], |m| vec![1.0 / m[1], -m[0] / (m[1] * m[1])]);
    let relative = as_function.standard_error.unwrap() / blocking.ratio(0, 1).standard_error.unwrap();
    assert!((relative - 1.0).abs() < 1e-9);
}

#[test]
fn a_trend_is_too_short() {
    let mut blocking = Blocking::new(1).unwrap();
    (0..1000).for_each(|n| blocking.record(&[f64::from(n)]).unwrap());
    let estimate = blocking.estimate();
    assert!(estimate.warnings[0].starts_with("too short"), "{:?}", estimate.warnings);
    assert!(estimate.standard_error.unwrap() > 90.0);
}

#[test]
fn replicas_that_disagree_show_in_the_error() {
    // Within each replica the values scatter by 1; the replicas' means scatter by 10.
    let mut pooled = Blocking::new(1).unwrap();
    let mut random = Random::new(8);
    for level in [-10.0, 10.0, -9.0, 11.0, -12.0, 8.0, 9.0, -10.0] {
        let mut replica = Blocking::new(1).unwrap();
        (0..1024).for_each(|_| replica.record(&[level + random.normal()]).unwrap());
        pooled.merge(&replica).unwrap();
    }
    // The scatter of eight means of ±10 gives an error of about 10/√7.
    let error = pooled.estimate().standard_error.unwrap();
    assert!((error - 3.8).abs() < 0.3, "{error}");
}

#[test]
fn the_blocking_plot_rises_to_the_plateau() {
    let blocking = recorded_autoregressive(0.9, 1 << 16, &mut Random::new(5));
    let levels = blocking.variance_of_mean_by_level(&[1.0]).unwrap();
    assert_eq!((levels[0].blocks, levels[3].block_length, levels.last().unwrap().blocks), (1 << 16, 8, 2));
    let plateau = 19.0 / f64::from(1 << 16);
    assert!((levels[8].variance_of_mean - plateau).abs() < 3.0 * levels[8].standard_error);
    assert!(levels[0].variance_of_mean < 0.1 * plateau);
}
