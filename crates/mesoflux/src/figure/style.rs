//! What tells one series from another: a color and a marker.

use super::canvas::{Canvas, Place};
use plotters::prelude::*;

/// Colors that the color-blind can tell apart: Okabe & Ito's (2008), with brown in place of yellow, which is lost on white.
pub const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(60, 60, 60),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 60, 20),
];

/// The shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Marker {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ×, neither open nor filled
    Cross,
}

/// Color and marker of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Style {
    /// Place in [`PALETTE`], counted around.
    pub color: usize,
    /// The marker's shape.
    pub marker: Marker,
    /// Whether the marker is an outline rather than filled.
    pub open: bool,
}

// One more than the colors, so that color and marker together come back only after 8 · 9 series.
const MARKERS: [(Marker, bool); 9] = [
    (Marker::Circle, false),
    (Marker::Square, false),
    (Marker::Triangle, false),
    (Marker::Diamond, false),
    (Marker::Circle, true),
    (Marker::Square, true),
    (Marker::Triangle, true),
    (Marker::Diamond, true),
    (Marker::Cross, false),
];

pub(super) const RADIUS: f64 = 3.8;
pub(super) const STROKE: f64 = 1.5;

impl Style {
    /// The style of series number k, counted from zero; the first 72 differ from each other.
    pub fn nth(k: usize) -> Self {
        let (marker, open) = MARKERS[k % MARKERS.len()];
        Self { color: k % PALETTE.len(), marker, open }
    }

    pub(super) fn ink(self) -> RGBAColor {
        PALETTE[self.color % PALETTE.len()].to_rgba()
    }

    /// Draws the marker; of all shapes about equal area.
    pub(super) fn draw_marker(self, canvas: &mut Canvas, center: Place) {
        let (ink, paper) = (self.ink(), WHITE.to_rgba());
        let corners: &[Place] = match self.marker {
            Marker::Circle => {
                canvas.circle(center, RADIUS, None, if self.open { paper } else { ink });
                if self.open {
                    canvas.circle(center, RADIUS, Some(STROKE), ink);
                }
                return;
            }
            Marker::Cross => {
                for slope in [1.0, -1.0] {
                    let arm = 0.9 * RADIUS;
                    let end = |side: f64| (center.0 + side * arm, center.1 + side * slope * arm);
                    canvas.line(&[end(-1.0), end(1.0)], 1.2 * STROKE, ink);
                }
                return;
            }
            Marker::Square => &[(-0.89, -0.89), (0.89, -0.89), (0.89, 0.89), (-0.89, 0.89)],
            Marker::Triangle => &[(0.0, -1.25), (1.15, 0.8), (-1.15, 0.8)],
            Marker::Diamond => &[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)],
        };
        let mut outline: Vec<Place> =
            corners.iter().map(|(x, y)| (center.0 + x * RADIUS, center.1 + y * RADIUS)).collect();
        canvas.area(&outline, if self.open { paper } else { ink });
        if self.open {
            // Beyond the first corner, that the last be mitered like the others.
            outline.extend_from_within(..2);
            canvas.line(&outline, STROKE, ink);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn seventy_two_styles_differ() {
        let styles: HashSet<Style> = (0..72).map(Style::nth).collect();
        assert_eq!(styles.len(), 72);
    }

    /// CIE 1976 L*a*b* of a color as a dichromat sees it (Machado, Oliveira & Fernandes 2009, severity 1).
    fn seen(color: RGBColor, vision: [[f64; 3]; 3]) -> [f64; 3] {
        let linear = [color.0, color.1, color.2].map(|byte| {
            let level = f64::from(byte) / 255.0;
            if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
        });
        let dot = |row: [f64; 3], of: [f64; 3]| row.iter().zip(of).map(|(a, b)| a * b).sum::<f64>();
        let rgb = vision.map(|row| dot(row, linear).clamp(0.0, 1.0));
        let to_white =
            [[0.4339, 0.3763, 0.1899], [0.2126, 0.7152, 0.0722], [0.0178, 0.1095, 0.8729]].map(|row| dot(row, rgb));
        let [x, y, z] = to_white.map(|t| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn the_color_blind_tell_the_colors_apart() {
        let protan = [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ];
        let deutan =
            [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]];
        let tritan = [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ];
        for vision in [protan, deutan, tritan] {
            for (k, &first) in PALETTE.iter().enumerate() {
                for &second in &PALETTE[..k] {
                    let (a, b) = (seen(first, vision), seen(second, vision));
                    let difference = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    assert!(difference > 15.0, "{first:?} and {second:?}: {difference}");
                }
            }
        }
    }
}
