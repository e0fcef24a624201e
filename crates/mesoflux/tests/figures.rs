//! Figures: every datum drawn once, well-formed SVG whatever the data, the same bytes again.

use mesoflux::figure::{Axis, Figure, Layer, Marker, Panel, Point, Style};

fn axis(label: &str, logarithmic: bool) -> Axis {
    Axis { label: label.to_owned(), logarithmic, range: None }
}

fn figure(layers: Vec<Layer>, logarithmic: bool) -> Figure {
    let panel = Panel { title: String::new(), x: axis("λ", logarithmic), y: axis("U₁", logarithmic), layers };
    Figure { title: String::new(), columns: 1, panels: vec![panel] }
}

fn points(label: &str, style: Style, points: &[(f64, f64, f64, f64)]) -> Layer {
    let point = |&(x, y, x_error, y_error): &(f64, f64, f64, f64)| Point { x, y, x_error, y_error };
    Layer::Points { label: label.to_owned(), points: points.iter().map(point).collect(), style }
}

fn line(label: &str, points: &[(f64, f64)], dashed: bool) -> Layer {
    Layer::Line { label: label.to_owned(), points: points.to_vec(), dashed, style: Style::nth(1) }
}

fn histogram(edges: &[f64], heights: &[f64]) -> Layer {
    Layer::Histogram {
        label: "N = 64".to_owned(),
        edges: edges.to_vec(),
        heights: heights.to_vec(),
        style: Style::nth(2),
    }
}

/// Tags of a kind in a color.
fn tags<'a>(svg: &'a str, tag: &str, color: &str) -> Vec<&'a str> {
    let start = format!("<{tag} ");
    svg.lines().filter(|line| line.starts_with(&start) && line.contains(color)).collect()
}

const BLUE: &str = "\"#0072B2\"";
const VERMILION: &str = "\"#D55E00\"";
const GREEN: &str = "\"#009E73\"";

/// The corners of a path or polygon.
fn corners(tag: &str) -> Vec<(f64, f64)> {
    let list = tag.split("points=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a list of points");
    let pairs = list.split_whitespace().filter_map(|pair| pair.split_once(','));
    let number = |text: &str| text.parse().expect("a number");
    pairs.map(|(x, y)| (number(x), number(y))).collect()
}

/// Every tag closed in order, every value quoted, nothing but numbers where numbers belong.
fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        let text = &rest[..start];
        assert!(!text.contains('>') && text.matches('&').count() <= text.matches(';').count(), "{text}");
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert!(tag.matches('"').count().is_multiple_of(2) && !tag.contains('<'), "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split(' ').next().unwrap_or(tag));
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "open at the end: {open:?}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "no number");
    assert!(!svg.contains(&i32::MAX.to_string()) && !svg.contains(&i32::MIN.to_string()), "out of range");
}

#[test]
fn every_point_has_a_marker_and_its_error_bars() {
    let data = [(1.0, 2.0, 0.0, 0.0), (2.0, 3.0, 0.1, 0.0), (3.0, 5.0, 0.1, 0.2), (4.0, -4.0, 0.0, 0.3)];
    for (marker, tag, open) in [
        (Marker::Circle, "circle", false),
        (Marker::Circle, "circle", true),
        (Marker::Square, "polygon", false),
        (Marker::Triangle, "polygon", false),
        (Marker::Diamond, "polygon", false),
    ] {
        let style = Style { color: 0, marker, open };
        let svg = figure(vec![points("", style, &data)], false).svg();
        assert_well_formed(&svg);
        assert_eq!(tags(&svg, tag, BLUE).len(), 4, "{marker:?}");
        // Of two points each in x and y, each bar one stroke.
        assert_eq!(tags(&svg, "polyline", BLUE).len(), 4, "{marker:?}");
    }
    let cross = Style { color: 0, marker: Marker::Cross, open: false };
    let svg = figure(vec![points("", cross, &data)], false).svg();
    assert_eq!(tags(&svg, "polyline", BLUE).len(), 4 + 2 * 4, "two strokes a cross");
    let open = Style { color: 0, marker: Marker::Square, open: true };
    let svg = figure(vec![points("", open, &data)], false).svg();
    assert_eq!((tags(&svg, "polyline", BLUE).len(), tags(&svg, "polygon", BLUE).len()), (8, 0));
    // A legend adds one.
    let svg = figure(vec![points("measured", Style::nth(0), &data)], false).svg();
    assert_eq!(tags(&svg, "circle", BLUE).len(), 5);
}

