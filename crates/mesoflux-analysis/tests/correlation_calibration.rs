//! Calibration of integrals, Helfand slopes and correlation times, on processes whose exact values are known.
//!
//! The long form runs with `cargo test -- --ignored --nocapture`.

#![allow(clippy::unwrap_used)] // Only tests call these functions.

mod common;

use common::{Exponentials, Random, Rotating, recorded_autoregressive};
use mesoflux_analysis::{
    Blocking, Estimate, IntegralOptions, MultipleTau, Quadrature, StandardNormalSummary, standard_normal_summary,
};

/// Times between samples: every result must scale with it.
const SPACING: f64 = 0.5;

/// What the estimates of many series say about the truth.
#[derive(Debug)]
struct Calibration {
    /// Series for which there was an estimate.
    told: usize,
    /// Share of these whose 95 % interval contains the truth.
    coverage: f64,
    scores: StandardNormalSummary,
    /// Mean relative standard error.
    error: f64,
}

fn calibration(estimates: &[Estimate], truth: f64) -> Calibration {
    let told: Vec<&Estimate> = estimates.iter().filter(|estimate| estimate.value.is_some()).collect();
    let contains =
        |estimate: &&&Estimate| estimate.interval(0.95).is_some_and(|(low, high)| low <= truth && truth <= high);
    let scores: Vec<f64> = told.iter().map(|estimate| estimate.z_score_against(truth, 0.0).unwrap()).collect();
    let number = told.len() as f64;
    Calibration {
        told: told.len(),
        coverage: told.iter().filter(contains).count() as f64 / number,
        scores: standard_normal_summary(if scores.is_empty() { &[0.0] } else { &scores }).unwrap(),
        error: told.iter().map(|estimate| estimate.standard_error.unwrap() / truth.abs()).sum::<f64>() / number,
    }
}

/// A process with a known integral.
#[derive(Clone)]
enum Process {
    /// Variances and times of exponentials, white noise, equivalent channels.
    Exponentials(Vec<(f64, f64)>, f64, usize),
    /// Autocorrelation of a rotating process of this decay and frequency: a damped cosine.
    Cosine(f64, f64),
    /// Its cross-correlation: a damped sine, odd in time.
    Sine(f64, f64),
}

impl Process {
    fn truth(&self) -> f64 {
        SPACING
            * match self {
                Self::Exponentials(parts, noise, _) => Exponentials::integral(parts, *noise),
                Self::Cosine(decay, frequency) => Rotating::integrals(*decay, *frequency).0,
                Self::Sine(decay, frequency) => Rotating::integrals(*decay, *frequency).1,
            }
    }

    fn variance(&self) -> f64 {
        match self {
            Self::Exponentials(parts, noise, _) => parts.iter().map(|part| part.0).sum::<f64>() + noise,
            Self::Cosine(..) | Self::Sine(..) => 1.0,
        }
    }

    fn recorded(&self, length: usize, seed: u64) -> MultipleTau {
        let mut random = Random::new(seed);
        match self {
            Self::Exponentials(parts, noise, channels) => {
                let pairs: Vec<[usize; 2]> = (0..*channels).map(|channel| [channel, channel]).collect();
                let mut correlator = MultipleTau::new(*channels, &pairs, SPACING).unwrap();
                let mut series: Vec<Exponentials> =
                    pairs.iter().map(|_| Exponentials::new(parts, *noise, &mut random)).collect();
                for _ in 0..length {
                    let sample: Vec<f64> = series.iter_mut().map(|series| series.next(&mut random)).collect();
                    correlator.record(&sample).unwrap();
                }
                correlator
            }
            Self::Cosine(decay, frequency) | Self::Sine(decay, frequency) => {
                let pair = if matches!(self, Self::Sine(..)) { [1, 0] } else { [0, 0] };
                let mut correlator = MultipleTau::new(2, &[pair], SPACING).unwrap();
                let mut process = Rotating::new(*decay, *frequency, &mut random);
                (0..length).for_each(|_| correlator.record(&process.next(&mut random)).unwrap());
                correlator
            }
        }
    }
}

