//! Every file under `tests/input/bad` is refused with exactly the message that its own comments hold.
//!
//! The first line of a file says what is wrong with it; the lines that begin with `#|` are the message. After a message
//! was changed on purpose, `MESOFLUX_UPDATE=1 cargo test -p mesoflux-io --test bad_inputs` writes the new ones into the
//! files: read them as a user would before you keep them.

mod common;

use common::{bare_name, directory, input_files};
use mesoflux_io::input::{Files, InputFile};

/// The message that a text expects.
fn expected(text: &str) -> String {
    let lines = text.lines().filter_map(|line| line.strip_prefix("#|"));
    lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

/// A text that expects another message.
fn expecting(text: &str, message: &str) -> String {
    let mut lines = text.lines();
    let fault = lines.next().unwrap_or_default().to_owned();
    let message = message.lines().map(|line| format!("#| {line}").trim_end().to_owned());
    let rest = lines.filter(|line| !line.starts_with("#|")).map(str::to_owned);
    std::iter::once(fault).chain(message).chain(rest).map(|line| line + "\n").collect()
}

/// What a user reads.
fn message(name: &str, text: &str) -> String {
    match InputFile::parse(name, text, &[], Files::beside(&directory("bad"))) {
        Err(error) => error.to_string(),
        Ok(_) => "the input is accepted".to_owned(),
    }
}

#[test]
fn every_bad_input_is_refused_with_its_message() {
    let update = std::env::var_os("MESOFLUX_UPDATE").is_some();
    let paths = input_files("bad");
    let mut wrong = Vec::new();
    for path in &paths {
        let name = bare_name(path);
        let mut text = std::fs::read_to_string(path).unwrap();
        if update {
            // A longer message moves the lines that it names: once more for those.
            for _ in 0..3 {
                text = expecting(&text, &message(name, &text));
            }
            std::fs::write(path, &text).unwrap();
        }
        assert!(text.starts_with("# "), "{name}: the first line must say what is wrong");
        let (expected, found) = (expected(&text), message(name, &text));
        if expected != found || !found.starts_with("error: ") {
            wrong.push(format!("{name}\nexpected:\n{expected}\nfound:\n{found}\n"));
        }
    }
    assert!(wrong.is_empty(), "{} of {} messages differ:\n{}", wrong.len(), paths.len(), wrong.join("\n"));
    assert!(paths.len() >= 100, "only {} bad inputs were found", paths.len());
}
