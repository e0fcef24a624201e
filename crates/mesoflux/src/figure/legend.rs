//! The legend of a panel: which series is which, where it hides none of them.

use super::canvas::{Anchor, Canvas, INK, Place, text_width};
use super::shape::{Shape, dashes};
use super::style::STROKE;
use super::{Layer, Style};
use plotters::style::{Color, WHITE};

pub(super) const SIZE: f64 = 12.0;
const ROW: f64 = 17.0;
const PADDING: f64 = 6.0;
const KEY: f64 = 26.0;
/// Between the legend and the frame.
const INSET: f64 = 8.0;
/// At least between the legend and the data.
const CLEARANCE: f64 = 6.0;

/// What stands for a series before its label.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Key {
    Marker(Style),
    Line(Style, bool),
    Step(Style),
}

/// A legend with its place in the pixels of the frame.
#[derive(Debug, Clone)]
pub(super) struct Legend<'a> {
    entries: Vec<(&'a str, Vec<Key>)>,
    columns: usize,
    corner: Place,
}

impl<'a> Legend<'a> {
    /// The legend of some layers, its place still open; `None` without labels. Layers of one label share an entry.
    pub fn new(layers: &'a [Layer]) -> Option<Self> {
        let mut entries: Vec<(&str, Vec<Key>)> = Vec::new();
        for layer in layers {
            let (label, key) = match layer {
                Layer::Points { label, style, .. } => (label, Key::Marker(*style)),
                Layer::Line { label, style, dashed, .. } => (label, Key::Line(*style, *dashed)),
                Layer::Histogram { label, style, .. } => (label, Key::Step(*style)),
            };
            match entries.iter_mut().find(|(other, _)| other == label) {
                _ if label.is_empty() => {}
                Some((_, keys)) => keys.push(key),
                None => entries.push((label, vec![key])),
            }
        }
        (!entries.is_empty()).then_some(Self { entries, columns: 1, corner: (0.0, 0.0) })
    }

    /// Moves to the emptiest corner of a frame of some width and height; false where every corner has data.
    pub fn fits_inside(&mut self, (width, height): (f64, f64), shapes: &[Shape]) -> bool {
        let trace: Vec<Place> = shapes.iter().flat_map(Shape::trace).collect();
        for columns in 1..=if self.entries.len() > 3 { 2 } else { 1 } {
            self.columns = columns;
            let (wide, high) = self.size();
            let (right, bottom) = (width - INSET - wide, height - INSET - high);
            if right < INSET || bottom < INSET {
                continue;
            }
            let mut best = None;
            for corner in [(right, INSET), (INSET, INSET), (right, bottom), (INSET, bottom)] {
                let clearance = clearance(&trace, corner, (wide, high));
                // The first of equals stays.
                if clearance >= CLEARANCE && best.is_none_or(|best| clearance > best + 1.0) {
                    (self.corner, best) = (corner, Some(clearance));
                }
            }
            if best.is_some() {
                return true;
            }
        }
        false
    }

    /// Moves beside a frame of some width and height.
    pub fn stand_beside(&mut self, (width, height): (f64, f64)) {
        let in_a_column = ((height - PADDING) / ROW).floor().max(1.0) as usize;
        self.columns = self.entries.len().div_ceil(in_a_column);
        self.corner = (width + INSET, 0.0);
    }

    /// How far it reaches beyond the right end of a frame.
    pub fn beyond(&self, width: f64) -> f64 {
        (self.corner.0 + self.size().0 - width).max(0.0)
    }

    fn rows(&self) -> usize {
        self.entries.len().div_ceil(self.columns)
    }

    fn column_width(&self) -> f64 {
        let widest = self.entries.iter().map(|(label, _)| text_width(label, SIZE)).fold(0.0, f64::max);
        KEY + 3.0 * PADDING + widest
    }

    fn size(&self) -> (f64, f64) {
        (self.columns as f64 * self.column_width(), self.rows() as f64 * ROW + PADDING)
    }