fn simple(time: f64, noise: f64, channels: usize) -> Process {
    Process::Exponentials(vec![(1.0, time)], noise, channels)
}

fn integral(correlator: &MultipleTau) -> Estimate {
    correlator.integral(&IntegralOptions::default()).estimate
}

fn estimates(
    process: &Process,
    length: usize,
    number: u64,
    estimate: impl Fn(&MultipleTau) -> Estimate,
) -> Vec<Estimate> {
    (0..number).map(|seed| estimate(&process.recorded(length, 1000 + seed))).collect()
}

/// The mean of z isn't quite zero where errors are large: a low estimate has a low error.
fn assert_standard_normal(calibration: &Calibration, number: usize, what: &str) {
    assert!(calibration.told * 100 >= 98 * number, "{what}: {calibration:?}");
    assert!((0.92..=0.98).contains(&calibration.coverage), "{what}: {calibration:?}");
    assert!(calibration.scores.mean.abs() < 0.25, "{what}: {calibration:?}");
    assert!((0.65..1.3).contains(&calibration.scores.variance), "{what}: {calibration:?}");
    assert!(calibration.scores.shape_p_value > 0.005, "{what}: {calibration:?}");
}

#[test]
fn integrals_of_exponentials_are_unbiased_and_calibrated() {
    for (what, process, length) in [
        ("autoregressive", simple(5.0, 0.0, 1), 20_000),
        ("with as much white noise", simple(5.0, 1.0, 1), 20_000),
        ("two times, a decade apart", Process::Exponentials(vec![(1.0, 1.0), (0.2, 10.0)], 0.2, 1), 40_000),
        ("two times, two decades apart", Process::Exponentials(vec![(1.0, 0.2), (0.2, 20.0)], 0.0, 1), 60_000),
        ("five channels", simple(5.0, 0.0, 5), 6000),
    ] {
        let result = calibration(&estimates(&process, length, 200, integral), process.truth());
        assert_standard_normal(&result, 200, what);
    }
}

#[test]
fn integrals_of_oscillations_and_of_odd_cross_correlations_are_calibrated() {
    for (what, process) in [("cosine", Process::Cosine(0.1, 0.2)), ("sine", Process::Sine(0.1, 0.1))] {
        let result = calibration(&estimates(&process, 40_000, 200, integral), process.truth());
        assert_standard_normal(&result, 200, what);
    }
}

#[test]
fn short_runs_are_covered() {
    let process = simple(5.0, 0.5, 1);
    let (truth, length, number) = (process.truth(), 6000, 400);
    let runs: Vec<MultipleTau> = (0..number).map(|seed| process.recorded(length, seed)).collect();
    let of = |estimate: &dyn Fn(&MultipleTau) -> Estimate, truth: f64| {
        calibration(&runs.iter().map(estimate).collect::<Vec<_>>(), truth)
    };
    for (what, result) in [
        ("integral", of(&integral, truth)),
        ("Helfand", of(&|run| run.helfand_slope(None).estimate, truth)),
        ("time", of(&|run| run.autocorrelation_time().time, truth / process.variance())),
        ("asymptotic variance", of(&|run| run.autocorrelation_time().asymptotic_variance, 2.0 * truth)),
    ] {
        assert!(result.told > 380 && (0.92..=0.9775).contains(&result.coverage), "{what}: {result:?}");
    }
}

#[test]
fn runs_that_are_too_short_cannot_tell() {
    // The cross-correlation begins at zero and isn't seen at first.
    for process in [simple(50.0, 0.0, 1), Process::Sine(0.02, 0.02)] {
        let told = estimates(&process, 8000, 100, integral).iter().filter(|e| e.value.is_some()).count();
        assert!(told <= 2, "{told}");
    }
}

