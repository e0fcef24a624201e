//! Correlators against direct sums: exact numbers, order, merging, states.

#![allow(clippy::unwrap_used)] // Only tests call these functions.

mod common;

use common::{Autoregressive, Exponentials, Random, Rotating};
use mesoflux_analysis::{AnalysisError, Estimate, IntegralOptions, MultipleTau, Quadrature, full_correlation};

const LENGTH: usize = 5000;

/// Two correlated channels.
fn rotating(length: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    let mut process = Rotating::new(0.05, 0.1, &mut random);
    (0..length).map(|_| process.next(&mut random)).collect()
}

fn channel(series: &[[f64; 2]], index: usize) -> Vec<f64> {
    series.iter().map(|sample| sample[index]).collect()
}

fn recorded(mut correlator: MultipleTau, series: &[[f64; 2]]) -> MultipleTau {
    series.iter().for_each(|sample| correlator.record(sample).unwrap());
    correlator
}

fn direct(later: &[f64], earlier: &[f64], lag: usize) -> f64 {
    let products: f64 = later[lag..].iter().zip(earlier).map(|(later, earlier)| later * earlier).sum();
    products / (later.len() - lag) as f64
}

fn block_averages(series: &[f64], length: usize) -> Vec<f64> {
    series.chunks_exact(length).map(|block| block.iter().sum::<f64>() / length as f64).collect()
}

#[test]
fn the_transform_equals_direct_sums_in_order() {
    let series = rotating(777, 1);
    let (x, y) = (channel(&series, 0), channel(&series, 1));
    let correlation = full_correlation(&y, &x, 777).unwrap();
    for lag in [0, 1, 2, 100, 500, 776] {
        assert!((correlation[lag] - direct(&y, &x, lag)).abs() < 1e-12, "{lag}");
    }
    // y follows x: a quarter of a period later they agree, a quarter before they are opposite.
    assert!(correlation[10] > 0.2 && full_correlation(&x, &y, 20).unwrap()[10] < -0.2);
    assert_eq!(full_correlation(&x, &y, 0).unwrap(), []);
    assert!(full_correlation(&x, &y[1..], 3).is_err());
    assert!(full_correlation(&x, &y, 778).is_err());
    assert!(full_correlation(&[f64::NAN], &[1.0], 1).is_err());
}

#[test]
fn every_lag_of_every_level_is_that_of_block_averages() {
    let series = rotating(LENGTH, 2);
    let (x, y) = (channel(&series, 0), channel(&series, 1));
    let correlator = recorded(MultipleTau::new(2, &[[1, 0]], 1.0).unwrap(), &series);
    let table = correlator.table(Quadrature::Summed);
    assert!(table.last().unwrap().time >= 56.0, "three levels");
    for point in table {
        let lag = point.time as usize;
        let block = if lag < 16 { 1 } else { 1 << (lag.ilog2() - 3) };
        let (x, y) = (block_averages(&x, block), block_averages(&y, block));
        let exact = full_correlation(&y, &x, 16).unwrap()[lag / block];
        assert!((point.correlation.value.unwrap() - exact).abs() < 1e-12, "{lag}");
    }
}

/// Blocks begin at every B-th sample; over all B ways to cut a series into blocks, the triangle is exact.
#[test]
fn higher_levels_are_the_correlation_smeared_with_a_triangle() {
    let mut series = rotating(2048, 3);
    // With zeros at both ends no product hangs over them, however the series is cut.
    series[..256].fill([0.0; 2]);
    series[1792..].fill([0.0; 2]);
    let (x, y) = (channel(&series, 0), channel(&series, 1));
    let products = |lag: usize| direct(&y, &x, lag) * (2048 - lag) as f64;
    for (block, lag) in [(2, 16), (2, 30), (4, 32), (4, 52), (8, 72)] {
        let mut sum = 0.0;
        for offset in 0..block {
            series.rotate_left(usize::from(offset > 0));
            let correlator = recorded(MultipleTau::new(2, &[[1, 0]], 1.0).unwrap(), &series);
            // 64 segments of 32 samples are too few for an error at these lags; two replicas more are enough.
            let mut pooled = correlator.clone();
            (1..10).for_each(|_| pooled.merge(&correlator).unwrap());
            let table = pooled.table(Quadrature::Summed);
            let point = table.iter().find(|point| point.time == lag as f64).unwrap();
            sum += point.correlation.value.unwrap() * (2048 / block - lag / block) as f64;
        }
        series.rotate_right(block - 1);
        let height = |t: usize| (1.0 - t.abs_diff(lag) as f64 / block as f64) / block as f64;
        let smeared: f64 = (lag - block..lag + block).map(|t| height(t) * products(t)).sum();
        assert!((sum - smeared).abs() < 1e-9 * smeared.abs().max(1.0), "{block}, {lag}: {sum} {smeared}");
    }
}

