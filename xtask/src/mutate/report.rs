//! What a person reads: the list of mutations, the table of verdicts, the closing line.

use std::time::Duration;

use super::header::Mutation;
use super::trial::Verdict;
use crate::failure::Failure;
use crate::table;

/// One test under one mutation.
#[derive(Debug)]
pub struct Row {
    name: String,
    what: String,
    test: String,
    /// What came of it.
    pub verdict: Verdict,
    time: Duration,
}

impl Row {
    /// The row of one of the mutation's tests.
    pub fn new(mutation: &Mutation, test: &str, verdict: Verdict, time: Duration) -> Self {
        Self {
            name: mutation.name.clone(),
            what: mutation.what.clone(),
            test: full_name(mutation, test),
            verdict,
            time,
        }
    }
}

/// A test's name with its package.
fn full_name(mutation: &Mutation, test: &str) -> String {
    format!("{}::{test}", mutation.package)
}

/// Markdown takes a bar for the end of a cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// What `--list` prints: each mutation with the tests that must notice it.
pub fn list(mutations: &[Mutation]) -> String {
    let rows: Vec<Vec<String>> = mutations
        .iter()
        .flat_map(|mutation| {
            mutation
                .tests
                .iter()
                .map(|test| vec![mutation.name.clone(), cell(&mutation.what), full_name(mutation, test)])
        })
        .collect();
    table::markdown(&["mutation", "what is broken", "test that must turn red"], &rows)
}

/// The verdicts, a line for each test.
pub fn table(rows: &[Row]) -> String {
    let cells = |row: &Row| {
        let seconds = format!("{:.1}", row.time.as_secs_f64());
        vec![row.name.clone(), cell(&row.what), row.test.clone(), row.verdict.to_string(), seconds]
    };
    let rows: Vec<Vec<String>> = rows.iter().map(cells).collect();
    table::markdown(&["mutation", "what is broken", "test", "verdict", "seconds"], &rows)
}

/// Success only when every test turned red under every mutation; otherwise which mutations fell short, and where
/// their output is.
pub fn conclude(rows: &[Row], place: &str) -> Result<(), Failure> {
    let mut short: Vec<&str> =
        rows.iter().filter(|row| row.verdict != Verdict::Red).map(|row| row.name.as_str()).collect();
    short.dedup();
    let mut all: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    all.dedup();
    if short.is_empty() {
        println!("\nAll {} mutations turned their tests red.", all.len());
        return Ok(());
    }
    Err(Failure::task(format!(
        "{} of {} mutations did not turn their tests red: {}\n\
         what each printed: {place}/log/NAME.txt; the tests without mutations: {place}/log/_unmutated.txt\n\
         rerun only these: cargo xtask mutate {}",
        short.len(),
        all.len(),
        short.join(", "),
        short.join(" "),
    )))
}
