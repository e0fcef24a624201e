//! Claims of every kind on made-up data with a known answer, and whether their z-scores are those of a standard normal deviate.

use super::*;
use crate::study::series::{Missing, Point};
use crate::study::verdict::{Judged, Verdict};
use mesoflux_analysis::standard_normal_summary;

fn claim(measured: &str, expectation: &str) -> Claim {
    let text = format!("item = \"figure\"\ntext = \"a claim\"\nmeasured.{measured}\n{expectation}");
    let claim: Claim = toml::from_str(&text).unwrap();
    assert_eq!(claim.fault(), None);
    claim
}

fn judge(measured: &str, expectation: &str, data: &Data) -> Judged {
    let claim = claim(measured, expectation);
    claim.judge(claim.measured.measure(data))
}

fn verdict(measured: &str, expectation: &str, data: &Data) -> Verdict {
    judge(measured, expectation, data).verdict
}

/// Points of a law with relative errors.
fn law(x: &[f64], relative: f64, law: impl Fn(f64) -> f64) -> Series {
    let point = |&x: &f64| Point { x, x_error: 0.0, y: law(x), y_error: relative * law(x).abs() };
    Series::new(x.iter().map(point).collect(), Vec::new())
}

fn one(name: &str, series: Series) -> Data {
    Data::from([(name.to_owned(), series)])
}

const X: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

fn close(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{found:?} for {expected}");
}

#[test]
fn values() {
    let data = one("eta", law(&[1.0, 2.0], 0.01, |x| 10.0 * x));
    let measured = "value = { of = \"eta\", at = 2.0 }";
    let judged = judge(measured, "expected = 19.8\nrequired_error = 0.3", &data);
    close(judged.measured, 20.0);
    close(judged.standard_error, 0.2);
    close(judged.z, 1.0);
    assert_eq!(judged.verdict, Verdict::Holds);
    close(judge(measured, "expected = 18.0\nexpected_error = 0.15\nrequired_error = 0.3", &data).z, 2.0 / 0.25);
    assert_eq!(verdict(measured, "expected = 19.4\nrequired_error = 0.3", &data), Verdict::Fails);
    assert_eq!(verdict(measured, "expected = 19.8\nrequired_error = 0.1", &data), Verdict::CannotTell);
    // Wrong is wrong, however large the error.
    assert_eq!(verdict(measured, "expected = 19.4\nrequired_error = 0.1", &data), Verdict::Fails);
    let several = judge("value = { of = \"eta\" }", "expected = 1.0\nrequired_error = 0.1", &data);
    assert_eq!((several.verdict, several.measured), (Verdict::CannotTell, None));
}

#[test]
fn what_the_runs_could_not_tell_is_not_told() {
    let mut series = law(&X, 0.01, |x| x);
    series.missing.push(Missing { x: Some(64.0), reason: "too short".to_owned() });
    let data = one("a", series);
    let judged = judge("exponent = { of = \"a\" }", "expected = 1.0\nrequired_error = 0.1", &data);
    assert_eq!((judged.verdict, judged.measured, judged.z), (Verdict::CannotTell, None, None));
    assert!(judged.note.unwrap().contains("no point at 64: too short"));
    // Outside the window nothing is missed.
    let inside = "exponent = { of = \"a\", window = [1.0, 32.0] }";
    assert_eq!(verdict(inside, "expected = 1.0\nrequired_error = 0.1", &data), Verdict::Holds);
    let exact = one("a", law(&[1.0], 0.0, |x| x));
    let judged = judge("value = { of = \"a\" }", "expected = 1.0\nrequired_error = 0.1", &exact);
    assert_eq!(judged.verdict, Verdict::CannotTell, "a number without an error holds nothing");
}

#[test]
fn what_the_runs_warn_of_goes_with_the_verdict() {
    let mut series = law(&X, 0.01, |x| x);
    series.warnings.push("mobility/nemd at 4: hot".to_owned());
    let judged = judge("exponent = { of = \"a\" }", "expected = 1.0\nrequired_error = 0.1", &one("a", series));
    assert_eq!((judged.verdict, judged.note), (Verdict::Holds, None));
    assert_eq!(judged.warnings, ["mobility/nemd at 4: hot"]);
}

