//! The figure of an item: the panels that `study.toml` describes, drawn from the item's series.

use super::claim::Data;
use super::definition::{AxisInput, ItemInput, LayerInput, PanelInput};
use super::series::Series;
use crate::figure::{Axis, Figure, Layer, Panel, Point, Style};
use crate::report::value_with_error;

/// The figure of an item; none for one without panels.
pub fn figure(item: &ItemInput, data: &Data) -> Option<Figure> {
    let panels: Vec<Panel> = item.panel.iter().map(|(_, input)| panel(input, item, data)).collect();
    (!panels.is_empty()).then(|| Figure { title: item.title.clone(), columns: item.columns, panels })
}

fn panel(input: &PanelInput, item: &ItemInput, data: &Data) -> Panel {
    let series = |layer: &LayerInput| data.get(layer.series()).cloned().unwrap_or_default();
    // Where lines that are no data begin and end: with the points of the panel.
    let points = input.layer.iter().filter(|(_, layer)| layer.is_data()).flat_map(|(_, layer)| series(layer).points);
    let x: Vec<f64> = points.map(|point| point.x).collect();
    let lowest = x.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let ends = (if input.x.logarithmic { lowest } else { lowest.min(0.0) }, highest);
    let layers = input.layer.iter().filter_map(|(_, layer)| {
        let style = Style::nth(item.place_of(layer.label()));
        drawn(layer, &series(layer), ends, style)
    });
    Panel { title: input.title.clone(), x: axis(&input.x), y: axis(&input.y), layers: layers.collect() }
}

fn axis(input: &AxisInput) -> Axis {
    Axis {
        label: input.label.clone(),
        logarithmic: input.logarithmic,
        range: input.range.map(|range| (range.low, range.high)),
    }
}

/// Values of x at which a power law is drawn: straight on logarithmic axes, smooth on others.
const STEPS: usize = 64;

/// What is drawn of a layer, if the series has enough for it.
fn drawn(layer: &LayerInput, series: &Series, ends: (f64, f64), style: Style) -> Option<Layer> {
    let joined = |label: &str, points: Vec<(f64, f64)>, dashed: bool| {
        let label = label.to_owned();
        (points.len() > 1).then_some(Layer::Line { label, points, dashed, style })
    };
    match layer {
        LayerInput::Points { label, .. } => {
            let point = |p: &super::series::Point| Point { x: p.x, y: p.y, x_error: p.x_error, y_error: p.y_error };
            let points = series.points.iter().map(point).collect();
            Some(Layer::Points { label: label.clone(), points, style })
        }
        LayerInput::Line { label, dashed, .. } => {
            joined(label, series.points.iter().map(|point| (point.x, point.y)).collect(), *dashed)
        }
        LayerInput::Histogram { label, .. } => {
            let edges = edges(series)?;
            let heights = series.points.iter().map(|point| point.y).collect();
            Some(Layer::Histogram { label: label.clone(), edges, heights, style })
        }
        LayerInput::Slope { label, .. } => {
            let [slope] = series.points[..] else { return None };
            let label = format!("{label}: slope {}", value_with_error(slope.y, slope.y_error));
            joined(&label, vec![(ends.0, slope.y * ends.0), (ends.1, slope.y * ends.1)], true)
        }
        LayerInput::PowerLaw { exponent, at, label, .. } => {
            let distance = |point: &&super::series::Point| (point.x - at).abs();
            let through = series.points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            // On linear axes, where x may begin at zero, the law is drawn over the points' own range.
            let lowest = if ends.0 > 0.0 { ends.0 } else { series.points.first()?.x };
            let x = |k: usize| lowest * (ends.1 / lowest).powf(k as f64 / STEPS as f64);
            let law = |x: f64| (x, through.y * (x / through.x).powf(*exponent));
            joined(label, (0..=STEPS).map(|k| law(x(k))).collect(), true)
        }
    }
}

/// The ends of bins whose centers are the points of a series: halfway between neighbors.
fn edges(series: &Series) -> Option<Vec<f64>> {
    let x: Vec<f64> = series.points.iter().map(|point| point.x).collect();
    let (&first, &last) = (x.first()?, x.last()?);
    let (second, before) = (*x.get(1)?, *x.get(x.len() - 2)?);
    let mut edges = vec![1.5 * first - 0.5 * second];
    edges.extend(x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
    edges.push(1.5 * last - 0.5 * before);
    Some(edges)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::series::Point as DataPoint;

    #[test]
    fn lines_go_where_they_say() {
        let text = r#"
            title = "An item"
            [series]
            data.table = { input = "a", of = "a.csv" }
            slope.estimates = { input = "a", of = "b/c" }
            [panel.only]
            x = { label = "x" }
            y = { label = "y" }
            [panel.only.layer]
            mean.slope = { series = "slope", label = "mean" }
            law.power_law = { exponent = -2.0, series = "data", at = 4.0, label = "x⁻²" }
            data.points = { series = "data", label = "data" }
        "#;
        let item: ItemInput = toml::from_str(text).unwrap();
        let point = |x: f64, y: f64| DataPoint { x, y, x_error: 0.0, y_error: 0.1 };
        let data = Data::from([
            ("data".to_owned(), Series::new(vec![point(2.0, 5.0), point(4.0, 3.0)], Vec::new())),
            ("slope".to_owned(), Series::new(vec![point(1.0, 0.5)], Vec::new())),
        ]);
        let panel = &figure(&item, &data).unwrap().panels[0];
        let Layer::Line { label, points, .. } = &panel.layers[0] else { panic!("no slope") };
        assert_eq!((label.as_str(), points.as_slice()), ("mean: slope 0.50(10)", &[(0.0, 0.0), (4.0, 2.0)][..]));
        let Layer::Line { points, .. } = &panel.layers[1] else { panic!("no law") };
        let (first, last) = (points[0], points[points.len() - 1]);
        assert!((first.0 - 2.0).abs() < 1e-12 && (first.1 - 12.0).abs() < 1e-12, "{first:?}");
        assert!((last.0 - 4.0).abs() < 1e-12 && (last.1 - 3.0).abs() < 1e-12, "{last:?}");
        assert!(matches!(&panel.layers[2], Layer::Points { points, .. } if points.len() == 2));
    }

    #[test]
    fn bins_end_halfway_between_their_centers() {
        let points = [1.0, 2.0, 4.0].map(|x| DataPoint { x, y: 1.0, ..DataPoint::default() });
        assert_eq!(edges(&Series::new(points.to_vec(), Vec::new())), Some(vec![0.5, 1.5, 3.0, 5.0]));
    }
}
