//! What the TOML reader finds, in a user's words: place, value, requirement. The reader itself speaks of Rust's types and
//! knows no paths; the span that it gives tells which key or value is meant.

use super::diagnostic::{Fault, nearest};
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// The fault behind a message of the reader.
pub(super) fn explain(text: &str, span: Option<Range<usize>>, message: &str) -> Fault {
    let Ok(document) = DeTable::parse(text) else {
        return syntax(text, span, message);
    };
    let place = span.as_ref().and_then(|span| place(document.get_ref(), span, ""));
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some(path) = place else {
        // What the whole file lacks has no line to show.
        let message = names.first().map_or(message.to_owned(), |name| format!("the table [{name}] is missing"));
        return Fault { span: None, message, help: None };
    };
    let value = span.clone().and_then(|span| text.get(span)).unwrap_or_default();
    let (unknown, known) = names.split_first().unwrap_or((&"", &[]));
    let requirement = requirement(message);
    let (said, help) = match message.split_once(" `").map(|(kind, _)| kind) {
        Some("missing field") => (format!("{path}: {unknown} is missing"), None),
        Some("unknown field") if known.is_empty() => (format!("{path}: unknown key, there are none here"), None),
        Some("unknown field") => (format!("{path}: unknown key, must be {}", one_of(known)), nearest(unknown, known)),
        // The name is a value in quotes, or the key of a law.
        Some("unknown variant") if value.starts_with(['"', '\'']) => {
            (format!("{path} = {value}: must be {}", one_of(known)), nearest(unknown, known))
        }
        Some("unknown variant") => {
            (format!("{path}: unknown name, must be {}", one_of(known)), nearest(unknown, known))
        }
        // A table, or the key of one: nothing that could be shown as its value.
        _ if value.starts_with(['[', '{']) || path.ends_with(value) => (format!("{path}: {requirement}"), None),
        _ => (format!("{path} = {}: {requirement}", first_line(value)), None),
    };
    Fault { span, message: said, help: help.map(|known| format!("did you mean `{known}`?")) }
}

/// A text that is no TOML.
fn syntax(text: &str, span: Option<Range<usize>>, message: &str) -> Fault {
    let found = span.clone().and_then(|span| text.get(span)).unwrap_or_default().trim();
    let message = match message {
        "duplicate key" => format!("{found}: must not be given twice"),
        "string values must be quoted, expected literal string" if found.is_empty() => "a value is missing".to_owned(),
        "string values must be quoted, expected literal string" => format!("{found}: a text must stand in quotes"),
        other => format!("not TOML: {}", other.trim_end_matches(", expected nothing")),
    };
    Fault { span, message, help: None }
}

/// The path of the key or value that stands at a span.
fn place(table: &DeTable, span: &Range<usize>, prefix: &str) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let path = if prefix.is_empty() { key.get_ref().to_string() } else { format!("{prefix}.{}", key.get_ref()) };
        // A key first: of a dotted one, the table that it opens has the same span.
        if key.span() == *span { Some(path) } else { place_in(value, span, path) }
    })
}

fn place_in(value: &toml::Spanned<DeValue>, span: &Range<usize>, path: String) -> Option<String> {
    match value.get_ref() {
        DeValue::Table(inner) => place(inner, span, &path).or_else(|| (value.span() == *span).then_some(path)),
        _ if value.span() == *span => Some(path),
        DeValue::Array(inner) => {
            let mut elements = inner.iter().enumerate();
            elements.find_map(|(index, element)| place_in(element, span, format!("{path}.{index}")))
        }
        _ => None,
    }
}

/// What the reader expected.
fn requirement(message: &str) -> String {
    let expected = message.split_once("expected ").map_or(message, |(_, expected)| expected);
    match expected {
        "f64" => "must be a number".to_owned(),
        "u8" => "must be a whole number from 0 to 255".to_owned(),
        "u64" if message.contains("i128") => format!("must be at most {}", i64::MAX),
        "u64" => "must be a whole number of at least 0".to_owned(),
        "a string" => "must be a text in quotes".to_owned(),
        "a boolean" => "must be true or false".to_owned(),
        "newtype variant" => "must be given with its parameters, as `NAME = { … }`".to_owned(),
        "wanted string or table" => "must be a name in quotes".to_owned(),
        "enum" | "wanted exactly 1 element, found 0 elements" | "wanted exactly 1 element, more than 1 element" => {
            "must name exactly one law".to_owned()
        }
        "a sequence" => "must be an array".to_owned(),
        "a map" => "must be a table".to_owned(),
        other if other.starts_with("struct ") => "must be a table".to_owned(),
        other => format!("must be {other}"),
    }
}

/// Names to choose from.
pub(super) fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [only] => only.clone(),
        several => format!("one of {}", several.join(", ")),
    }
}

fn first_line(value: &str) -> &str {
    value.lines().next().unwrap_or_default()
}
