//! The figure of a response profile: flux against forcing by every route, with the coefficients as slopes.

use crate::report::value_with_error;
use crate::route::Response;
use mesoflux_io::results::EstimateRecord;
use plotters::prelude::*;

/// All routes of one measurement in one figure.
#[derive(Debug, Clone)]
pub struct Profile {
    /// The measurement's name.
    pub measurement: String,
    curves: Vec<Curve>,
}

#[derive(Debug, Clone)]
struct Curve {
    method: &'static str,
    coefficient: (f64, f64),
    points: Vec<Response>,
}

// Colors that the color-blind can tell apart (Okabe & Ito).
const COLORS: [RGBColor; 3] = [RGBColor(60, 60, 60), RGBColor(213, 94, 0), RGBColor(0, 114, 178)];

impl Profile {
    /// Adds a route's points to the figure of its measurement; a route that knows the coefficient alone adds a line.
    pub fn collect(profiles: &mut Vec<Self>, record: &EstimateRecord, points: &[Response]) {
        let (Some(value), Some(error)) = (record.value, record.standard_error) else {
            return;
        };
        let curve = Curve { method: record.method, coefficient: (value, error), points: points.to_vec() };
        match profiles.iter_mut().find(|profile| profile.measurement == record.measurement) {
            Some(profile) => profile.curves.push(curve),
            None => profiles.push(Self { measurement: record.measurement.clone(), curves: vec![curve] }),
        }
    }

    /// Whether there is any point to draw.
    pub fn is_worth_drawing(&self) -> bool {
        self.curves.iter().any(|curve| !curve.points.is_empty())
    }

    /// The figure as SVG.
    pub fn draw(&self, title: &str) -> String {
        let mut svg = String::new();
        // Drawing into a string meets no outside world that could fail.
        if self.draw_into(&mut svg, title).is_err() {
            svg.clear();
        }
        svg
    }

    fn draw_into(&self, svg: &mut String, title: &str) -> Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, (720, 480)).into_drawing_area();
        root.fill(&WHITE)?;
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let reach =
            |of: fn(&Response) -> (f64, f64)| points().map(|p| of(p).0.abs() + of(p).1).fold(0.0, f64::max) * 1.08;
        let (width, height) = (reach(|p| p.forcing), reach(|p| p.flux));
        let mut chart = ChartBuilder::on(&root)
            .caption(title, ("sans-serif", 18))
            .margin(16)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d(0.0..width, 0.0..height)?;
        chart
            .configure_mesh()
            .x_desc("forcing: η imposed, or mean λ measured")
            .y_desc("flux R: measured, or r imposed")
            .axis_desc_style(("sans-serif", 16))
            .label_style(("sans-serif", 14))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.08))
            .draw()?;
        for (curve, color) in self.curves.iter().zip(COLORS.iter().cycle()) {
            let (value, error) = curve.coefficient;
            let label = format!("{}: slope {}", name(curve.method), value_with_error(value, error));
            let end = if value * width > height { height / value } else { width };
            let line = LineSeries::new(
                [(0.0, 0.0), (end, value * end)],
                color.stroke_width(if curve.points.is_empty() { 2 } else { 1 }),
            );
            let entry = chart.draw_series(line)?.label(label);
            let color = *color;
            entry.legend(move |(x, y)| {
                EmptyElement::at((x, y))
                    + PathElement::new([(0, 0), (16, 0)], color)
                    + Circle::new((8, 0), 4, color.filled())
            });
            for point in &curve.points {
                let (x, y) = (point.forcing.0.abs(), point.flux.0.abs());
                let (dx, dy) = (point.forcing.1, point.flux.1);
                chart.draw_series([
                    PathElement::new([(x - dx, y), (x + dx, y)], color.stroke_width(2)),
                    PathElement::new([(x, y - dy), (x, y + dy)], color.stroke_width(2)),
                ])?;
                chart.draw_series([Circle::new((x, y), 4, color.filled())])?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .margin(12)
            .border_style(BLACK.mix(0.2))
            .background_style(WHITE)
            .label_font(("sans-serif", 15))
            .draw()?;
        root.present()?;
        Ok(())
    }
}

/// A method's name as people write it.
fn name(method: &str) -> &str {
    match method {
        "msd" => "mean squared displacement",
        "nemd" => "NEMD",
        "norton" => "Norton",
        other => other,
    }
}
