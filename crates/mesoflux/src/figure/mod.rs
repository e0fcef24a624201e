//! Scientific figures as SVG: panels in a grid, points with error bars, lines, histograms, linear and logarithmic axes.
//!
//! A figure is data; [`Figure::svg`] chooses ranges, ticks and the legend's place, and gives the same bytes for the same data.
//! What can't be drawn (a number that isn't finite, or isn't positive on a logarithmic axis) is left out.
//!
//! ```
//! use mesoflux::figure::{Axis, Figure, Layer, Panel, Point, Style};
//! let point = |x: f64| Point { x, y: x * x, x_error: 0.0, y_error: 0.1 * x };
//! let points = (1..10).map(|k| point(f64::from(k))).collect();
//! let layer = Layer::Points { label: "measured".to_owned(), points, style: Style::nth(0) };
//! let axis = |label: &str| Axis { label: label.to_owned(), logarithmic: true, range: None };
//! let panel = Panel { title: String::new(), x: axis("wave number k"), y: axis("U₁"), layers: vec![layer] };
//! let figure = Figure { title: "Squares".to_owned(), columns: 1, panels: vec![panel] };
//! assert!(figure.svg().starts_with("<svg"));
//! ```

mod canvas;
mod decades;
mod legend;
mod panel;
mod scale;
mod shape;
mod style;
mod ticks;

pub use style::{Marker, PALETTE, Style};

use canvas::{Anchor, Canvas, fitting_size};
use panel::{Layout, Margins};

/// Panels in a grid under a title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Above all panels; may be empty.
    pub title: String,
    /// How many panels stand side by side; at least one.
    pub columns: usize,
    /// Row by row.
    pub panels: Vec<Panel>,
}

/// Two axes and what is drawn between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Above the frame; may be empty.
    pub title: String,
    /// Rightward.
    pub x: Axis,
    /// Upward.
    pub y: Axis,
    /// The first one lowest.
    pub layers: Vec<Layer>,
}

/// An axis of a panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// The quantity with its unit.
    pub label: String,
    /// Whether equal ratios take equal lengths.
    pub logarithmic: bool,
    /// The values at both ends; without it, or where the axis can't show it, the range follows from the data.
    pub range: Option<(f64, f64)>,
}

/// A measured point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Half the length of the horizontal error bar; none if zero or not finite.
    pub x_error: f64,
    /// Half the length of the vertical error bar; none if zero or not finite.
    pub y_error: f64,
}

/// A series of a panel. Layers of one label share an entry of the legend; an empty label gives none.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// Markers with error bars.
    Points {
        /// For the legend.
        label: String,
        /// In any order.
        points: Vec<Point>,
        /// Color and marker.
        style: Style,
    },
    /// A line from point to point.
    Line {
        /// For the legend.
        label: String,
        /// (x, y) in the order in which they are joined.
        points: Vec<(f64, f64)>,
        /// Dashed rather than solid.
        dashed: bool,
        /// The color.
        style: Style,
    },
    /// Steps over bins.
    Histogram {
        /// For the legend.
        label: String,
        /// Ends of the bins, ascending, one more than bins.
        edges: Vec<f64>,
        /// One a bin.
        heights: Vec<f64>,
        /// The color.
        style: Style,
    },
}

const TITLE: f64 = 17.0;
const EDGE: f64 = 6.0;

impl Figure {
    /// The figure as SVG.
    pub fn svg(&self) -> String {
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let frame = match columns {
            1 => (560.0, 370.0),
            2 => (400.0, 300.0),
            _ => (320.0, 240.0),
        };
        let layouts: Vec<Layout> = self.panels.iter().map(|panel| Layout::new(panel, frame)).collect();
        // Frames stand in line: a column shares its left and right margins, a row its upper and lower ones.
        let shared = |which: &dyn Fn(usize) -> bool| {
            let of = layouts.iter().enumerate().filter(|(k, _)| which(*k)).map(|(_, layout)| layout.margins());
            of.fold(Margins::default(), Margins::union)
        };
        let by_column: Vec<Margins> = (0..columns).map(|column| shared(&|k| k % columns == column)).collect();
        let rows = layouts.len().div_ceil(columns);
        let by_row: Vec<Margins> = (0..rows).map(|row| shared(&|k| k / columns == row)).collect();
        let title = if self.title.is_empty() { 0.0 } else { 2.0 * TITLE };
        let width = 2.0 * EDGE + by_column.iter().map(|of| of.left + frame.0 + of.right).sum::<f64>();
        let height = 2.0 * EDGE + title + by_row.iter().map(|of| of.top + frame.1 + of.bottom).sum::<f64>();
        Canvas::sheet(width, height, |canvas| {
            let size = fitting_size(&self.title, TITLE, width - 4.0 * EDGE);
            canvas.text(&self.title, (0.5 * width, EDGE + 0.6 * title), size, Anchor::Middle);
            let mut y = EDGE + title;
            for (row, vertical) in layouts.chunks(columns).zip(&by_row) {
                let mut x = EDGE;
                for (layout, horizontal) in row.iter().zip(&by_column) {
                    canvas.origin = (x + horizontal.left, y + vertical.top);
                    layout.draw(canvas, vertical.top);
                    x += horizontal.left + frame.0 + horizontal.right;
                }
                y += vertical.top + frame.1 + vertical.bottom;
            }
        })
    }
}