#[test]
fn error_bars_span_twice_the_error() {
    // The second point's bars reach the third point across and the first point up.
    let data = [(1.0, 3.0, 0.0, 0.0), (2.0, 2.0, 1.0, 1.0), (3.0, 1.0, 0.0, 0.0)];
    let svg = figure(vec![points("", Style::nth(0), &data)], false).svg();
    let number = |tag: &str, name: &str| -> f64 {
        tag.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let centers: Vec<(f64, f64)> =
        tags(&svg, "circle", BLUE).iter().map(|tag| (number(tag, "cx"), number(tag, "cy"))).collect();
    let bars: Vec<Vec<(f64, f64)>> = tags(&svg, "polyline", BLUE).iter().map(|tag| corners(tag)).collect();
    let ends = |values: Vec<f64>| {
        (values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(0.0, f64::max))
    };
    assert_eq!(ends(bars[0].iter().map(|place| place.0).collect()), (centers[0].0, centers[2].0));
    assert_eq!(ends(bars[1].iter().map(|place| place.1).collect()), (centers[0].1, centers[2].1));
}

#[test]
fn lines_are_one_stroke_and_dashed_lines_many() {
    let data = [(0.0, 0.0), (1.0, 1.0), (2.0, 4.0)];
    let solid = figure(vec![line("", &data, false)], false).svg();
    let strokes = tags(&solid, "polyline", VERMILION);
    assert_eq!((strokes.len(), corners(strokes[0]).len()), (1, 3));
    let dashed = figure(vec![line("", &data, true)], false).svg();
    assert!(tags(&dashed, "polyline", VERMILION).len() > 20);
    // Broken where it has no place: two pieces.
    let broken = [(1.0, 1.0), (2.0, 2.0), (3.0, -1.0), (4.0, 1.0), (5.0, 3.0)];
    let svg = figure(vec![line("", &broken, false)], true).svg();
    assert_eq!(tags(&svg, "polyline", VERMILION).len(), 2);
    [solid, dashed, svg].iter().for_each(|svg| assert_well_formed(svg));
}

#[test]
fn lines_end_where_the_frame_ends() {
    let mut figure = figure(vec![line("", &[(-100.0, -100.0), (100.0, 100.0)], false)], false);
    figure.panels[0].x.range = Some((0.0, 1.0));
    figure.panels[0].y.range = Some((0.0, 2.0));
    let svg = figure.svg();
    let frame = svg.lines().filter(|line| line.starts_with("<polyline")).map(corners).max_by_key(Vec::len).unwrap();
    let (left, bottom) = (frame[0].0, frame[2].1);
    let middle = 0.5 * (frame[0].1 + bottom);
    let stroke = corners(tags(&svg, "polyline", VERMILION)[0]);
    assert_eq!(stroke, [(left, bottom), (frame[1].0, middle)]);
}

#[test]
fn a_histogram_is_one_outline_over_one_area() {
    let svg = figure(vec![histogram(&[0.0, 1.0, 2.0, 4.0], &[1.0, 3.0, 2.0])], false).svg();
    assert_well_formed(&svg);
    let (outlines, areas) = (tags(&svg, "polyline", GREEN), tags(&svg, "polygon", GREEN));
    assert_eq!((outlines.len(), areas.len()), (2, 2), "with the legend's");
    let outline = corners(outlines[0]);
    assert_eq!(outline.len(), 8, "down, three times across with the risers between, down");
    let (base, top) = (outline[0].1, outline.iter().map(|place| place.1).fold(f64::INFINITY, f64::min));
    assert_eq!(outline[7].1, base);
    let rise = |k: usize| (base - outline[k].1) / (base - top);
    assert!((rise(1) - 1.0 / 3.0).abs() < 1e-3 && (rise(6) - 2.0 / 3.0).abs() < 1e-3, "{outline:?}");
    assert!((outline[6].0 - outline[5].0 - 2.0 * (outline[2].0 - outline[1].0)).abs() <= 2.0, "{outline:?}");
}

#[test]
fn logarithmic_axes_leave_out_what_is_not_positive() {
    let data = [
        (1.0, 1.0, 0.0, 0.5),
        (10.0, 0.1, 20.0, 0.2),
        (100.0, -1.0, 0.0, 0.1),
        (-1.0, 1.0, 0.0, 0.1),
        (0.0, 0.0, 1.0, 1.0),
    ];
    let svg = figure(vec![points("", Style::nth(0), &data)], true).svg();
    assert_well_formed(&svg);
    assert_eq!(tags(&svg, "circle", BLUE).len(), 2);
    let bars: Vec<_> = tags(&svg, "polyline", BLUE).iter().map(|tag| corners(tag).len()).collect();
    // Two caps give eight corners, which fall on six places; a bar that goes on beyond the frame has one cap.
    assert_eq!(bars.len(), 3);
    assert!(bars[0] > bars[1] && bars[0] > bars[2], "{bars:?}");
}

#[test]
fn every_text_is_escaped_and_drawn() {
    let mut figure = figure(vec![line("a < b & \"c\"", &[(0.0, 1.0), (1.0, 2.0)], false)], false);
    figure.title = "η > 0".to_owned();
    figure.panels[0].title = "γ".to_owned();
    let svg = figure.svg();
    assert_well_formed(&svg);
    for text in ["a &lt; b &amp; &quot;c&quot;", "η &gt; 0", "γ", "λ", "U₁"] {
        assert_eq!(svg.lines().filter(|line| *line == text).count(), 1, "{text}");
    }
}

#[test]
fn odd_data_give_a_figure() {
    let odd = [0.0, -1.0, 2.5, 1e-300, 1e300, f64::MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 5e-324];
    let mut panels = Vec::new();
    for logarithmic in [false, true] {
        panels.push(Panel { title: String::new(), x: axis("", logarithmic), y: axis("", logarithmic), layers: vec![] });
        for a in odd {
            for b in odd {
                let layers = vec![
                    points("p", Style::nth(0), &[(a, b, b, a), (1.0, a, a, b), (b, 1.0, 0.0, -1.0)]),
                    points("", Style::nth(8), &[]),
                    line("l", &[(a, b), (b, a), (0.5, 2.0), (b, b)], a == b),
                    line("", &[(a, b)], true),
                    histogram(&[a, b, 1.0, 1.0, 3.0], &[a, b, 2.0, 1.0, 0.0, 1.0]),
                    histogram(&[], &[1.0]),
                ];
                for layers in [layers[..1].to_vec(), layers[2..3].to_vec(), layers[4..5].to_vec(), layers] {
                    let range = (a != b).then_some((a, b));
                    let x = Axis { range, ..axis("", logarithmic) };
                    panels.push(Panel { title: String::new(), x, y: axis("y", logarithmic), layers });
                }
            }
        }
    }
    for columns in [0, 3, usize::MAX] {
        let some = panels.iter().skip(columns % 7).step_by(5).cloned().collect();
        assert_well_formed(&Figure { title: String::new(), columns, panels: some }.svg());
    }
    assert_well_formed(&Figure { title: "no panel".to_owned(), columns: 2, panels: Vec::new() }.svg());
}

#[test]
fn the_same_data_give_the_same_bytes() {
    let layers = || {
        vec![
            points("a", Style::nth(0), &[(1.0, 2.0, 0.1, 0.2), (2.0, 0.3, 0.1, 0.2)]),
            line("b", &[(1.0, 2.0), (2.0, 0.3)], true),
        ]
    };
    assert_eq!(figure(layers(), true).svg(), figure(layers(), true).svg());
}

#[test]
fn frames_stand_in_line() {
    let panel = |scale: f64| {
        let layers = vec![line("", &[(0.0, 0.0), (1.0, scale)], false)];
        Panel { title: "t".to_owned(), x: axis("x", false), y: axis("y", false), layers }
    };
    let figure = Figure { title: String::new(), columns: 2, panels: [1.0, 3e-7, 12_345.0].map(panel).to_vec() };
    let svg = figure.svg();
    let strokes = svg.lines().filter(|line| line.starts_with("<polyline")).map(corners);
    let frames: Vec<_> = strokes.filter(|corners| corners.len() == 6).collect();
    assert_eq!(frames.len(), 3);
    assert_eq!(frames[0][0].0, frames[2][0].0, "left ends of a column");
    assert_eq!(frames[0][0].1, frames[1][0].1, "upper ends of a row");
    assert!(frames[1][0].0 > frames[0][1].0 && frames[2][0].1 > frames[0][2].1, "none over another");
}
