//! Ticks along an axis: round numbers, as many as their labels have room for.

use super::scale::Scale;

/// A labeled tick.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub label: String,
}

/// The ticks of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    pub major: Vec<Tick>,
    pub minor: Vec<f64>,
    /// What all labels are to be multiplied by, "×10⁻⁵", where it isn't one.
    pub factor: String,
}

/// Free pixels between two labels.
const GAP: f64 = 8.0;

/// The ticks of a scale on an axis of some pixels, given a label's extent along the axis.
pub(super) fn ticks(scale: &Scale, length: f64, extent: impl Fn(&str) -> f64, apart: f64) -> Ticks {
    let fits = |ticks: &[Tick]| {
        let place = |tick: &Tick| scale.place(tick.value).unwrap_or(0.0) * length;
        ticks.windows(2).all(|pair| {
            let room = 0.5 * (extent(&pair[0].label) + extent(&pair[1].label)) + GAP;
            place(&pair[1]) - place(&pair[0]) >= room
        })
    };
    let most = (length / apart).clamp(2.0, 10.0);
    if scale.logarithmic {
        super::decades::ticks(scale, most, &fits)
    } else {
        linear(scale.low, scale.high, most, &fits)
    }
}

/// 1, 2 or 5 times a power of ten.
#[derive(Debug, Clone, Copy)]
struct Step {
    digit: i64,
    power: i32,
}

impl Step {
    fn at_least(size: f64) -> Self {
        let mut step = Self { digit: 1, power: size.log10().floor() as i32 - 1 };
        while step.times(1) < size * (1.0 - 1e-9) {
            step = step.next();
        }
        step
    }

    fn next(self) -> Self {
        match self.digit {
            1 => Self { digit: 2, ..self },
            2 => Self { digit: 5, ..self },
            _ => Self { digit: 1, power: self.power + 1 },
        }
    }

    fn previous(self) -> Self {
        match self.digit {
            1 => Self { digit: 5, power: self.power - 1 },
            2 => Self { digit: 1, ..self },
            _ => Self { digit: 2, ..self },
        }
    }

    /// The step of minor ticks.
    fn finer(self) -> Self {
        match self.digit {
            1 => Self { digit: 2, power: self.power - 1 },
            2 => Self { digit: 5, power: self.power - 1 },
            _ => Self { digit: 1, ..self },
        }
    }

    /// A multiple, rounded only once.
    fn times(self, k: i64) -> f64 {
        scaled(self.digit * k, self.power)
    }

    /// Which multiples lie in a range.
    fn within(self, low: f64, high: f64) -> std::ops::RangeInclusive<i64> {
        let size = self.times(1);
        (low / size - 1e-6).ceil() as i64..=(high / size + 1e-6).floor() as i64
    }
}

fn scaled(number: i64, power: i32) -> f64 {
    if power < 0 { number as f64 / 10f64.powi(-power) } else { number as f64 * 10f64.powi(power) }
}

/// Ticks at equal steps.
pub(super) fn linear(low: f64, high: f64, most: f64, fits: &dyn Fn(&[Tick]) -> bool) -> Ticks {
    let mut step = Step::at_least((high - low) / most);
    // Half the range or less meets at least two multiples.
    while step.times(1) > 0.5 * (high - low) {
        step = step.previous();
    }
    loop {
        let multiples = step.within(low, high);
        let largest = multiples.clone().map(|k| step.times(k).abs()).fold(0.0, f64::max);
        let leading = if largest > 0.0 { (largest * (1.0 + 1e-9)).log10().floor() as i32 } else { 0 };
        let exponent = if leading < -3 || leading >= 5 && step.power >= 1 { leading } else { 0 };
        let decimals = (exponent - step.power).max(0) as usize;
        let label = |k: i64| match k {
            0 => "0".to_owned(),
            k => format!("{:.decimals$}", scaled(step.digit * k, step.power - exponent)).replace('-', "−"),
        };
        let mut major: Vec<Tick> = multiples.map(|k| Tick { value: step.times(k), label: label(k) }).collect();
        let fine = step.finer();
        let minor = fine.within(low, high).map(|k| fine.times(k));
        let minor = minor.filter(|value| major.iter().all(|tick| tick.value != *value)).collect();
        if !fits(&major) && !step.next().within(low, high).is_empty() {
            step = step.next();
            continue;
        }
        if !fits(&major) {
            major.truncate(1);
        }
        let factor = if exponent == 0 { String::new() } else { format!("×{}", power_of_ten(exponent)) };
        return Ticks { major, minor, factor };
    }
}

/// 10 to a power, the power raised.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit.to_digit(10).unwrap_or(0) as usize],
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, most: f64) -> (String, String) {
        let ticks = linear(low, high, most, &|_| true);
        (ticks.major.iter().map(|tick| tick.label.as_str()).collect::<Vec<_>>().join(" "), ticks.factor)
    }

    #[test]
    fn linear_ticks_are_round() {
        for (low, high, most, expected, factor) in [
            (0.0, 1.0, 5.0, "0 0.2 0.4 0.6 0.8 1.0", ""),
            (-0.3, 0.3, 6.0, "−0.3 −0.2 −0.1 0 0.1 0.2 0.3", ""),
            (98.5, 109.5, 5.0, "100 105", ""),
            (0.0, 2.6e-5, 6.0, "0 0.5 1.0 1.5 2.0 2.5", "×10⁻⁵"),
            (-3e6, 3e6, 4.0, "−2 0 2", "×10⁶"),
            (100_000.5, 100_001.5, 4.0, "100000.5 100001.0 100001.5", ""),
            (0.0, 40_000.0, 4.0, "0 10000 20000 30000 40000", ""),
        ] {
            assert_eq!(labels(low, high, most), (expected.to_owned(), factor.to_owned()), "{low} to {high}");
        }
    }

    #[test]
    fn minor_ticks_divide_the_steps() {
        let ticks = linear(0.0, 1.0, 5.0, &|_| true);
        assert_eq!(ticks.minor.len(), 15);
        assert_eq!(ticks.minor[..3], [0.05, 0.1, 0.15]);
        assert_eq!(linear(0.0, 5.0, 5.0, &|_| true).minor.len(), 20);
    }

    #[test]
    fn labels_never_overlap() {
        for logarithmic in [false, true] {
            for (k, &low) in [1e-9, 3e-4, 0.07, 1.0, 5.3, 123.456, 1e6, 1e12].iter().enumerate() {
                for ratio in [1.0 + 1e-9, 1.001, 1.3, 3.0, 12.0, 150.0, 1e5, 1e20] {
                    for length in [60.0, 380.0] {
                        let scale = Scale { low, high: low * ratio, logarithmic };
                        let width = |label: &str| 8.0 * label.chars().count() as f64;
                        let found = ticks(&scale, length, width, 70.0).major;
                        assert!(!found.is_empty() && found.len() <= 12, "case {k}, {ratio}: {found:?}");
                        for pair in found.windows(2) {
                            let places = [&pair[0], &pair[1]].map(|tick| scale.place(tick.value).unwrap() * length);
                            let room = 0.5 * (width(&pair[0].label) + width(&pair[1].label));
                            assert!(places[1] - places[0] > room, "case {k}, {ratio}: {pair:?} at {places:?}");
                            assert_ne!(pair[0].label, pair[1].label);
                        }
                        assert!(found.iter().all(|tick| scale.contains(tick.value)), "{low} {ratio}: {found:?}");
                    }
                }
            }
        }
    }
}
