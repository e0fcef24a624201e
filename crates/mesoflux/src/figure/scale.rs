//! From values to places along an axis, and which range of values an axis shows.

use super::Axis;

/// Beyond this, or below its inverse, arithmetic with values would leave the floating-point numbers.
const LARGEST: f64 = 1e250;
/// Room between the outermost point and the frame, as a share of the range.
const MARGIN: f64 = 0.05;
/// Zero is shown where it lies this near to the data, as a share of the largest value.
const NEAR_ZERO: f64 = 0.2;

/// A range of values laid along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub logarithmic: bool,
}

impl Scale {
    /// Where a value lies: 0 at the low end, 1 at the high one; `None` for what the axis can't show at any place.
    pub fn place(&self, value: f64) -> Option<f64> {
        let share = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        (shows(value, self.logarithmic) && share.abs() < 1e100).then_some(share)
    }

    /// The scale with its high end moved up by a share of its length.
    pub fn raised(self, share: f64) -> Self {
        let high = if self.logarithmic {
            self.high * (self.high / self.low).powf(share)
        } else {
            self.high + share * (self.high - self.low)
        };
        if high.is_finite() { Self { high, ..self } } else { self }
    }

    /// Whether a value lies in the range.
    pub fn contains(&self, value: f64) -> bool {
        self.place(value).is_some_and(|share| (-1e-9..=1.0 + 1e-9).contains(&share))
    }
}

/// Whether an axis has a place for a value.
pub(super) fn shows(value: f64, logarithmic: bool) -> bool {
    value.abs() <= LARGEST && (!logarithmic || value >= 1.0 / LARGEST)
}

/// What the data span along an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    logarithmic: bool,
    // What wants room to the frame, and what may touch it.
    roomy: (f64, f64),
    tight: (f64, f64),
}

impl Extent {
    pub fn new(logarithmic: bool) -> Self {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        Self { logarithmic, roomy: nothing, tight: nothing }
    }

    /// Takes in a value that wants room between itself and the frame.
    pub fn value(&mut self, value: f64) {
        if shows(value, self.logarithmic) {
            self.roomy = (self.roomy.0.min(value), self.roomy.1.max(value));
        }
    }

    /// Takes in a value that may touch the frame.
    pub fn touching(&mut self, value: f64) {
        if shows(value, self.logarithmic) {
            self.tight = (self.tight.0.min(value), self.tight.1.max(value));
        }
    }

    /// Takes in a value that stands on zero, where the axis has one, and wants room on the far side.
    pub fn standing_on_zero(&mut self, value: f64) {
        if self.logarithmic {
            self.value(value);
        } else if shows(value, false) {
            self.touching(0.0);
            let far = if value < 0.0 { &mut self.roomy.0 } else { &mut self.roomy.1 };
            *far = if value < 0.0 { far.min(value) } else { far.max(value) };
        }
    }

    /// Takes in a value with its error bar; on a logarithmic axis no more than half a decade of the lower half.
    pub fn with_error(&mut self, value: f64, error: f64) {
        if !shows(value, self.logarithmic) {
            return;
        }
        let error = if error.is_finite() { error.abs() } else { 0.0 };
        let least = if self.logarithmic { value / 10f64.sqrt() } else { f64::NEG_INFINITY };
        self.value(value);
        self.value(value + error);
        self.value((value - error).max(least));
    }

    /// The range asked for, or else one that shows all data with some room; some range whatever the data.
    pub fn scale(&self, axis: &Axis) -> Scale {
        let logarithmic = self.logarithmic;
        if let Some((a, b)) = axis.range {
            let (low, high) = (a.min(b), a.max(b));
            if shows(a, logarithmic) && shows(b, logarithmic) && is_wide(low, high) {
                return Scale { low, high, logarithmic };
            }
        }
        let (low, high) = (self.roomy.0.min(self.tight.0), self.roomy.1.max(self.tight.1));
        let (low, high) = if logarithmic { self.decades(low, high) } else { self.interval(low, high) };
        Scale { low, high, logarithmic }
    }

