//! What the readers of configurations share: lines with their numbers, and words that must be numbers.

use super::ConfigurationError;
use mesoflux_core::vector::Vector;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Particles are numbered by 32 bits.
pub(super) const MOST_PARTICLES: u64 = u32::MAX as u64;
/// Species are numbered by 8 bits; kinds of bonds are held to the same.
pub(super) const MOST_KINDS: u64 = 255;
/// A message shows so many characters of a word or a line.
const LONGEST_SHOWN: usize = 60;

/// The lines of a text, without the white space around them, and the number of the one that was read last.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    name: &'a str,
    rest: &'a str,
    number: u64,
}

impl<'a> Lines<'a> {
    /// The lines of `text`; messages call it `name`.
    pub(super) fn new(name: &'a str, text: &'a [u8]) -> Result<Self, ConfigurationError> {
        // Windows programs begin a text with a byte order mark.
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        let before = match std::str::from_utf8(text) {
            Ok(rest) => return Ok(Self { name, rest, number: 0 }),
            Err(error) => &text[..error.valid_up_to()],
        };
        let mut lines = before.split(|byte| *byte == b'\n');
        let byte = 1 + lines.next_back().map_or(0, <[u8]>::len);
        let reason = format!("byte {byte} of the line = {:#04x}: must be part of UTF-8 text", text[before.len()]);
        Err(Self { name, rest: "", number: 1 + lines.count() as u64 }.wrong(reason))
    }

    /// The number of the line that was read last, from 1.
    pub(super) fn number(&self) -> u64 {
        self.number.max(1)
    }

    /// Something wrong in the line that was read last.
    pub(super) fn wrong(&self, reason: impl Into<String>) -> ConfigurationError {
        ConfigurationError::Wrong { path: self.name.to_owned(), line: self.number(), reason: reason.into() }
    }

    /// How many items to make room for, of the `promised` ones, where each takes at least `shortest` bytes of text.
    ///
    /// A promise alone must not take memory.
    pub(super) fn room(&self, promised: u64, shortest: usize) -> usize {
        promised.min((self.rest.len() / shortest) as u64 + 1) as usize
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.number += 1;
        Some(line.trim_ascii())
    }
}

/// A word or a line as a message shows it.
pub(super) fn shown(text: &str) -> String {
    let mut shown = String::new();
    for character in text.chars().take(LONGEST_SHOWN) {
        match character {
            '"' | '\'' | '\\' => shown.push(character),
            _ => shown.extend(character.escape_debug()),
        }
    }
    if text.chars().nth(LONGEST_SHOWN).is_some() {
        shown.push('…');
    }
    shown
}

/// The finite number that a word says.
pub(super) fn number(what: impl Display, word: &str) -> Result<f64, String> {
    let requirement = match word.parse::<f64>() {
        Ok(value) if value.is_finite() => return Ok(value),
        Ok(_) if word.bytes().any(|byte| byte.is_ascii_digit()) => "must be finite: at most 1.8e308 in size",
        Ok(_) => "must be finite",
        Err(_) => "must be a number",
    };
    Err(format!("{what} = {}: {requirement}", shown(word)))
}

/// The positive finite number that a word says.
pub(super) fn positive(what: impl Display, word: &str) -> Result<f64, String> {
    match number(&what, word)? {
        value if value > 0.0 => Ok(value),
        _ => Err(format!("{what} = {}: must be positive", shown(word))),
    }
}

/// The whole number in a range that a word says.
pub(super) fn integer(what: impl Display, word: &str, range: RangeInclusive<u64>) -> Result<u64, String> {
    match word.parse() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => {
            let (low, high) = range.into_inner();
            let requirement =
                if low == high { format!("{low}") } else { format!("a whole number from {low} to {high}") };
            Err(format!("{what} = {}: must be {requirement}", shown(word)))
        }
    }
}

/// The vector that three words say, called after `names`.
pub(super) fn vector(names: [&str; 3], words: &[&str]) -> Result<Vector, String> {
    let mut vector = [0.0; 3];
    for ((component, name), word) in vector.iter_mut().zip(names).zip(words) {
        *component = number(name, word)?;
    }
    Ok(vector)
}

/// The position that three words say, relative to the lower corner of the box.
pub(super) fn position(words: &[&str], corner: Vector) -> Result<Vector, String> {
    let names = ["x", "y", "z"];
    let mut position = vector(names, words)?;
    for axis in 0..3 {
        position[axis] -= corner[axis];
        if !position[axis].is_finite() {
            let (name, word) = (names[axis], shown(words[axis]));
            let corner = corner[axis];
            return Err(format!("{name} = {word}: must be at a finite distance from the box's corner at {corner:?}"));
        }
    }
    Ok(position)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_no_ends_of_any_kind_and_are_counted() {
        let mut lines = Lines::new("file", b"\xEF\xBB\xBFa b \r\n\r\n\tc\n").unwrap();
        assert_eq!((lines.next(), lines.next(), lines.next(), lines.number()), (Some("a b"), Some(""), Some("c"), 3));
        assert_eq!((lines.next(), lines.number()), (None, 3));
        assert_eq!(Lines::new("file", b"").unwrap().wrong("why").to_string(), "file: line 1: why");
    }

    #[test]
    fn what_a_message_shows_is_short_and_on_one_line() {
        assert_eq!(shown("a\tb\0\u{1b}\"é"), "a\\tb\\0\\u{1b}\"é");
        assert_eq!(shown(&"é".repeat(1000)), "é".repeat(LONGEST_SHOWN) + "…");
    }

    #[test]
    fn room_follows_the_text_and_not_the_promise() {
        let lines = Lines::new("file", &[b'1'; 100]).unwrap();
        assert_eq!((lines.room(3, 10), lines.room(u64::MAX, 10)), (3, 11));
    }
}