#[test]
fn bounds() {
    let data = one("a", law(&[1.0], 0.02, |_| 0.9));
    let value = "value = { of = \"a\" }";
    let judged = judge(value, "below = 1.0\nrequired_error = 0.1", &data);
    assert_eq!((judged.verdict, judged.z, judged.expected), (Verdict::Holds, Some(0.0), 1.0));
    close(Some(judged.required_error), 0.1 / 2.5);
    let judged = judge(value, "above = 1.0\nrequired_error = 0.1", &data);
    assert_eq!(judged.verdict, Verdict::Fails);
    close(judged.z, -0.1 / 0.018);
    // Too near to tell on which side.
    for bound in ["below = 0.92", "above = 0.88", "above = 0.92", "below = 0.88", "below = 0.9"] {
        let judged = judge(value, &format!("{bound}\nrequired_error = 0.1"), &data);
        assert_eq!(judged.verdict, Verdict::CannotTell, "{bound}");
        assert!(judged.standard_error.unwrap() > judged.required_error, "{bound}");
    }
    assert_eq!(verdict(value, "below = 1.0\nrequired_error = 0.01", &data), Verdict::CannotTell);
    // Exact numbers lie on one side or on the other.
    let data = one("a", law(&[1.0], 0.0, |_| 0.9));
    assert_eq!(verdict(value, "above = 0.89\nrequired_error = 0.1", &data), Verdict::Holds);
    assert_eq!(verdict(value, "below = 0.89\nrequired_error = 0.1", &data), Verdict::Fails);
    assert_eq!(verdict(value, "expected = 0.9\nrequired_error = 0.1", &data), Verdict::CannotTell);
}

#[test]
fn agreements() {
    let mut data = one("a", law(&X, 0.01, |x| 1.01 * x));
    data.insert("b".to_owned(), law(&X, 0.01, |x| x));
    let measured = "agreement = { between = [\"a\", \"b\"] }";
    let judged = judge(measured, "expected = 0.0\nrequired_error = 0.01", &data);
    close(judged.measured, 0.01);
    assert_eq!(judged.verdict, Verdict::Holds);
    assert!(judged.note.unwrap().contains("6 points, the largest |z| of one is 0.7"));
    assert_eq!(verdict(measured, "expected = 0.0\nrequired_error = 0.003", &data), Verdict::CannotTell);
    data.insert("a".to_owned(), law(&X, 0.01, |x| 1.02 * x));
    assert_eq!(verdict(measured, "expected = 0.0\nrequired_error = 0.01", &data), Verdict::Fails);
    // Differences that cancel are no agreement.
    data.insert("a".to_owned(), law(&X, 0.01, |x| if x > 5.0 { 1.1 * x } else { 0.91 * x }));
    let judged = judge(measured, "expected = 0.0\nrequired_error = 0.01", &data);
    assert_ne!(judged.verdict, Verdict::Holds);
    assert!(judged.note.unwrap().contains("scatter"));
}

#[test]
fn ratios() {
    let mut data = one("a", law(&X, 0.01, |x| 0.8 * x));
    data.insert("b".to_owned(), law(&X, 0.01, |x| x));
    let measured = "ratio = { numerator = \"a\", denominator = \"b\", window = [2.0, 16.0] }";
    let judged = judge(measured, "expected = 0.8\nrequired_error = 0.01", &data);
    close(judged.measured, 0.8);
    close(judged.standard_error, 0.8 * 0.01 * 2f64.sqrt() / 2.0);
    assert_eq!(judged.verdict, Verdict::Holds);
    assert_eq!(verdict(measured, "below = 1.0\nrequired_error = 0.01", &data), Verdict::Holds);
    assert_eq!(verdict(measured, "above = 1.0\nrequired_error = 0.01", &data), Verdict::Fails);
    assert_eq!(verdict(measured, "below = 0.81\nrequired_error = 0.01", &data), Verdict::CannotTell);
}