/// ⟨ΔG²⟩/2 over all stretches of a periodic series is the window 1 − t'/t on its correlation, with half of C(0).
#[test]
fn integral_and_helfand_windows_are_sums_over_all_lags() {
    let series = rotating(LENGTH, 4);
    let (x, spacing) = (channel(&series, 0), 0.25);
    let correlator = recorded(MultipleTau::new(2, &[[0, 0]], spacing).unwrap(), &series);
    let correlation = full_correlation(&x, &x, 200).unwrap();
    for (index, point) in correlator.table(Quadrature::Summed).iter().enumerate() {
        let lag = (point.time / spacing).round() as usize;
        let weight = |t: usize| if t == 0 { 0.5 } else { 1.0 };
        let window = |t: usize| (2.0 - 2.0 * t as f64 / lag as f64).min(1.0);
        let integral: f64 = (0..lag).map(|t| spacing * weight(t) * window(t) * correlation[t]).sum();
        let helfand: f64 = (0..lag).map(|t| spacing * spacing * weight(t) * (lag - t) as f64 * correlation[t]).sum();
        // Level 0 takes every product; higher ones take those that blocks hold, with the same expectation.
        let tolerance = if index < 16 { 1e-11 } else { 2e-3 };
        assert!((point.integral.value.unwrap() - integral).abs() < tolerance * (1.0 + integral.abs()), "{lag}");
        assert!((point.helfand.value.unwrap() - helfand).abs() < tolerance * (1.0 + helfand.abs()), "{lag}");
    }
    let first = &correlator.table(Quadrature::Summed)[1];
    assert!((first.helfand.value.unwrap() - 0.5 * spacing * spacing * correlation[0]).abs() < 1e-12);
}

/// exp(−t) sampled every half unit: ∫ = 1, the trapezoid rule is 2 % above it, Gregory's rule 0.1 %.
#[test]
fn a_smooth_correlation_is_integrated_between_its_samples() {
    let (spacing, mut random) = (0.5_f64, Random::new(5));
    let mut process = Autoregressive::new((-spacing).exp(), &mut random);
    let mut correlator = MultipleTau::autocorrelation(spacing).unwrap();
    (0..400_000).for_each(|_| correlator.record(&[process.next(&mut random)]).unwrap());
    let integral = |quadrature| correlator.integral(&IntegralOptions { quadrature, longest_time: None }).estimate;
    let (smooth, summed) = (integral(Quadrature::Smooth), integral(Quadrature::Summed));
    assert!(smooth.z_score_against(1.0011, 0.0).unwrap().abs() < 3.0, "{smooth:?}");
    // Both from the same samples: their difference has hardly any error.
    let difference = summed.value.unwrap() - smooth.value.unwrap();
    assert!((difference - 0.0196).abs() < 0.002, "{difference}");
}

