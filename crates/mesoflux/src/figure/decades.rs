//! Ticks along a logarithmic axis: decades where there are some, else 1, 2, 5 or equal steps.

use super::scale::Scale;
use super::ticks::{Tick, Ticks, linear, power_of_ten};

/// More minor ticks than this are no help.
const MOST_MINOR: usize = 100;

/// The ticks of a logarithmic scale, at most so many labels, so that they fit.
pub(super) fn ticks(scale: &Scale, most: f64, fits: &dyn Fn(&[Tick]) -> bool) -> Ticks {
    let exponents = scale.low.log10().floor() as i32..=scale.high.log10().ceil() as i32;
    let multiples = |digits: &[i32]| -> Vec<(i32, i32)> {
        let all = exponents.clone().flat_map(|exponent| digits.iter().map(move |&digit| (digit, exponent)));
        all.filter(|&(digit, exponent)| scale.contains(value(digit, exponent))).collect()
    };
    let decades = multiples(&[1]);
    let minor = || {
        let minor = multiples(&[2, 3, 4, 5, 6, 7, 8, 9]);
        let minor = if minor.len() > MOST_MINOR { Vec::new() } else { minor };
        minor.into_iter().map(|(digit, exponent)| value(digit, exponent)).collect::<Vec<_>>()
    };
    if decades.len() < 3 {
        let major = labeled(&multiples(&[1, 2, 5]));
        if major.len() >= 3 && fits(&major) {
            let mut minor = minor();
            minor.retain(|value| major.iter().all(|tick| tick.value != *value));
            return Ticks { major, minor, factor: String::new() };
        }
    }
    if decades.len() < 2 {
        return linear(scale.low, scale.high, most, fits);
    }
    let mut stride = 1;
    loop {
        // Every second decade is 10⁻⁴, 10⁻², 1: counted from one, not from where the axis begins.
        let kept: Vec<_> = decades.iter().copied().filter(|(_, exponent)| exponent % stride == 0).collect();
        let mut major = labeled(&kept);
        if major.len() > 2 && (major.len() as f64 > most || !fits(&major)) {
            stride += 1;
            continue;
        }
        if !fits(&major) {
            major.truncate(1);
        }
        if major.is_empty() {
            major = labeled(&decades[..1]);
        }
        let unlabeled = decades.iter().filter(|(_, exponent)| exponent % stride != 0);
        let minor = if stride == 1 { minor() } else { unlabeled.map(|&(_, exponent)| value(1, exponent)).collect() };
        let minor = if minor.len() > MOST_MINOR { Vec::new() } else { minor };
        return Ticks { major, minor, factor: String::new() };
    }
}

fn value(digit: i32, exponent: i32) -> f64 {
    let power = 10f64.powi(exponent.abs());
    if exponent < 0 { f64::from(digit) / power } else { f64::from(digit) * power }
}

/// Plain numbers from 0.01 to 1000, all alike, else powers of ten.
fn labeled(multiples: &[(i32, i32)]) -> Vec<Tick> {
    let plain = multiples.iter().all(|(_, exponent)| (-2..=3).contains(exponent));
    let label = |digit: i32, exponent: i32| match (plain, digit) {
        (true, _) => format!("{:.*}", (-exponent).max(0) as usize, value(digit, exponent)),
        (false, 1) => power_of_ten(exponent),
        (false, digit) => format!("{digit}×{}", power_of_ten(exponent)),
    };
    let tick = |&(digit, exponent): &(i32, i32)| Tick { value: value(digit, exponent), label: label(digit, exponent) };
    multiples.iter().map(tick).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> String {
        let ticks = ticks(&Scale { low, high, logarithmic: true }, 6.0, &|_| true);
        ticks.major.iter().map(|tick| tick.label.as_str()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn decades_are_labeled_as_people_write_them() {
        for (low, high, expected) in [
            (0.008, 1.2, "0.01 0.1 1"),
            (1.0, 1000.0, "1 10 100 1000"),
            (3e-4, 2.0, "10⁻³ 10⁻² 10⁻¹ 10⁰"),
            (1e-8, 1e4, "10⁻⁶ 10⁻³ 10⁰ 10³"),
            (0.08, 1.2, "0.1 0.2 0.5 1"),
            (1.5e-5, 2e-4, "2×10⁻⁵ 5×10⁻⁵ 10⁻⁴ 2×10⁻⁴"),
            (2.0, 3.2, "2.0 2.2 2.4 2.6 2.8 3.0 3.2"),
        ] {
            assert_eq!(labels(low, high), expected, "{low} to {high}");
        }
    }

    #[test]
    fn minor_ticks_are_the_eight_between_decades() {
        let ticks = ticks(&Scale { low: 0.01, high: 10.0, logarithmic: true }, 6.0, &|_| true);
        assert_eq!(ticks.minor.len(), 3 * 8);
        assert_eq!(ticks.minor[..3], [0.02, 0.03, 0.04]);
    }
}
