//! The table of a study's claims with their verdicts: for the terminal, and as a page beside the data.

use super::Study;
use super::verdict::{Judged, Side};
use crate::report::{columns, value_with_error};
use std::collections::BTreeSet;

/// The verdicts as columns.
pub fn table(judged: &[Judged]) -> String {
    let header = ["item", "measured (error)", "expected", "z", "verdict", "claim"].map(str::to_owned);
    let mut rows = vec![header.to_vec()];
    rows.extend(judged.iter().map(|entry| {
        vec![
            entry.item.clone(),
            measured(entry),
            expected(entry),
            entry.z.map_or_else(String::new, |z| format!("{z:.2}")),
            entry.verdict.to_string(),
            entry.claim.clone(),
        ]
    }));
    columns(&rows)
}

fn measured(entry: &Judged) -> String {
    match (entry.measured, entry.standard_error) {
        (Some(value), Some(error)) => value_with_error(value, error),
        _ => "cannot tell".to_owned(),
    }
}

fn expected(entry: &Judged) -> String {
    let number = rounded(entry.expected);
    match entry.side {
        None => number,
        Some(Side::Above) => format!("> {number}"),
        Some(Side::Below) => format!("< {number}"),
    }
}

/// A number to four digits, without zeros at its end.
fn rounded(number: f64) -> String {
    let exact: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    format!("{exact}")
}

/// The page `README.md` of a study's directory. `command` made it; `drawn` are the items with a figure.
pub fn page(study: &Study, judged: &[Judged], command: &str, drawn: &[String]) -> String {
    let mut text = format!("# {}\n\n{}\n\n", study.definition.title, study.definition.source);
    text += &format!("Made by `{command}` (mesoflux {}). ", env!("CARGO_PKG_VERSION"));
    text += "Every number comes from the runs in `points/`, each the directory of an ordinary run with its input; \
             the data of the figures are in a directory for each item.\n\n\
             A claim *holds* if the measured number lies within 2.5 standard errors of the expected one (z is that distance) and its \
             standard error is no larger than required; it *fails* if |z| > 2.5. Otherwise these runs cannot tell. \
             Where a bound is expected, z is the distance beyond it, and the required error at most the distance from it over 2.5.\n";
    for (name, item) in &study.definition.item {
        let own: Vec<&Judged> = judged.iter().filter(|entry| entry.item == *name).collect();
        text += &format!("\n## {name}: {}\n\n", item.title);
        if drawn.contains(name) {
            text += &format!("![{}]({name}.svg)\n\n", item.title);
        }
        if own.is_empty() {
            text += "Not run yet, or nothing is claimed.\n";
            continue;
        }
        text += "| claim | expected | measured (error) | required error | z | verdict |\n| --- | --- | --- | --- | --- | --- |\n";
        for entry in &own {
            let z = entry.z.map_or_else(String::new, |z| format!("{z:.2}"));
            text += &format!(
                "| {} | {} | {} | {} | {z} | {} |\n",
                entry.claim,
                expected(entry),
                measured(entry),
                rounded(entry.required_error),
                entry.verdict
            );
        }
        let notes = own.iter().filter_map(|entry| Some((&entry.claim, entry.note.as_ref()?)));
        let notes: String = notes.map(|(claim, note)| format!("- {claim}: {note}.\n")).collect();
        if !notes.is_empty() {
            text += &format!("\n{notes}");
        }
        let warnings = alike(own.iter().flat_map(|entry| &entry.warnings));
        if !warnings.is_empty() {
            text += "\nThe runs warn:\n\n";
            text += &warnings.iter().map(|warning| format!("- {warning}.\n")).collect::<String>();
        }
    }
    text
}

/// Texts that differ in their numbers only, each kind once, with how many more there are.
pub fn alike<'a>(texts: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut kinds: Vec<(String, BTreeSet<&str>)> = Vec::new();
    for text in texts {
        let kind = text.replace(|letter: char| letter.is_ascii_digit() || ".,-".contains(letter), "");
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, members)) => _ = members.insert(text),
            None => kinds.push((kind, BTreeSet::from([text.as_str()]))),
        }
    }
    let line = |(_, members): (String, BTreeSet<&str>)| match (members.first(), members.len()) {
        (Some(first), 1) => (*first).to_owned(),
        (first, number) => format!("{} (and {} like it)", first.unwrap_or(&""), number - 1),
    };
    kinds.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_that_differ_in_numbers_are_told_once() {
        let texts = ["nemd at 2: 3.5 times", "nemd at 10: 12 times", "nemd at 2: hot", "nemd at 2: 3.5 times"];
        let texts = texts.map(str::to_owned);
        assert_eq!(alike(texts.iter()), ["nemd at 10: 12 times (and 1 like it)", "nemd at 2: hot"]);
    }
}