/// A slow process under white noise of a hundred times its variance: what is left of it beyond the noise is seen late, if at all.
#[test]
fn a_decay_that_noise_hides_is_waited_for_where_a_channel_shows_it() {
    let (memory, noise) = ((-0.05_f64).exp(), 10.0);
    let integral = 0.5 * (1.0 + noise * noise) + memory / (1.0 - memory);
    let covered = |guarded: bool| {
        let covers = |seed: u64| {
            let mut random = Random::new(seed);
            let mut process = Autoregressive::new(memory, &mut random);
            let mut correlator = MultipleTau::new(2, &[[0, 0]], 1.0).unwrap();
            if guarded {
                correlator = correlator.remembered_by([1]).unwrap();
            }
            for _ in 0..40_000 {
                let slow = process.next(&mut random);
                correlator.record(&[slow + noise * random.normal(), slow]).unwrap();
            }
            let estimate = correlator.integral(&IntegralOptions::default()).estimate;
            estimate.interval(0.95).is_some_and(|(low, high)| (low..high).contains(&integral))
        };
        (0..100).filter(|&seed| covers(1000 + seed)).count()
    };
    let (without, with) = (covered(false), covered(true));
    println!("{without} of 100 without, {with} with the channel");
    assert!(without < 85 && (88..=100).contains(&with), "{without}, {with}");
}

#[test]
fn pooled_pairs_have_the_same_correlations() {
    let (channels, mut random) = (6, Random::new(6));
    let mut processes: Vec<_> = (0..channels).map(|_| Autoregressive::new(0.7, &mut random)).collect();
    let pairs: Vec<[usize; 2]> = (0..channels).map(|channel| [channel, channel]).collect();
    let apart = MultipleTau::new(channels, &pairs, 1.0).unwrap();
    let (mut pooled, mut apart) = (MultipleTau::pooled(channels, 1.0).unwrap(), apart);
    assert!(!pooled.accepts(&apart) && pooled.merge(&apart).is_err());
    for _ in 0..50_000 {
        let sample: Vec<f64> = processes.iter_mut().map(|process| process.next(&mut random)).collect();
        pooled.record(&sample).unwrap();
        apart.record(&sample).unwrap();
    }
    for (one, all) in pooled.table(Quadrature::Summed).iter().zip(apart.table(Quadrature::Summed)) {
        assert!((one.correlation.value.unwrap() - all.correlation.value.unwrap()).abs() < 1e-12);
    }
    let (one, all) = (pooled.integral(&IntegralOptions::default()), apart.integral(&IntegralOptions::default()));
    let ratio = one.estimate.standard_error.unwrap() / all.estimate.standard_error.unwrap();
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
    assert!(one.estimate.z_score_against(0.5 + 0.7 / 0.3, 0.0).unwrap().abs() < 3.0);
}

#[test]
fn the_mean_is_removed_whatever_it_is() {
    let mut random = Random::new(6);
    let mut process = Autoregressive::new(0.8, &mut random);
    let new = || MultipleTau::autocorrelation(1.0).unwrap().remove_mean(0).unwrap();
    let (mut plain, mut shifted) = (new(), new());
    for _ in 0..LENGTH {
        // Multiples of 2^-20 are exact beside 2^30, so that both series hold the same numbers.
        let value = (process.next(&mut random) * 1_048_576.0).round() / 1_048_576.0;
        plain.record(&[value]).unwrap();
        shifted.record(&[value + 1_073_741_824.0]).unwrap();
    }
    let tables = (plain.table(Quadrature::Summed), shifted.table(Quadrature::Summed));
    for (plain, shifted) in tables.0.iter().zip(&tables.1) {
        assert!((plain.correlation.value.unwrap() - shifted.correlation.value.unwrap()).abs() < 1e-10);
        assert!((plain.integral.standard_error.unwrap() - shifted.integral.standard_error.unwrap()).abs() < 1e-9);
    }
}

/// What removing the mean takes away is given back: on average a short series is like one whose mean is known.
#[test]
fn removing_the_mean_leaves_no_bias() {
    let (length, series) = (1000, 1000);
    let (mut at_origin, mut integral) = (0.0, 0.0);
    for seed in 0..series {
        let mut random = Random::new(seed);
        let mut process = Autoregressive::new(0.8, &mut random);
        let mut known = MultipleTau::autocorrelation(1.0).unwrap();
        let mut removed = known.clone().remove_mean(0).unwrap();
        for _ in 0..length {
            let value = process.next(&mut random);
            known.record(&[value]).unwrap();
            removed.record(&[3.0 + value]).unwrap();
        }
        let (known, removed) = (known.table(Quadrature::Summed), removed.table(Quadrature::Summed));
        let excess = |a: &Estimate, b: &Estimate| (a.value.unwrap() - b.value.unwrap()) / series as f64;
        at_origin += excess(&removed[0].correlation, &known[0].correlation);
        integral += excess(&removed[12].integral, &known[12].integral);
    }
    // Without the correction C(0) would be too small by 2 · 4.5/1000 = 0.009, the integral up to 12 by 9 times as much.
    assert!(at_origin.abs() < 0.002, "{at_origin}");
    assert!(integral.abs() < 0.02, "{integral}");
}

