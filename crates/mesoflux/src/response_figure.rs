//! The figure of a response profile: flux against forcing by every route, with the coefficients as slopes.

use crate::figure::{Axis, Figure, Layer, Panel, Point, Style};
use crate::report::value_with_error;
use crate::route::{Outcome, Response};
use mesoflux_io::results::EstimateRecord;

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
    fitted: Vec<(f64, f64)>,
}

impl Profile {
    /// Adds a route's points to the figure of its measurement; a route that knows the coefficient alone adds a line.
    pub fn collect(profiles: &mut Vec<Self>, record: &EstimateRecord, outcome: &Outcome) {
        let (Some(value), Some(error)) = (record.value, record.standard_error) else {
            return;
        };
        let (points, fitted) = (outcome.response.clone(), outcome.fitted.clone());
        let curve = Curve { method: record.method, coefficient: (value, error), points, fitted };
        match profiles.iter_mut().find(|profile| profile.measurement == record.measurement) {
            Some(profile) => profile.curves.push(curve),
            None => profiles.push(Self { measurement: record.measurement.clone(), curves: vec![curve] }),
        }
    }

    /// Whether there is any point to draw.
    pub fn is_worth_drawing(&self) -> bool {
        self.curves.iter().any(|curve| !curve.points.is_empty())
    }

    /// The figure: points with errors, each route's straight line through the origin, dashed where a curve was fitted.
    pub fn figure(&self, title: &str) -> Figure {
        let reach = [-1.0, 1.0].map(|side| self.reach(side));
        let layers = self.curves.iter().enumerate().flat_map(|(k, curve)| curve.layers(Style::nth(k), reach)).collect();
        let axis = |label: &str| Axis { label: label.to_owned(), logarithmic: false, range: None };
        let x = axis("forcing: η imposed, or mean λ measured");
        let y = axis("flux R: measured, or r imposed");
        let panel = Panel { title: String::new(), x, y, layers };
        Figure { title: title.to_owned(), columns: 1, panels: vec![panel] }
    }

    /// How far a line may go: the largest forcing on one side of zero, error bars included, and the largest flux at all.
    fn reach(&self, side: f64) -> (f64, f64) {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let forcings = points().filter(|point| point.forcing.0 * side > 0.0);
        let forcing = forcings.map(|point| point.forcing.0.abs() + point.forcing.1).fold(0.0, f64::max);
        let flux = points().map(|point| point.flux.0.abs() + point.flux.1).fold(0.0, f64::max);
        (1.05 * side * forcing, 1.05 * flux)
    }
}

impl Curve {
    fn layers(&self, style: Style, reach: [(f64, f64); 2]) -> Vec<Layer> {
        let (value, error) = self.coefficient;
        // Points and line share an entry of the legend.
        let label = format!("{}: slope {}", name(self.method), value_with_error(value, error));
        let line = |label: &str, points: Vec<(f64, f64)>, dashed: bool| {
            let label = label.to_owned();
            Layer::Line { label, points, dashed, style }
        };
        let end = |(forcing, flux): (f64, f64)| {
            let x = if (value * forcing).abs() > flux { flux / value.abs() * forcing.signum() } else { forcing };
            (x, value * x)
        };
        let curved = !self.fitted.is_empty();
        let mut layers = vec![line(&label, vec![end(reach[0]), (0.0, 0.0), end(reach[1])], curved)];
        if curved {
            layers.push(line("", self.fitted.clone(), false));
        }
        let point = |of: &Response| Point { x: of.forcing.0, y: of.flux.0, x_error: of.forcing.1, y_error: of.flux.1 };
        if !self.points.is_empty() {
            layers.push(Layer::Points { label, points: self.points.iter().map(point).collect(), style });
        }
        layers
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

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(forcings: &[f64], slope: f64, fitted: Vec<(f64, f64)>) -> Profile {
        let response = |&x: &f64| Response { forcing: (x, 0.0), flux: (slope * x, 0.01) };
        let points = forcings.iter().map(response).collect();
        let curves = vec![
            Curve { method: "nemd", coefficient: (slope, 0.0009), points, fitted },
            Curve { method: "msd", coefficient: (2.0 * slope, 0.002), points: Vec::new(), fitted: Vec::new() },
        ];
        Profile { measurement: "mobility".to_owned(), curves }
    }

    /// Label, points, whether dashed.
    type Line = (String, Vec<(f64, f64)>, bool);

    fn lines(profile: &Profile) -> Vec<Line> {
        let layers = profile.figure("").panels.remove(0).layers;
        let line = |layer| match layer {
            Layer::Line { label, points, dashed, .. } => Some((label, points, dashed)),
            _ => None,
        };
        layers.into_iter().filter_map(line).collect()
    }

    #[test]
    fn slopes_go_through_the_origin_as_far_as_the_points() {
        for slope in [0.0291, -0.0291] {
            let lines = lines(&profile(&[0.5, 1.0], slope, Vec::new()));
            assert_eq!(lines.len(), 2);
            let (label, line, dashed) = &lines[0];
            assert!(label.starts_with("NEMD: slope ") && label.ends_with("0.02910(90)") && !dashed, "{label}");
            assert_eq!(line[1], (0.0, 0.0));
            assert!((line[2].0 - 1.05).abs() < 1e-12 && (line[2].1 - slope * 1.05).abs() < 1e-12, "{line:?}");
            assert_eq!(line[0].0, 0.0, "no point on the negative side");
            // Twice as steep: it ends where the fluxes end.
            let (label, line, _) = &lines[1];
            assert!(label.starts_with("mean squared displacement: slope "), "{label}");
            assert!((line[2].1.abs() - 1.05 * (0.0291 + 0.01)).abs() < 1e-12 && line[2].0 < 1.0, "{line:?}");
        }
    }

    #[test]
    fn negative_forcings_stay_negative() {
        let profile = profile(&[-1.0, 0.5], 0.03, vec![(-1.0, -0.025), (0.5, 0.014)]);
        let lines = lines(&profile);
        assert!((lines[0].1[0].0 + 1.05).abs() < 1e-12 && lines[0].2, "{lines:?}");
        assert!(lines[1].0.is_empty() && lines[1].1[0] == (-1.0, -0.025) && !lines[1].2, "{lines:?}");
        let markers = profile.figure("").svg().matches("<circle").count();
        assert_eq!(markers, 3, "two points and the legend's");
    }
}
