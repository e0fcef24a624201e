//! The sheet that a figure is drawn on: lines, areas and text at tenths of a pixel, as SVG.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A place on the sheet in pixels, y downward.
pub(super) type Place = (f64, f64);

/// The backend takes whole numbers; lines stay smooth because its unit is a tenth of a pixel.
const UNITS: f64 = 10.0;
/// The backend gives text in units smaller than asked for by this.
const TEXT_SCALE: f64 = 1.24;

pub(super) const INK: RGBColor = RGBColor(38, 38, 38);

/// Where text lies to its place; vertically it is always centered.
#[derive(Debug, Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
    /// Centered, reading upward.
    Upward,
}

pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
    /// What all places count from.
    pub origin: Place,
}

// Drawing into a string meets no outside world that could fail, so that the backend's answers say nothing.
impl Canvas<'_> {
    /// A white sheet of a width and height, drawn upon, as SVG.
    pub fn sheet(width: f64, height: f64, draw: impl FnOnce(&mut Canvas)) -> String {
        let (width, height) = (width.ceil(), height.ceil());
        let (wide, high) = ((width * UNITS) as u32, (height * UNITS) as u32);
        let mut svg = String::new();
        let mut canvas = Canvas { backend: SVGBackend::with_string(&mut svg, (wide, high)), origin: (0.0, 0.0) };
        canvas.area(&[(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)], WHITE.to_rgba());
        draw(&mut canvas);
        let _ = canvas.backend.present();
        drop(canvas);
        // The sheet's own size is in pixels, what lies on it in units of the view box.
        svg.replacen(
            &format!("width=\"{wide}\" height=\"{high}\""),
            &format!("width=\"{width}\" height=\"{height}\""),
            1,
        )
    }

    fn units(&self, place: Place) -> (i32, i32) {
        let unit = |offset: f64, x: f64| ((offset + x) * UNITS).round() as i32;
        (unit(self.origin.0, place.0), unit(self.origin.1, place.1))
    }

    fn all_units(&self, places: &[Place]) -> Vec<(i32, i32)> {
        let mut places: Vec<_> = places.iter().map(|&place| self.units(place)).collect();
        places.dedup();
        places
    }

    pub fn line(&mut self, places: &[Place], width: f64, color: RGBAColor) {
        let path = self.all_units(places);
        let _ = self.backend.draw_path(path, &color.stroke_width((width * UNITS) as u32));
    }

    pub fn area(&mut self, places: &[Place], color: RGBAColor) {
        let outline = self.all_units(places);
        let _ = self.backend.fill_polygon(outline, &color);
    }

    /// A disk, and with a width only its rim.
    pub fn circle(&mut self, center: Place, radius: f64, rim: Option<f64>, color: RGBAColor) {
        let style = color.stroke_width((rim.unwrap_or(0.0) * UNITS) as u32);
        let center = self.units(center);
        let _ = self.backend.draw_circle(center, (radius * UNITS) as u32, &style, rim.is_none());
    }

    pub fn text(&mut self, text: &str, place: Place, size: f64, anchor: Anchor) {
        if text.is_empty() {
            return;
        }
        let (horizontal, turned) = match anchor {
            Anchor::Start => (HPos::Left, FontTransform::None),
            Anchor::Middle => (HPos::Center, FontTransform::None),
            Anchor::End => (HPos::Right, FontTransform::None),
            Anchor::Upward => (HPos::Center, FontTransform::Rotate270),
        };
        let font = ("sans-serif", size * UNITS * TEXT_SCALE).into_font().transform(turned).color(&INK);
        let place = self.units(place);
        let _ = self.backend.draw_text(text, &font.pos(Pos::new(horizontal, VPos::Center)), place);
    }
}

/// The width of text in pixels, rather too large than too small: which sans-serif font will draw it is not known.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let of_letter = |letter: char| match letter {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' | 'I' | ' ' => 0.34,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' => 0.43,
        '⁰'..='⁹' | '⁺' | '⁻' | '₀'..='₉' | '¹' | '²' | '³' => 0.42,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.98,
        '+' | '−' | '=' | '×' | '±' | '<' | '>' | '~' | '≈' => 0.84,
        '0'..='9' => 0.64,
        _ if letter.is_uppercase() => 0.73,
        _ => 0.62,
    };
    text.chars().map(of_letter).sum::<f64>() * size
}

/// The largest size up to a usual one at which text is no wider than a room, but one that can be read.
pub(super) fn fitting_size(text: &str, usual: f64, room: f64) -> f64 {
    (usual * room / text_width(text, usual).max(1.0)).clamp(0.6 * usual, usual)
}