    /// Draws the legend; the canvas's origin is the frame's upper left corner.
    pub fn draw(&self, canvas: &mut Canvas) {
        let ((x, y), (wide, high)) = (self.corner, self.size());
        let outline = [(x, y), (x + wide, y), (x + wide, y + high), (x, y + high), (x, y)];
        canvas.area(&outline, WHITE.to_rgba());
        canvas.line(&outline, 0.8, INK.mix(0.25));
        for (k, (label, keys)) in self.entries.iter().enumerate() {
            let (column, row) = (k / self.rows(), k % self.rows());
            let left = x + PADDING + column as f64 * self.column_width();
            let middle = y + 0.5 * PADDING + (row as f64 + 0.5) * ROW;
            // Markers lie on their lines.
            for pass in [false, true] {
                keys.iter().filter(|key| matches!(key, Key::Marker(_)) == pass).for_each(|key| {
                    key.draw(canvas, (left, middle));
                });
            }
            canvas.text(label, (left + KEY + PADDING, middle), SIZE, Anchor::Start);
        }
    }
}

impl Key {
    fn draw(self, canvas: &mut Canvas, (x, y): Place) {
        match self {
            Self::Marker(style) => style.draw_marker(canvas, (x + 0.5 * KEY, y)),
            Self::Line(style, dashed) => {
                let line = vec![(x, y), (x + KEY, y)];
                let parts = if dashed { dashes(&line) } else { vec![line] };
                parts.iter().for_each(|part| canvas.line(part, STROKE, style.ink()));
            }
            Self::Step(style) => {
                let (low, high) = (y + 5.0, y - 5.0);
                let places = vec![(x + 4.0, low), (x + 4.0, high), (x + KEY - 4.0, high), (x + KEY - 4.0, low)];
                Shape::Area { places: places.clone(), style }.draw(canvas);
                Shape::Line { places, width: STROKE, style }.draw(canvas);
            }
        }
    }
}

/// The distance from a box to the nearest of some places, zero inside it.
fn clearance(places: &[Place], corner: Place, size: (f64, f64)) -> f64 {
    let off = |at: f64, low: f64, length: f64| (low - at).max(at - low - length).max(0.0);
    let distance = |&(x, y): &Place| off(x, corner.0, size.0).hypot(off(y, corner.1, size.1));
    places.iter().map(distance).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(label: &str, points: Vec<(f64, f64)>) -> (Layer, Shape) {
        let shape = Shape::Line { places: points.clone(), width: 1.0, style: Style::nth(0) };
        (Layer::Line { label: label.to_owned(), points, dashed: false, style: Style::nth(0) }, shape)
    }

    /// The corner inside a frame of 400 × 300, if one is free.
    fn placed(lines: Vec<(Layer, Shape)>) -> Option<Place> {
        let (layers, shapes): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
        let mut legend = Legend::new(&layers).unwrap();
        legend.fits_inside((400.0, 300.0), &shapes).then_some(legend.corner)
    }

    #[test]
    fn the_legend_takes_the_emptiest_corner() {
        let rising = line("rising", vec![(0.0, 300.0), (400.0, 0.0)]);
        assert_eq!(placed(vec![rising]), Some((INSET, INSET)));
        let falling = line("falling", vec![(0.0, 0.0), (400.0, 300.0)]);
        let corner = placed(vec![falling.clone()]).unwrap();
        assert!(corner.0 > 200.0 && corner.1 == INSET, "{corner:?}");
        let corner = placed(vec![falling, line("top", vec![(0.0, 5.0), (400.0, 5.0)])]).unwrap();
        assert!(corner.0 == INSET && corner.1 > 200.0, "{corner:?}");
    }

    #[test]
    fn a_legend_is_not_put_onto_data() {
        let zigzag: Vec<Place> = (0..40).map(|k| (10.0 * f64::from(k), 300.0 * f64::from(k % 2))).collect();
        assert_eq!(placed(vec![line("everywhere", zigzag)]), None);
    }

    #[test]
    fn entries_are_labels_without_the_empty_one() {
        let layers = ["a", "", "b", "a"].map(|label| line(label, vec![(0.0, 0.0), (1.0, 1.0)]).0);
        assert_eq!(Legend::new(&layers).unwrap().entries.len(), 2);
        assert!(Legend::new(&layers[1..2]).is_none());
    }
}
