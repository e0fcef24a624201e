//! A panel's layers as shapes in the pixels of its frame, cut off where the frame ends.

use super::canvas::{Canvas, Place};
use super::scale::Scale;
use super::style::{RADIUS, STROKE};
use super::{Layer, Point, Style};
use plotters::style::Color;

/// Half the width of an error bar's cap.
const CAP: f64 = 3.0;
const BAR: f64 = 1.2;
const DASH: (f64, f64) = (6.0, 4.0);
const FILL: f64 = 0.09;

/// A frame of some pixels with its scales.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub width: f64,
    pub height: f64,
    pub x: Scale,
    pub y: Scale,
}

/// What a layer puts into the frame.
#[derive(Debug, Clone)]
pub(super) enum Shape {
    Line { places: Vec<Place>, width: f64, style: Style },
    Area { places: Vec<Place>, style: Style },
    Marker { center: Place, style: Style },
}

impl Frame {
    /// All layers as shapes, the first layer lowest.
    pub fn shapes(&self, layers: &[Layer]) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for layer in layers {
            match layer {
                Layer::Points { points, style, .. } => self.points(points, *style, &mut shapes),
                Layer::Line { points, dashed, style, .. } => {
                    for places in self.pieces(points) {
                        let parts = if *dashed { dashes(&places) } else { vec![places] };
                        let line = |places| Shape::Line { places, width: STROKE, style: *style };
                        shapes.extend(parts.into_iter().map(line));
                    }
                }
                Layer::Histogram { edges, heights, style, .. } => self.histogram(edges, heights, *style, &mut shapes),
            }
        }
        shapes
    }

    fn place(&self, x: f64, y: f64) -> Option<Place> {
        Some((self.x.place(x)? * self.width, (1.0 - self.y.place(y)?) * self.height))
    }

    fn points(&self, points: &[Point], style: Style, shapes: &mut Vec<Shape>) {
        let shown = points.iter().filter(|point| self.x.contains(point.x) && self.y.contains(point.y));
        let placed: Vec<(&Point, Place)> =
            shown.filter_map(|point| Some((point, self.place(point.x, point.y)?))).collect();
        for (point, center) in &placed {
            let across = bar(&self.x, point.x, point.x_error, self.width);
            let along = bar(&self.y, point.y, point.y_error, self.height);
            let horizontal = across.map(|ends| crossbar(ends, |x, off| (x, center.1 + off)));
            let vertical = along.map(|ends| crossbar(ends, |y, off| (center.0 + off, self.height - y)));
            let line = |places| Shape::Line { places, width: BAR, style };
            shapes.extend(horizontal.into_iter().chain(vertical).map(line));
        }
        shapes.extend(placed.into_iter().map(|(_, center)| Shape::Marker { center, style }));
    }

    /// A line through points, broken where one has no place and cut where it leaves the frame.
    fn pieces(&self, points: &[(f64, f64)]) -> Vec<Vec<Place>> {
        let mut pieces: Vec<Vec<Place>> = Vec::new();
        let places: Vec<Option<Place>> = points.iter().map(|&(x, y)| self.place(x, y)).collect();
        for pair in places.windows(2) {
            let (Some(from), Some(to)) = (pair[0], pair[1]) else { continue };
            let Some((from, to)) = self.cut(from, to) else { continue };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&from) => piece.push(to),
                _ => pieces.push(vec![from, to]),
            }
        }
        pieces
    }

    /// The part of a segment within the frame (Liang & Barsky 1984).
    fn cut(&self, from: Place, to: Place) -> Option<(Place, Place)> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (step, room) in [(-dx, from.0), (dx, self.width - from.0), (-dy, from.1), (dy, self.height - from.1)] {
            if step == 0.0 && room < 0.0 {
                return None;
            }
            if step < 0.0 {
                enter = enter.max(room / step);
            } else if step > 0.0 {
                leave = leave.min(room / step);
            }
        }
        let at = |t: f64| match t {
            0.0 => from,
            1.0 => to,
            t => (from.0 + t * dx, from.1 + t * dy),
        };
        (enter <= leave).then(|| (at(enter), at(leave)))
    }

    fn histogram(&self, edges: &[f64], heights: &[f64], style: Style, shapes: &mut Vec<Shape>) {
        let base = self.height * (1.0 - self.y.place(0.0).unwrap_or(0.0).clamp(0.0, 1.0));
        let mut outline: Vec<Place> = Vec::new();
        for (edge, &height) in edges.windows(2).zip(heights) {
            let (Some(left), Some(right)) = (self.x.place(edge[0]), self.x.place(edge[1])) else { continue };
            let [left, right] = [left, right].map(|share| share.clamp(0.0, 1.0) * self.width);
            let top = self.y.place(height).map_or(base, |share| (1.0 - share.clamp(0.0, 1.0)) * self.height);
            if right <= left {
                continue;
            }
            match outline.last() {
                Some(last) if last.0 == left => {}
                Some(last) => outline.extend([(last.0, base), (left, base)]),
                None => outline.push((left, base)),
            }
            outline.extend([(left, top), (right, top)]);
        }
        let Some(last) = outline.last() else { return };
        outline.push((last.0, base));
        shapes.push(Shape::Area { places: outline.clone(), style });
        shapes.push(Shape::Line { places: outline, width: STROKE, style });
    }
}