    fn decades(&self, low: f64, high: f64) -> (f64, f64) {
        if !(low <= high) {
            return (1.0, 10.0);
        }
        if !is_wide(low, high) {
            return (low / 3.0, high * 3.0);
        }
        let room = (high / low).powf(MARGIN);
        ((self.roomy.0 / room).min(self.tight.0), (self.roomy.1 * room).max(self.tight.1))
    }

    fn interval(&self, low: f64, high: f64) -> (f64, f64) {
        if !(low <= high) {
            return (0.0, 1.0);
        }
        if !is_wide(low, high) {
            let around = if low.abs() < 1.0 / LARGEST { 1.0 } else { 0.5 * low.abs() };
            return (low - around, high + around);
        }
        let room = MARGIN * (high - low);
        let near = |end: f64, far: f64| end != 0.0 && (MARGIN..=NEAR_ZERO).contains(&(end / far));
        let from = if near(low, high) { 0.0 } else { (self.roomy.0 - room).min(self.tight.0) };
        let to = if near(high, low) { 0.0 } else { (self.roomy.1 + room).max(self.tight.1) };
        (from, to)
    }
}

/// Whether the ends are far enough apart for ticks between them.
fn is_wide(low: f64, high: f64) -> bool {
    high - low > 1e-10 * low.abs().max(high.abs()) && high - low > 1.0 / LARGEST
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(logarithmic: bool, data: &[(f64, f64)], range: Option<(f64, f64)>) -> (f64, f64) {
        let mut extent = Extent::new(logarithmic);
        data.iter().for_each(|&(value, error)| extent.with_error(value, error));
        let scale = extent.scale(&Axis { label: String::new(), logarithmic, range });
        (scale.low, scale.high)
    }

    #[test]
    fn error_bars_lie_within_the_range_with_room() {
        let (low, high) = chosen(false, &[(-3.0, 1.0), (5.0, 1.0)], None);
        assert_eq!((low, high), (-4.5, 6.5));
        assert_eq!(chosen(false, &[(100.0, 1.0), (109.0, 0.0)], None), (98.5, 109.5));
    }

    #[test]
    fn a_near_zero_is_shown() {
        assert_eq!(chosen(false, &[(0.1, 0.0), (1.0, 0.0)], None).0, 0.0);
        assert_eq!(chosen(false, &[(-0.1, 0.0), (-1.0, 0.0)], None).1, 0.0);
        assert!(chosen(false, &[(0.0, 0.0), (1.0, 0.0)], None).0 < 0.0);
    }

    #[test]
    fn logarithmic_ranges_leave_out_what_is_not_positive() {
        let (low, high) = chosen(true, &[(-1.0, 0.1), (0.0, 0.1), (1.0, 0.0), (100.0, 0.0)], None);
        assert!((low - 10f64.powf(-0.1)).abs() < 1e-12 && (high - 10f64.powf(2.1)).abs() < 1e-9, "{low} {high}");
        let (low, _) = chosen(true, &[(1.0, 2.0), (100.0, 0.0)], None);
        assert!(low > 0.2 && low < 10f64.sqrt().recip(), "{low}");
    }

    #[test]
    fn every_data_have_a_range() {
        let odd = [0.0, -1.0, 1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, 7.25];
        for logarithmic in [false, true] {
            for a in odd {
                for b in odd {
                    for range in [None, Some((a, b)), Some((0.0, 0.0)), Some((-1.0, 2.0))] {
                        let data = [(a, b), (b, a)];
                        for data in [&data[..], &data[..1], &[]] {
                            let (low, high) = chosen(logarithmic, data, range);
                            assert!(low < high && low.is_finite() && high.is_finite(), "{a} {b} {range:?}");
                            assert!(!logarithmic || low > 0.0, "{a} {b} {range:?}: {low}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_range_asked_for_is_kept() {
        assert_eq!(chosen(false, &[(1.0, 0.0)], Some((3.0, -2.0))), (-2.0, 3.0));
        assert_eq!(chosen(true, &[(1.0, 0.0), (10.0, 0.0)], Some((0.01, 100.0))), (0.01, 100.0));
        assert!(chosen(true, &[(1.0, 0.0), (10.0, 0.0)], Some((-1.0, 100.0))).0 > 0.0);
    }
}
