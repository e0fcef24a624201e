//! How a fault of the input is shown: what, where, a caret under it, and the nearest known name.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::ops::Range;

/// Renders a fault with the line it stands in.
pub(super) fn render(name: &str, text: &str, span: Option<Range<usize>>, message: &str, help: Option<&str>) -> String {
    let title = Level::ERROR.primary_title(message);
    let mut group = match span {
        // The caret needs at least one character to stand under.
        Some(span) => {
            let end = span.end.max(span.start + 1).min(text.len().max(span.start));
            // Of a whole table only the first line is shown.
            let first_line = text[span.start..end].find('\n').map_or(end, |newline| span.start + newline.max(1));
            let annotation = AnnotationKind::Primary.span(span.start..first_line);
            title.element(Snippet::source(text).path(name).annotation(annotation))
        }
        None => annotate_snippets::Group::with_title(title),
    };
    if let Some(help) = help {
        group = group.element(Level::HELP.message(help));
    }
    Renderer::plain().render(&[group])
}

/// The known name nearest to the unknown one in a message such as "unknown field `x`, expected one of `a`, `b`".
pub(super) fn nearest_known(message: &str) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut names = message.split('`').skip(1).step_by(2);
    let unknown = names.next()?;
    nearest(unknown, names)
}

/// The most similar of several names, if it is similar at all.
pub(super) fn nearest<'a>(unknown: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    known
        .map(|name| (strsim::jaro_winkler(unknown, name), name))
        .filter(|(similarity, _)| *similarity > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.to_owned())
}