#[test]
fn merged_replicas_are_one_sum_without_products_across_the_seam() {
    let (left, right) = (rotating(3000, 7), rotating(2500, 8));
    let new = || MultipleTau::new(2, &[[1, 0]], 1.0).unwrap();
    let mut merged = recorded(new(), &left);
    merged.merge(&recorded(new(), &right)).unwrap();
    assert_eq!(merged.count(), 5500);
    let sum = |series: &[[f64; 2]], lag: usize| {
        direct(&channel(series, 1), &channel(series, 0), lag) * (series.len() - lag) as f64
    };
    for point in merged.table(Quadrature::Summed).iter().take(16) {
        let lag = point.time as usize;
        let pooled = (sum(&left, lag) + sum(&right, lag)) / (5500 - 2 * lag) as f64;
        assert!((point.correlation.value.unwrap() - pooled).abs() < 1e-12);
    }
    // Recording goes on with the left series.
    let more = rotating(500, 9);
    let whole: Vec<[f64; 2]> = left.iter().chain(&more).copied().collect();
    let merged = recorded(merged, &more);
    let pooled = (sum(&whole, 3) + sum(&right, 3)) / 5994.0;
    assert!((merged.table(Quadrature::Summed)[3].correlation.value.unwrap() - pooled).abs() < 1e-12);
}

#[test]
fn merging_keeps_means_digits_and_bounds() {
    let mut random = Random::new(10);
    let new = || MultipleTau::autocorrelation(1.0).unwrap().remove_mean(0).unwrap();
    let mut pooled = new();
    let mut squares = 0.0;
    let mut sum = 0.0;
    for _ in 0..100 {
        let mut replica = new();
        for _ in 0..200 {
            let value = 1e6 + random.normal();
            replica.record(&[value]).unwrap();
            sum += value - 1e6;
            squares += (value - 1e6) * (value - 1e6);
        }
        pooled.merge(&replica).unwrap();
    }
    let number = 20_000.0;
    let variance = (squares - sum * sum / number) / number;
    let first = &pooled.table(Quadrature::Summed)[0].correlation;
    // The variance of the mean is given back.
    assert!((first.value.unwrap() - variance * (1.0 + 1.0 / number)).abs() < 1e-4, "{first:?}");
    assert!((first.standard_error.unwrap() - (2.0 / number).sqrt()).abs() < 3e-3, "{first:?}");
    // 64 segments with 16 lags, and 8 at each of 7 levels more, of four sums.
    assert!(numbers(&pooled) < 64 * (16 + 8 * 7) * 4 + 1000, "{}", numbers(&pooled));
}

/// How many numbers the state holds.
fn numbers(correlator: &MultipleTau) -> usize {
    format!("{correlator:?}").matches(',').count()
}

#[test]
fn memory_is_bounded() {
    let mut correlator = MultipleTau::autocorrelation(1.0).unwrap();
    let mut sizes = Vec::new();
    for index in 0..=1 << 17 {
        correlator.record(&[f64::from(index % 7)]).unwrap();
        if index == 1 << 14 || index == 1 << 17 {
            sizes.push(numbers(&correlator));
        }
    }
    assert!(2 * sizes[1] < 3 * sizes[0], "{sizes:?}");
}

#[test]
fn a_constant_series_has_nothing_to_correlate() {
    let mut correlator = MultipleTau::autocorrelation(1.0).unwrap().remove_mean(0).unwrap();
    (0..LENGTH).for_each(|_| correlator.record(&[0.1]).unwrap());
    let integral = correlator.integral(&IntegralOptions::default()).estimate;
    assert_eq!((integral.value, integral.standard_error), (Some(0.0), Some(0.0)));
    assert!(correlator.autocorrelation_time().time.value.is_none());
}

