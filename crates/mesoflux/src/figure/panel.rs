//! One panel: its scales chosen from its data, ticks, frame, layers and legend.

use super::canvas::{Anchor, Canvas, INK, Place, fitting_size, text_width};
use super::legend::Legend;
use super::scale::{Extent, Scale};
use super::shape::{Frame, Shape};
use super::ticks::{Ticks, ticks};
use super::{Axis, Layer, Panel};
use plotters::style::Color;

const TITLE: f64 = 14.0;
const LABEL: f64 = 14.0;
const NUMBER: f64 = 12.0;
/// Between neighbors at least.
const EDGE: f64 = 12.0;
const MAJOR: f64 = 6.0;
const MINOR: f64 = 3.0;
/// How much of its range an axis may add for the legend's sake.
const HEADROOM: [f64; 4] = [0.1, 0.2, 0.3, 0.4];

/// Room around a frame for what belongs to it, in pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Margins {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Margins {
    pub fn union(self, other: Self) -> Self {
        Self {
            left: self.left.max(other.left),
            right: self.right.max(other.right),
            top: self.top.max(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// A panel with all that decides how much room it takes.
pub(super) struct Layout<'a> {
    panel: &'a Panel,
    frame: Frame,
    x_ticks: Ticks,
    y_ticks: Ticks,
    shapes: Vec<Shape>,
    legend: Option<Legend<'a>>,
}

impl<'a> Layout<'a> {
    pub fn new(panel: &'a Panel, size: (f64, f64)) -> Self {
        let (width, height) = size;
        let x = x_extent(panel).scale(&panel.x);
        let closest = y_extent(panel, &x).scale(&panel.y);
        let mut frame = Frame { width, height, x, y: closest };
        let mut shapes = frame.shapes(&panel.layers);
        let mut legend = Legend::new(&panel.layers);
        if let Some(legend) = &mut legend
            && !legend.fits_inside(size, &shapes)
        {
            // Some headroom above the data, or else a place beside the frame.
            let raised = HEADROOM.iter().filter(|_| panel.y.range.is_none()).find_map(|&share| {
                let raised = Frame { y: closest.raised(share), ..frame };
                let shapes = raised.shapes(&panel.layers);
                legend.fits_inside(size, &shapes).then_some((raised, shapes))
            });
            match raised {
                Some(found) => (frame, shapes) = found,
                None => legend.stand_beside(size),
            }
        }
        let x_ticks = ticks(&x, width, |label| text_width(label, NUMBER), 50.0);
        let y_ticks = ticks(&frame.y, height, |_| NUMBER, 45.0);
        Self { panel, frame, x_ticks, y_ticks, shapes, legend }
    }

    /// The room that the panel takes around its frame.
    pub fn margins(&self) -> Margins {
        let some = |text: &str, room: f64| if text.is_empty() { 0.0 } else { room };
        let last = self.x_ticks.major.last().map_or(0.0, |tick| 0.5 * text_width(&tick.label, NUMBER));
        let beyond = self.legend.as_ref().map_or(0.0, |legend| legend.beyond(self.frame.width));
        Margins {
            left: 10.0 + some(&self.panel.y.label, LABEL + 8.0) + self.y_number_width() + 7.0,
            right: 10.0 + last.max(beyond),
            top: EDGE + some(&self.panel.title, TITLE + 8.0) + some(&self.y_ticks.factor, NUMBER + 2.0),
            bottom: 10.0 + NUMBER + 7.0 + some(&self.panel.x.label, LABEL + 8.0),
        }
    }

    fn y_number_width(&self) -> f64 {
        self.y_ticks.major.iter().map(|tick| text_width(&tick.label, NUMBER)).fold(0.0, f64::max)
    }

    /// Draws the panel, its title at the upper end of the room above; the canvas's origin is the frame's upper left corner.
    pub fn draw(&self, canvas: &mut Canvas, top: f64) {
        let Frame { width, height, .. } = self.frame;
        self.draw_grid(canvas);
        self.shapes.iter().for_each(|shape| shape.draw(canvas));
        canvas.line(
            &[(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0), (width, 0.0)],
            1.0,
            INK.to_rgba(),
        );
        self.draw_ticks(canvas);
        if let Some(legend) = &self.legend {
            legend.draw(canvas);
        }
        canvas.text(&self.y_ticks.factor, (0.0, -NUMBER + 2.0), NUMBER, Anchor::Start);
        let title = &self.panel.title;
        canvas.text(title, (0.5 * width, 0.5 * TITLE + EDGE - top), fitting_size(title, TITLE, width), Anchor::Middle);
        let below = height + 7.0 + NUMBER;
        canvas.text(&self.x_ticks.factor, (width, below + 4.0 + 0.5 * LABEL), NUMBER, Anchor::End);
        let label = &self.panel.x.label;
        let room = width - 2.0 * text_width(&self.x_ticks.factor, NUMBER);
        canvas.text(label, (0.5 * width, below + 5.0 + 0.5 * LABEL), fitting_size(label, LABEL, room), Anchor::Middle);
        let label = &self.panel.y.label;
        let aside = -(7.0 + self.y_number_width() + 6.0 + 0.5 * LABEL);
        canvas.text(label, (aside, 0.5 * height), fitting_size(label, LABEL, height), Anchor::Upward);
    }

    fn draw_grid(&self, canvas: &mut Canvas) {
        let Frame { width, height, .. } = self.frame;
        for tick in &self.x_ticks.major {
            let x = self.across(tick.value);
            canvas.line(&[(x, 0.0), (x, height)], 0.8, INK.mix(0.1));
        }
        for tick in &self.y_ticks.major {
            let y = self.down(tick.value);
            canvas.line(&[(0.0, y), (width, y)], 0.8, INK.mix(0.1));
        }
    }

    fn draw_ticks(&self, canvas: &mut Canvas) {
        let Frame { width, height, .. } = self.frame;
        let mut mark = |from: Place, to: Place| canvas.line(&[from, to], 1.0, INK.to_rgba());
        let lengths = |ticks: &Ticks| {
            let major = ticks.major.iter().map(|tick| (tick.value, MAJOR));
            major.chain(ticks.minor.iter().map(|&value| (value, MINOR))).collect::<Vec<_>>()
        };
        for (value, length) in lengths(&self.x_ticks) {
            let x = self.across(value);
            mark((x, height), (x, height - length));
            mark((x, 0.0), (x, length));
        }
        for (value, length) in lengths(&self.y_ticks) {
            let y = self.down(value);
            mark((0.0, y), (length, y));
            mark((width, y), (width - length, y));
        }
        for tick in &self.x_ticks.major {
            let place = (self.across(tick.value), height + 7.0 + 0.5 * NUMBER);
            canvas.text(&tick.label, place, NUMBER, Anchor::Middle);
        }
        for tick in &self.y_ticks.major {
            canvas.text(&tick.label, (-7.0, self.down(tick.value)), NUMBER, Anchor::End);
        }
    }

    fn across(&self, x: f64) -> f64 {
        self.frame.x.place(x).unwrap_or(0.0) * self.frame.width
    }

    fn down(&self, y: f64) -> f64 {
        (1.0 - self.frame.y.place(y).unwrap_or(0.0)) * self.frame.height
    }
}

fn x_extent(panel: &Panel) -> Extent {
    let mut extent = Extent::new(panel.x.logarithmic);
    for layer in &panel.layers {
        match layer {
            Layer::Points { points, .. } => {
                let shown = points.iter().filter(|point| super::scale::shows(point.y, panel.y.logarithmic));
                shown.for_each(|point| extent.with_error(point.x, point.x_error));
            }
            Layer::Line { points, .. } => points.iter().for_each(|point| extent.touching(point.0)),
            Layer::Histogram { edges, .. } => edges.iter().for_each(|&edge| extent.value(edge)),
        }
    }
    extent
}

/// What the data within the range of x span.
fn y_extent(panel: &Panel, x: &Scale) -> Extent {
    let Axis { logarithmic, .. } = panel.y;
    let mut extent = Extent::new(logarithmic);
    for layer in &panel.layers {
        match layer {
            Layer::Points { points, .. } => {
                let shown = points.iter().filter(|point| x.contains(point.x));
                shown.for_each(|point| extent.with_error(point.y, point.y_error));
            }
            Layer::Line { points, .. } => {
                let within: Vec<f64> = points.iter().filter(|point| x.contains(point.0)).map(|point| point.1).collect();
                // Both ends of a long straight line may lie outside.
                let all = || points.iter().map(|point| point.1).collect();
                for y in if within.len() < 2 { all() } else { within } {
                    if y == 0.0 { extent.touching(y) } else { extent.value(y) }
                }
            }
            Layer::Histogram { edges, heights, .. } => {
                let shown =
                    edges.windows(2).zip(heights).filter(|(edge, _)| x.contains(edge[0]) || x.contains(edge[1]));
                shown.for_each(|(_, &height)| extent.standing_on_zero(height));
            }
        }
    }
    extent
}
