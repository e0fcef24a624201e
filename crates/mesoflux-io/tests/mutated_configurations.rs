//! A thousand mutations of the good configurations of each format: none makes a reader panic or hang, and each is either a
//! consistent configuration or a message with its line.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;
mod configuration;

use common::Random;
use configuration::{assert_consistent, files, format_of, parse};
use mesoflux_io::configuration::Format;
use std::time::{Duration, Instant};

const MUTATIONS: usize = 1000;

/// Words that configurations don't expect.
const STRANGE: [&str; 20] = [
    "0",
    "-1",
    "1",
    "2",
    "0.5",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e308",
    "-1e-320",
    "99999999999999999999",
    "18446744073709551615",
    "9223372036854775807",
    "4294967295",
    "4294967296",
    "Atoms",
    "#",
    "\"",
    "é",
];

/// Flips a bit of one byte.
fn flip(text: &mut [u8], random: &mut Random) {
    let place = random.below(text.len());
    text[place] ^= 1 << random.below(8);
}

/// Deletes up to four bytes.
fn delete(text: &mut Vec<u8>, random: &mut Random) {
    let place = random.below(text.len());
    text.drain(place..(place + 1 + random.below(4)).min(text.len()));
}

/// Deletes, doubles or moves a line.
fn shuffle(text: &mut Vec<u8>, random: &mut Random) {
    let mut lines: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let line = lines.remove(random.below(lines.len()));
    for _ in 0..random.below(3) {
        lines.insert(random.below(lines.len() + 1), line.clone());
    }
    *text = lines.join(&b'\n');
}

/// Where the words are.
fn words(text: &[u8]) -> Vec<(usize, usize)> {
    let separates = |byte: &u8| byte.is_ascii_whitespace() || b"\"=:".contains(byte);
    let mut words = Vec::new();
    let mut start = 0;
    for word in text.split(separates) {
        if !word.is_empty() {
            words.push((start, start + word.len()));
        }
        start += word.len() + 1;
    }
    words
}

/// Replaces a word.
fn replace(text: &mut Vec<u8>, random: &mut Random) {
    let words = words(text);
    if !words.is_empty() {
        let (start, end) = words[random.below(words.len())];
        text.splice(start..end, STRANGE[random.below(STRANGE.len())].bytes());
    }
}

/// Exchanges two words.
fn swap(text: &mut Vec<u8>, random: &mut Random) {
    let words = words(text);
    if words.len() >= 2 {
        let first = random.below(words.len() - 1);
        // Half of the time neighbors.
        let second = if random.below(2) == 0 { first + 1 } else { first + 1 + random.below(words.len() - first - 1) };
        let ((start, end), (next, last)) = (words[first], words[second]);
        let exchanged = [&text[next..last], &text[end..next], &text[start..end]].concat();
        text.splice(start..last, exchanged);
    }
}

/// Cuts the end off.
fn cut(text: &mut Vec<u8>, random: &mut Random) {
    text.truncate(random.below(text.len()));
}

/// Reads a mutation; whether it is accepted.
fn is_accepted(format: Format, text: &[u8]) -> bool {
    let shown = || String::from_utf8_lossy(text).into_owned();
    let start = Instant::now();
    let outcome = std::panic::catch_unwind(|| parse(format, "mutated", text));
    assert!(start.elapsed() < Duration::from_secs(1), "the reader takes {:?} for\n{}", start.elapsed(), shown());
    match outcome.unwrap_or_else(|_| panic!("the reader panics at\n{}", shown())) {
        Ok(configuration) => {
            let consistent = std::panic::catch_unwind(|| assert_consistent(&configuration));
            assert!(consistent.is_ok(), "{configuration:?} is inconsistent, for\n{}", shown());
            true
        }
        Err(error) => {
            let message = error.to_string();
            let reason = message.strip_prefix("mutated: line ").and_then(|rest| rest.split_once(": "));
            let (line, reason) = reason.unwrap_or_else(|| panic!("{message:?} names no line"));
            let lines = text.split(|byte| *byte == b'\n').count() as u64;
            let line: u64 = line.parse().unwrap();
            assert!((1..=lines).contains(&line), "{message:?} for {lines} lines:\n{}", shown());
            assert!(reason.contains("must ") && !message.contains('\n') && message.len() < 500, "{message:?}");
            false
        }
    }
}

fn mutate(format: Format, seed: u64) {
    let paths = files("good").into_iter().filter(|path| format_of(path) == format);
    let texts: Vec<Vec<u8>> = paths.map(|path| std::fs::read(path).unwrap()).collect();
    let mut random = Random(seed);
    let mut accepted = 0;
    for number in 0..MUTATIONS {
        let mut text = texts[number % texts.len()].clone();
        for _ in 0..=random.below(2) {
            if text.is_empty() {
                break;
            }
            match random.below(12) {
                0..3 => flip(&mut text, &mut random),
                3 => delete(&mut text, &mut random),
                4 | 5 => shuffle(&mut text, &mut random),
                6..9 => replace(&mut text, &mut random),
                9 | 10 => swap(&mut text, &mut random),
                _ => cut(&mut text, &mut random),
            }
        }
        accepted += usize::from(is_accepted(format, &text));
    }
    // Both ends of the road are walked.
    assert!((50..950).contains(&accepted), "{accepted} of {MUTATIONS} mutations are accepted");
}

#[test]
fn mutated_extended_xyz_is_read_or_refused_with_a_message() {
    mutate(Format::ExtendedXyz, 1);
}

#[test]
fn mutated_lammps_data_is_read_or_refused_with_a_message() {
    mutate(Format::LammpsData, 2);
}

#[test]
fn every_beginning_of_a_good_configuration_is_read_or_refused_with_a_message() {
    for path in files("good") {
        let text = std::fs::read(&path).unwrap();
        for length in 0..text.len() {
            is_accepted(format_of(&path), &text[..length]);
        }
    }
}