#[test]
fn replicas_and_equivalent_pairs_count_as_samples() {
    let process = simple(5.0, 0.0, 1);
    let pooled = |seed: u64| {
        let mut pooled = process.recorded(2000, 100 * seed);
        (1..10).for_each(|replica| pooled.merge(&process.recorded(2000, 100 * seed + replica)).unwrap());
        integral(&pooled)
    };
    let estimates: Vec<Estimate> = (0..200).map(pooled).collect();
    assert_standard_normal(&calibration(&estimates, process.truth()), 200, "ten replicas");
}

#[test]
fn blocking_agrees_with_correlation() {
    let (memory, length) = (0.9, 1 << 15);
    let exact = 0.5 * SPACING * (1.0 + memory) / (1.0 - memory);
    let times: Vec<(Estimate, Estimate)> = (0..200)
        .map(|seed| recorded_autoregressive(memory, length, &mut Random::new(seed)))
        .map(|blocking: Blocking| blocking.autocorrelation_time(&[1.0], SPACING).unwrap())
        .map(|result| (result.time, result.asymptotic_variance))
        .collect();
    let (times, variances): (Vec<_>, Vec<_>) = times.into_iter().unzip();
    for (result, name) in [(calibration(&times, exact), "time"), (calibration(&variances, 2.0 * exact), "variance")] {
        assert!(result.told == 200 && (0.9..=0.98).contains(&result.coverage), "{name}: {result:?}");
    }
    assert!(recorded_autoregressive(memory, 100, &mut Random::new(1)).autocorrelation_time(&[1.0], 0.0).is_err());
}

#[test]
fn the_time_of_decay_is_that_of_an_exponential() {
    let process = simple(8.0, 0.0, 1);
    let times = estimates(&process, 60_000, 50, |run| run.integral(&IntegralOptions::default()).decay_time);
    // ∫ t C/∫ C of the sampled exponential: Σ k φ^k/(½ + Σ φ^k).
    let memory = f64::exp(-1.0 / 8.0);
    let exact = SPACING * memory / (1.0 - memory).powi(2) / (0.5 * (1.0 + memory) / (1.0 - memory));
    let mean: f64 = times.iter().map(|time| time.value.unwrap() / 50.0).sum();
    assert!((mean / exact - 1.0).abs() < 0.06, "{mean} {exact}");
}

/// The figures of the report: lengths in units of the longest time.
#[test]
#[ignore = "minutes: the long form of the calibration"]
fn coverage_by_length() {
    for (what, process, time) in [
        ("one exponential", simple(5.0, 0.0, 1), 5.0),
        ("with white noise", simple(5.0, 1.0, 1), 5.0),
        ("five channels", simple(5.0, 0.0, 5), 5.0),
        ("a decade apart", Process::Exponentials(vec![(1.0, 1.0), (0.2, 10.0)], 0.2, 1), 10.0),
        ("cosine", Process::Cosine(0.1, 0.2), 10.0),
        ("sine", Process::Sine(0.1, 0.1), 10.0),
    ] {
        for times in [150.0, 300.0, 700.0, 1200.0, 3000.0, 10_000.0] {
            let runs: Vec<MultipleTau> = (0..400).map(|seed| process.recorded((times * time) as usize, seed)).collect();
            let report = |name: &str, estimate: &dyn Fn(&MultipleTau) -> Estimate, truth: f64| {
                let result = calibration(&runs.iter().map(estimate).collect::<Vec<_>>(), truth);
                let (mean, variance) = (result.scores.mean, result.scores.variance);
                println!(
                    "{what}, {times} times, {name}: told {}, coverage {:.4}, mean z {mean:.2}, mean z² {variance:.2}, p {:.3}, error {:.3}",
                    result.told, result.coverage, result.scores.shape_p_value, result.error
                );
            };
            report("integral", &integral, process.truth());
            if !matches!(process, Process::Sine(..)) {
                report("Helfand", &|run| run.helfand_slope(None).estimate, process.truth());
                report("time", &|run| run.autocorrelation_time().time, process.truth() / process.variance());
            }
        }
    }
    assert_eq!(Quadrature::default(), Quadrature::Summed);
}