#[test]
fn squares_that_overflow_give_no_number() {
    let mut correlator = MultipleTau::autocorrelation(1.0).unwrap();
    [1e200, -1e200].iter().cycle().take(LENGTH).for_each(|value| correlator.record(&[*value]).unwrap());
    let integral = correlator.integral(&IntegralOptions::default());
    assert!(integral.estimate.value.is_none() && !integral.estimate.warnings.is_empty(), "{integral:?}");
}

#[test]
fn states_of_another_kind_are_not_accepted() {
    let good = recorded(MultipleTau::new(2, &[[1, 0]], 1.0).unwrap(), &rotating(100, 11));
    assert!(MultipleTau::new(2, &[[1, 0]], 1.0).unwrap().accepts(&good));
    for other in [
        MultipleTau::new(3, &[[1, 0]], 1.0).unwrap(),
        MultipleTau::new(2, &[[0, 1]], 1.0).unwrap(),
        MultipleTau::new(2, &[[1, 0], [0, 1]], 1.0).unwrap(),
        MultipleTau::new(2, &[[1, 0]], 2.0).unwrap(),
        MultipleTau::new(2, &[[1, 0]], 1.0).unwrap().remove_mean(1).unwrap(),
    ] {
        assert!(!other.accepts(&good));
        assert!(matches!(good.clone().merge(&other), Err(AnalysisError::Mismatch { .. })));
    }
}

#[test]
fn bad_input_is_refused_and_leaves_no_trace() {
    assert!(MultipleTau::new(0, &[[0, 0]], 1.0).is_err());
    assert!(MultipleTau::new(1, &[], 1.0).is_err());
    assert!(MultipleTau::new(1, &[[0, 1]], 1.0).is_err());
    assert!(MultipleTau::autocorrelation(f64::NAN).is_err());
    let mut correlator = MultipleTau::new(2, &[[0, 1]], 1.0).unwrap();
    assert!(correlator.clone().remove_mean(2).is_err());
    assert!(correlator.record(&[1.0]).is_err());
    assert!(correlator.record(&[1.0, f64::INFINITY]).is_err());
    assert_eq!(correlator.count(), 0);
    correlator.record(&[1.0, 2.0]).unwrap();
    assert!(correlator.clone().remove_mean(0).is_err());
    assert!(correlator.helfand_slope(None).estimate.value.is_none());
    assert!(correlator.table(Quadrature::Summed).is_empty());
}

#[test]
fn too_short_series_cannot_tell_and_say_how_much_longer() {
    let mut random = Random::new(12);
    let mut process = Exponentials::new(&[(1.0, 50.0)], 0.0, &mut random);
    let mut correlator = MultipleTau::autocorrelation(1.0).unwrap();
    let warning = |correlator: &MultipleTau| {
        let integral = correlator.integral(&IntegralOptions::default());
        assert_eq!((integral.estimate.value, integral.cutoff), (None, None));
        integral.estimate.warnings[0].clone()
    };
    assert!(warning(&correlator).contains("too few"));
    (0..5000).for_each(|_| correlator.record(&[process.next(&mut random)]).unwrap());
    let text = warning(&correlator);
    assert!(text.starts_with("cannot tell yet") && text.contains("times longer"), "{text}");
    assert!(correlator.autocorrelation_time().time.warnings[0].starts_with("cannot tell yet"));
    assert!(correlator.helfand_slope(None).estimate.warnings[0].starts_with("cannot tell yet"));
    (0..200_000).for_each(|_| correlator.record(&[process.next(&mut random)]).unwrap());
    let limited = correlator.integral(&IntegralOptions { longest_time: Some(60.0), ..IntegralOptions::default() });
    assert!(limited.estimate.warnings[0].contains("longest time allowed"), "{limited:?}");
    assert!(correlator.integral(&IntegralOptions::default()).estimate.value.is_some());
}
