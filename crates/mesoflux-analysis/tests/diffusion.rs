//! Diffusion coefficients of processes whose D is known exactly.
#![allow(clippy::unwrap_used)] // Helpers of tests unwrap as tests do.

mod common;

use common::{Motion, Random, recorded_motion};
use mesoflux_analysis::{DiffusionEstimate, standard_normal_summary};

const SERIES: u64 = 200;

/// Estimates over independent series, and their z-scores against the exact value where there is one.
fn measured(
    motion: Motion,
    particles: usize,
    lags: usize,
    records: usize,
    exact: f64,
) -> (Vec<DiffusionEstimate>, Vec<f64>) {
    let estimates: Vec<DiffusionEstimate> = (0..SERIES)
        .map(|seed| recorded_motion(motion, particles, lags, records, &mut Random::new(seed)).diffusion_coefficient())
        .collect();
    let scores = estimates.iter().filter_map(|d| d.estimate.z_score_against(exact, 0.0)).collect();
    (estimates, scores)
}

/// 200 scores have a mean good to 0.07 and a mean square good to 0.1; Student's tails and the choice of the window add to the latter.
fn assert_calibrated(scores: &[f64]) {
    let summary = standard_normal_summary(scores).unwrap();
    assert!(summary.mean.abs() < 0.25, "{summary:?}");
    assert!((0.75..1.45).contains(&summary.variance), "{summary:?}");
    assert!(summary.largest < 5.0, "{summary:?}");
}

#[test]
fn brownian_motion() {
    let (estimates, scores) = measured(Motion::Brownian, 10, 16, 3000, 0.5);
    assert!(scores.len() >= 190, "{}", scores.len());
    assert_calibrated(&scores);
    let precise = estimates.iter().filter_map(|d| d.estimate.relative_error()).all(|error| error < 0.05);
    assert!(precise);
}

#[test]
fn langevin_motion_is_fitted_past_the_ballistic_regime() {
    let (estimates, scores) = measured(Motion::Langevin { spacing: 0.5 }, 20, 40, 4000, 1.0);
    assert!(scores.len() >= 180, "{}", scores.len());
    assert_calibrated(&scores);
    // Velocities relax within one unit of time.
    let begins: Vec<f64> = estimates.iter().filter_map(|d| d.window).map(|window| window.0).collect();
    let mean = begins.iter().sum::<f64>() / begins.len() as f64;
    assert!(begins.iter().all(|&begin| begin >= 1.0) && mean > 2.0, "{mean}");
    // The exact line is 6(t − 1).
    let intercepts: Vec<f64> = estimates.iter().filter_map(|d| d.intercept.z_score_against(-6.0, 0.0)).collect();
    assert!(standard_normal_summary(&intercepts).unwrap().mean.abs() < 0.3);
}

/// A fit of the whole curve, ballistic part included, shows that the test above can fail.
#[test]
fn fitting_the_ballistic_regime_would_be_seen() {
    let scores: Vec<f64> = (0..20)
        .map(|seed| {
            let recorder = recorded_motion(Motion::Langevin { spacing: 0.5 }, 20, 40, 4000, &mut Random::new(seed));
            // The slope through the first two lags.
            let mut weights = vec![0.0; 40];
            (weights[0], weights[1]) = (-1.0 / 3.0, 1.0 / 3.0);
            recorder.linear(&weights).z_score_against(1.0, 0.0).unwrap()
        })
        .collect();
    assert!(standard_normal_summary(&scores).unwrap().mean < -10.0);
}

#[test]
fn replicas_are_pooled() {
    let scores: Vec<f64> = (0..SERIES)
        .map(|seed| {
            let mut random = Random::new(seed);
            let mut pooled = recorded_motion(Motion::Brownian, 10, 16, 750, &mut random);
            for _ in 1..4 {
                pooled.merge(&recorded_motion(Motion::Brownian, 10, 16, 750, &mut random)).unwrap();
            }
            pooled
        })
        .filter_map(|pooled| pooled.diffusion_coefficient().estimate.z_score_against(0.5, 0.0))
        .collect();
    assert!(scores.len() >= 190, "{}", scores.len());
    assert_calibrated(&scores);
}

#[test]
fn confined_particles_do_not_diffuse() {
    let (estimates, _) = measured(Motion::Confined { spacing: 0.5 }, 10, 40, 2000, 0.0);
    for diffusion in &estimates {
        assert!(diffusion.estimate.value.is_none_or(|value| value.abs() < 0.05), "{diffusion:?}");
    }
    let warned = estimates.iter().filter(|d| !d.estimate.warnings.is_empty()).count();
    assert!(warned >= 185, "{warned}");
}

/// Data so good that what is left of the ballistic motion shows even in the last window, where it is a few percent.
#[test]
fn a_small_change_of_slope_that_is_seen_is_part_of_the_error() {
    let recorder = recorded_motion(Motion::Langevin { spacing: 0.15 }, 600, 40, 4000, &mut Random::new(1));
    let diffusion = recorder.diffusion_coefficient();
    assert!(
        diffusion.estimate.warnings.iter().any(|warning| warning.contains("isn't quite straight")),
        "{diffusion:?}"
    );
    let error = diffusion.estimate.standard_error.unwrap();
    assert!((0.01..0.1).contains(&error), "{diffusion:?}");
    assert!(diffusion.estimate.z_score_against(1.0, 0.0).unwrap().abs() < 2.0, "{diffusion:?}");
    // The change over the window that was used is smaller than the one, over a longer window, that went into the error.
    assert!(diffusion.curvature.value.unwrap().abs() < error);
}

#[test]
fn free_flight_has_no_linear_window() {
    let recorder = recorded_motion(Motion::Ballistic, 20, 20, 1000, &mut Random::new(1));
    let diffusion = recorder.diffusion_coefficient();
    assert_eq!((diffusion.estimate.value, diffusion.window), (None, None));
    assert!(diffusion.estimate.warnings[0].starts_with("cannot tell"));
}

#[test]
fn too_little_data_cannot_tell() {
    let few_lags = recorded_motion(Motion::Brownian, 5, 5, 1000, &mut Random::new(1));
    let few_origins = recorded_motion(Motion::Brownian, 5, 40, 150, &mut Random::new(1));
    for recorder in [few_lags, few_origins] {
        let diffusion = recorder.diffusion_coefficient();
        assert_eq!(diffusion.estimate.value, None);
        assert!(diffusion.estimate.warnings[0].starts_with("cannot tell"));
    }
}