#[test]
fn exponents() {
    let data = one("a", law(&X, 0.01, |x| 3.0 * x.powf(-2.0 / 3.0)));
    let measured = "exponent = { of = \"a\" }";
    let judged = judge(measured, "expected = -0.6667\nrequired_error = 0.01", &data);
    close(judged.measured, -2.0 / 3.0);
    // s_p = s/√Σ (ln x − mean)² with ln x = k ln 2, k = 0 … 5.
    close(judged.standard_error, 0.01 / (2f64.ln() * 17.5f64.sqrt()));
    assert_eq!((judged.verdict, judged.note), (Verdict::Holds, None));
    assert_eq!(verdict(measured, "expected = -0.7\nrequired_error = 0.01", &data), Verdict::Fails);
    assert_eq!(verdict(measured, "expected = -0.6667\nrequired_error = 0.001", &data), Verdict::CannotTell);
    // A law that doesn't hold has a larger error, and says so.
    let bent = one("a", law(&X, 0.01, |x| 3.0 / x + 1.0));
    let judged = judge(measured, "expected = -0.5\nrequired_error = 0.05", &bent);
    assert!(judged.note.unwrap().contains("scatter"));
    assert!(judged.standard_error.unwrap() > 0.02);
}

#[test]
fn exponents_with_a_correction() {
    let x: Vec<f64> = (0..9).map(|k| 64.0 * 2f64.powi(k)).collect();
    let data = one("a", law(&x, 0.01, |x| 2.0 * x.powf(-5.0 / 3.0) * (1.0 + 6.0 * x.powf(-1.0 / 3.0))));
    let measured = "exponent_with_correction = { of = \"a\", correction = -0.3333333333333333 }";
    let judged = judge(measured, "expected = -1.6667\nrequired_error = 0.1", &data);
    close(judged.measured, -5.0 / 3.0);
    assert_eq!(judged.verdict, Verdict::Holds);
    assert!(judged.note.unwrap().starts_with("without the correction -1.7"), "the plain exponent is beside it");
    let plain = judge("exponent = { of = \"a\" }", "expected = -1.6667\nrequired_error = 0.1", &data);
    assert_eq!(plain.verdict, Verdict::Fails);
    assert!(
        plain.standard_error.unwrap() < 0.5 * judged.standard_error.unwrap(),
        "the marginal error is the larger one"
    );
    assert_eq!(verdict(measured, "expected = -2.0\nrequired_error = 0.1", &data), Verdict::Fails);
    assert_eq!(verdict(measured, "expected = -1.7\nrequired_error = 0.001", &data), Verdict::CannotTell);
}

#[test]
fn local_exponents_at_the_end() {
    let data = one("a", law(&X, 0.01, |x| 1.0 / (1.0 + x)));
    let measured = "local_exponents = { of = \"a\" }";
    let judged = judge(measured, "expected = -1.0\nrequired_error = 0.03", &data);
    close(judged.measured, (17f64 / 33.0).ln() / 2f64.ln());
    close(judged.standard_error, 0.01 * 2f64.sqrt() / 2f64.ln());
    assert_eq!(judged.verdict, Verdict::Holds);
    assert!(judged.note.unwrap().starts_with("from point to point -0.585(20), "));
    assert_eq!(verdict(measured, "expected = -0.8\nrequired_error = 0.03", &data), Verdict::Fails);
    assert_eq!(verdict(measured, "expected = -1.0\nrequired_error = 0.01", &data), Verdict::CannotTell);
}

