//! What is said of momentum exchange beside the viscosity: conditions, warnings, the tables of strengths and profiles, the flow curve.

use super::point::Point;
use super::recorder::Reader;
use crate::figure::{Axis, Figure, Layer, Panel, Point as Mark, Style};
use crate::route::{Outcome, cell, cells};
use mesoflux_analysis::Estimate;
use mesoflux_io::input::Input;
use mesoflux_io::results::Table;

/// Standard errors beyond which the energy is not balanced.
const ERRORS: f64 = 3.5;
/// The share of the work that integrators may lose without a word.
const LOST: f64 = 0.01;

/// Adds everything to an outcome.
pub(super) fn complete(outcome: &mut Outcome, input: &Input, reader: &Reader, points: &[Point]) {
    let several = points.len() > 1;
    for point in points {
        let at = match (several, point.stress.value) {
            (true, Some(stress)) => format!("at the stress {stress:.5}: "),
            _ => String::new(),
        };
        let mut warnings = point.warnings.clone();
        // A fit of several points knows nothing of theirs.
        warnings.extend(point.viscosity.warnings.iter().filter(|_| several).cloned());
        warnings.extend(unbalanced(point));
        outcome.estimate.warnings.extend(warnings.into_iter().map(|warning| format!("{at}{warning}")));
    }
    let mut condition = |name: &str, value: Option<f64>| {
        if let Some(value) = value.filter(|value| value.is_finite()) {
            outcome.conditions.insert(name.to_owned(), value.into());
        }
    };
    if let [point] = points {
        for (name, estimate) in [
            ("momentum", &point.momentum),
            ("stress", &point.stress),
            ("velocity_gradient", &point.gradient),
            ("dynamic_temperature", &point.temperature),
            ("density", &point.density),
            ("cubic_share", &point.curvature),
            ("work_rate", &point.work),
            ("heat_rate", &point.heat),
        ] {
            condition(name, estimate.value);
            condition(&format!("{name}_standard_error"), estimate.standard_error.filter(|error| *error > 0.0));
        }
        condition("flow_relaxation_time", point.relaxation);
    }
    let longest = points.iter().map(|point| point.discarded).fold(0.0, f64::max);
    condition("time_to_steady_state", Some(input.run.equilibration_time + longest));
    let worst = points.iter().filter_map(imbalance).fold(0.0f64, |worst, (share, _)| worst.max(share.abs()));
    condition("energy_imbalance", points.iter().any(|point| imbalance(point).is_some()).then_some(worst));
    outcome.tables.push(("", strengths(input, points)));
    outcome.tables.push(("profile", profiles(reader, points)));
    outcome.figures.push(("", flow_curve(points)));
}

/// What is missing of the work, as a share of it, and its z-score.
fn imbalance(point: &Point) -> Option<(f64, f64)> {
    let work = point.work.value?.abs();
    let share = Some(point.missing.value? / work).filter(|share| share.is_finite())?;
    Some((share, point.missing.z_score_against(0.0, 0.0).unwrap_or(0.0)))
}

/// A warning where work is neither given to the thermostat nor kept.
fn unbalanced(point: &Point) -> Option<String> {
    let (share, z) = imbalance(point).filter(|(share, z)| share.abs() > LOST && z.abs() > ERRORS)?;
    let percent = 100.0 * share;
    Some(format!(
        "{percent:.1} % of the work is neither heat nor energy of the fluid, z = {z:.1}: the time step is too long"
    ))
}

/// One row for every strength.
fn strengths(input: &Input, points: &[Point]) -> Table {
    let row = |point: &Point| {
        let mut row = vec![cell(point.momentum.value), point.interval as f64];
        let estimates = [
            &point.stress,
            &point.gradient,
            &point.viscosity,
            &point.temperature,
            &point.density,
            &point.curvature,
            &point.work,
            &point.heat,
            &point.missing,
        ];
        row.extend(estimates.into_iter().flat_map(|estimate: &Estimate| cells(estimate)));
        row.push(input.run.equilibration_time + point.discarded);
        row
    };
    let mut header = vec!["momentum [f t]".to_owned(), "interval [steps]".to_owned()];
    for (name, unit) in [
        ("stress", "e/l^3"),
        ("velocity_gradient", "1/t"),
        ("viscosity", "e t/l^3"),
        ("dynamic_temperature", "e"),
        ("density", "1/l^3"),
        ("cubic_share", "1"),
        ("work_rate", "e/t"),
        ("heat_rate", "e/t"),
        ("missing_rate", "e/t"),
    ] {
        header.extend([format!("{name} [{unit}]"), format!("standard_error [{unit}]")]);
    }
    header.push("time_to_steady_state [t]".to_owned());
    Table::new(header, points.iter().map(row).collect())
}

/// Density, velocity, temperatures and local gradient across the box at every strength.
fn profiles(reader: &Reader, points: &[Point]) -> Table {
    let axis = ["x", "y", "z"][reader.slabs.gradient as usize];
    let width = reader.side / reader.bins as f64;
    let rows = points.iter().flat_map(|point| {
        let row = move |(bin, numbers): (usize, &Vec<f64>)| {
            let mut row = vec![cell(point.stress.value), (bin as f64 + 0.5) * width];
            row.extend(numbers);
            row
        };
        point.profile.iter().enumerate().map(row)
    });
    let mut header = vec![
        "stress [e/l^3]".to_owned(),
        format!("{axis} [l]"),
        "density [1/l^3]".to_owned(),
        "standard_error [1/l^3]".to_owned(),
        "velocity [v]".to_owned(),
        "standard_error [v]".to_owned(),
        "dynamic_temperature [e]".to_owned(),
        "standard_error [e]".to_owned(),
        "effective_temperature [e]".to_owned(),
        "standard_error [e]".to_owned(),
    ];
    if reader.strain_rate.is_some() {
        header.extend(["local_gradient [1/t]", "standard_error [1/t]"].map(str::to_owned));
    }
    Table::new(header, rows.collect())
}

/// The viscosity against the gradient.
fn flow_curve(points: &[Point]) -> Figure {
    let mark = |point: &Point| {
        let ([x, x_error], [y, y_error]) = (cells(&point.gradient), cells(&point.viscosity));
        (x.is_finite() && y.is_finite()).then_some(Mark { x, y, x_error, y_error })
    };
    let marks = points.iter().filter_map(mark).collect();
    let axis = |label: &str| Axis { label: label.to_owned(), logarithmic: false, range: None };
    let layers = vec![Layer::Points { label: "momentum exchange".to_owned(), points: marks, style: Style::nth(0) }];
    let panel = Panel { title: String::new(), x: axis("velocity gradient"), y: axis("shear viscosity"), layers };
    Figure { title: String::new(), columns: 1, panels: vec![panel] }
}