/// The ends of an error bar in pixels along its axis, and whether each lies within the frame.
fn bar(scale: &Scale, value: f64, error: f64, length: f64) -> Option<[(f64, bool); 2]> {
    if !(error.abs() > 0.0 && error.is_finite()) {
        return None;
    }
    let end = |value: f64, beyond: f64| match scale.place(value) {
        Some(share) if (0.0..=1.0).contains(&share) => (share * length, true),
        _ => (beyond, false),
    };
    Some([end(value - error.abs(), 0.0), end(value + error.abs(), length)])
}

/// A bar with caps in one stroke; no cap where the bar goes on beyond the frame.
fn crossbar(ends: [(f64, bool); 2], place: impl Fn(f64, f64) -> Place) -> Vec<Place> {
    let mut stroke = Vec::new();
    for (end, capped) in ends {
        let offsets: &[f64] = if capped { &[0.0, -CAP, CAP, 0.0] } else { &[0.0] };
        stroke.extend(offsets.iter().map(|&offset| place(end, offset)));
    }
    stroke
}

/// A line as its dashes.
pub(super) fn dashes(places: &[Place]) -> Vec<Vec<Place>> {
    let mut parts = Vec::new();
    let mut part: Vec<Place> = places.first().copied().into_iter().collect();
    let (mut drawing, mut left) = (true, DASH.0);
    for pair in places.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            if length <= left {
                left -= length;
                part.push(to);
                break;
            }
            let share = left / length;
            from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            part.push(from);
            let done = std::mem::replace(&mut part, vec![from]);
            if drawing {
                parts.push(done);
            }
            drawing = !drawing;
            left = if drawing { DASH.0 } else { DASH.1 };
        }
    }
    if drawing && part.len() > 1 {
        parts.push(part);
    }
    parts
}

impl Shape {
    pub fn draw(&self, canvas: &mut Canvas) {
        match self {
            Self::Line { places, width, style } => canvas.line(places, *width, style.ink()),
            Self::Area { places, style } => canvas.area(places, style.ink().mix(FILL)),
            Self::Marker { center, style } => style.draw_marker(canvas, *center),
        }
    }

    /// Places all over the shape that nothing should hide.
    pub fn trace(&self) -> Vec<Place> {
        match self {
            Self::Line { places, .. } => places.windows(2).flat_map(|pair| along(pair[0], pair[1])).collect(),
            // Straight up and down inside every step of a histogram.
            Self::Area { places, .. } => {
                let base = places.first().map_or(0.0, |place| place.1);
                places.iter().flat_map(|&(x, y)| along((x, base), (x, y))).collect()
            }
            Self::Marker { center: (x, y), .. } => {
                vec![(x - RADIUS, *y), (x + RADIUS, *y), (*x, y - RADIUS), (*x, y + RADIUS)]
            }
        }
    }
}

/// Places every few pixels from one to another.
fn along(from: Place, to: Place) -> impl Iterator<Item = Place> {
    let count = ((to.0 - from.0).hypot(to.1 - from.1) / 4.0).ceil().max(1.0);
    (0..=count as usize).map(move |k| {
        let share = k as f64 / count;
        (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
    })
}