#[test]
fn monotonic_series() {
    let falls = "monotonic = { of = \"a\" }";
    let expected = "below = 0.0\nrequired_error = 0.02";
    let smooth = one("a", law(&X, 0.01, |x| 1.0 / (1.0 + x)));
    assert_eq!(verdict(falls, expected, &smooth), Verdict::Holds);
    assert_eq!(verdict(falls, "above = 0.0\nrequired_error = 0.02", &smooth), Verdict::Fails);
    // A step of one standard error against the trend is noise, a step of seven is not.
    let step =
        |size: f64| one("a", law(&X, 0.01, move |x| if x == 8.0 { (1.0 + size) / 5.0 } else { 1.0 / (1.0 + x) }));
    assert_eq!(verdict(falls, expected, &step(0.014)), Verdict::Holds);
    let judged = judge(falls, expected, &step(0.1));
    assert_eq!(judged.verdict, Verdict::Fails);
    close(judged.z, (0.22 - 0.2) / (0.0022f64.hypot(0.002)));
    assert!(judged.note.unwrap().contains("the step from 4 to 8 goes against the trend"));
    let flat = one("a", law(&X, 0.01, |_| 1.0));
    assert_eq!(verdict(falls, expected, &flat), Verdict::CannotTell);
}

/// SplitMix64 and the normal deviates of Box and Muller.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Points of a law with an error that is the same fraction of the law at its first point everywhere: mostly noise at the end.
    fn series(&mut self, x: &[f64], error: f64, law: impl Fn(f64) -> f64) -> Series {
        let y_error = error * law(x[0]);
        let point = |&x: &f64| Point { x, x_error: 0.0, y: law(x) + y_error * self.normal(), y_error };
        Series::new(x.iter().map(point).collect(), Vec::new())
    }
}

const SETS: usize = 400;

/// The z-scores of a claim over many sets of data, whose expectation is true.
fn scores(measured: &str, expected: f64, mut data: impl FnMut(&mut Noise) -> Data) {
    let mut noise = Noise(1);
    let expectation = format!("expected = {expected:?}\nrequired_error = 1.0");
    let claim = claim(measured, &expectation);
    let z: Vec<f64> =
        (0..SETS).map(|_| claim.judge(claim.measured.measure(&data(&mut noise))).z.expect("a number")).collect();
    let summary = standard_normal_summary(&z).unwrap();
    let chances = [summary.mean_p_value, summary.variance_p_value, summary.largest_p_value, summary.shape_p_value];
    assert!(chances.iter().all(|&chance| chance > 1e-3), "{measured}: {summary:?}");
}

#[test]
fn scores_of_exponents_are_normal() {
    scores("exponent = { of = \"a\" }", -1.0, |noise| one("a", noise.series(&X, 0.01, |x| 3.0 / x)));
}

#[test]
fn scores_of_exponents_with_errors_in_x_are_normal() {
    scores("exponent = { of = \"a\" }", -2.0, |noise| {
        let mut series = noise.series(&X, 1e-6, |x| x.powi(-2));
        for point in &mut series.points {
            point.x_error = 0.02 * point.x;
            point.x += point.x_error * noise.normal();
        }
        one("a", series)
    });
}

#[test]
fn scores_of_exponents_with_a_correction_are_normal() {
    let x: Vec<f64> = (0..9).map(|k| 2f64.powi(k)).collect();
    scores("exponent_with_correction = { of = \"a\", correction = -0.5 }", 0.5, |noise| {
        one("a", noise.series(&x, 0.02, |x| x.sqrt() * (1.0 + 0.5 / x.sqrt())))
    });
}

#[test]
fn scores_of_agreements_are_normal() {
    // The relative errors of the last points are 0.3 and 0.6.
    scores("agreement = { between = [\"a\", \"b\"] }", 0.0, |noise| {
        let mut data = one("a", noise.series(&X, 0.01, |x| 2.0 / x));
        data.insert("b".to_owned(), noise.series(&X, 0.02, |x| 2.0 / x));
        data
    });
}

#[test]
fn scores_of_interpolated_ratios_are_normal() {
    scores("ratio = { numerator = \"a\", denominator = \"b\" }", 0.7, |noise| {
        let mut data = one("a", noise.series(&[1.5, 2.5, 3.0, 3.5, 6.0], 0.01, |x| 0.7 * x.sqrt()));
        data.insert("b".to_owned(), noise.series(&X[..4], 0.02, f64::sqrt));
        data
    });
}

#[test]
fn scores_of_local_exponents_are_normal() {
    scores("local_exponents = { of = \"a\" }", -0.5, |noise| one("a", noise.series(&X, 0.01, |x| x.powf(-0.5))));
}
