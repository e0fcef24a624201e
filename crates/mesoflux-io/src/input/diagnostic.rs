//! How a fault of the input is shown: what, where, a caret under it, and the nearest known name.

use annotate_snippets::{AnnotationKind, Level, Origin, Renderer, Snippet};
use std::ops::Range;

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    /// Where it stands in the text; `None` where something is missing from the whole.
    pub span: Option<Range<usize>>,
    /// Place, value and requirement.
    pub message: String,
    /// What might help.
    pub help: Option<String>,
}

impl Fault {
    /// Shows the fault with the line it stands in.
    pub(super) fn render(&self, name: &str, text: &str) -> String {
        let title = Level::ERROR.primary_title(&self.message);
        let mut group = match &self.span {
            Some(span) => {
                let annotation = AnnotationKind::Primary.span(visible(text, span));
                title.element(Snippet::source(text).path(name).annotation(annotation))
            }
            None => title.element(Origin::path(name)),
        };
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help));
        }
        Renderer::plain().render(&[group])
    }
}

/// What the caret stands under: at least one character, and of a whole table only the first line.
fn visible(text: &str, span: &Range<usize>) -> Range<usize> {
    let start = text.floor_char_boundary(span.start);
    if text[start..].starts_with('\n') {
        return start..start;
    }
    let next = text[start..].chars().next().map_or(start, |character| start + character.len_utf8());
    let end = text.floor_char_boundary(span.end).max(next);
    start..text[start..end].find('\n').map_or(end, |newline| start + newline)
}

/// The most similar of several names, if it is similar at all.
pub(super) fn nearest(unknown: &str, known: &[impl AsRef<str>]) -> Option<String> {
    known
        .iter()
        .map(|name| (strsim::jaro_winkler(unknown, name.as_ref()), name.as_ref()))
        .filter(|(similarity, _)| *similarity > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.to_owned())
}
