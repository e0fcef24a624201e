//! A thousand mutations of the good inputs: none makes the reader panic, and each is either an input or a message.

mod common;

use common::{Random, directory, input_files};
use mesoflux_io::input::{Files, InputError, InputFile};

const MUTATIONS: usize = 1000;

/// Numbers that inputs don't expect, and words that are no numbers.
const STRANGE: [&str; 16] = [
    "0",
    "-1",
    "nan",
    "-inf",
    "1e308",
    "1e-308",
    "9223372036854775807",
    "9223372036854775808",
    "0x10",
    "1_000",
    "true",
    "\"\"",
    "[]",
    "{}",
    "1979-05-27",
    "é",
];

/// Flips a bit of one byte; what is then no text becomes a replacement character.
fn flip(text: &str, random: &mut Random) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let place = random.below(bytes.len());
    bytes[place] ^= 1 << random.below(8);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Deletes, doubles or moves a line.
fn shuffle(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let line = lines.remove(random.below(lines.len()));
    for _ in 0..random.below(3) {
        lines.insert(random.below(lines.len() + 1), line);
    }
    lines.join("\n")
}

/// Replaces a number, or whatever stands to the right of an equals sign.
fn replace(text: &str, random: &mut Random) -> String {
    let starts: Vec<usize> = text.match_indices("= ").map(|(place, sign)| place + sign.len()).collect();
    let start = starts[random.below(starts.len())];
    let end = text[start..].find([',', ' ', '\n', '}', ']']).map_or(text.len(), |length| start + length);
    format!("{}{}{}", &text[..start], STRANGE[random.below(STRANGE.len())], &text[end..])
}

/// Cuts the end off.
fn cut(text: &str, random: &mut Random) -> String {
    text[..text.floor_char_boundary(random.below(text.len()))].to_owned()
}

#[test]
fn mutated_inputs_are_read_or_refused_with_a_message() {
    let texts: Vec<String> = input_files("good").iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let mut random = Random(1);
    let mut accepted = 0;
    for number in 0..MUTATIONS {
        let mut text = texts[number % texts.len()].clone();
        for _ in 0..=random.below(2) {
            let mutate = [flip, flip, flip, shuffle, shuffle, replace, replace, replace, cut][random.below(9)];
            if text.contains("= ") {
                text = mutate(&text, &mut random);
            }
        }
        let outcome = std::panic::catch_unwind(|| {
            InputFile::parse("mutated.toml", &text, &[], Files::beside(&directory("good")))
        });
        match outcome.unwrap_or_else(|_| panic!("the reader panics at\n{text}")) {
            Ok(_) => accepted += 1,
            Err(InputError::Wrong(message)) => {
                assert!(message.starts_with("error: ") && message.len() > 20, "{message:?} for\n{text}");
            }
            // A mutated name is that of no file.
            Err(error) => assert!(error.to_string().contains("named by system.start."), "{error} for\n{text}"),
        }
    }
    // Both ends of the road are walked.
    assert!((50..950).contains(&accepted), "{accepted} of {MUTATIONS} mutations are accepted");
}
