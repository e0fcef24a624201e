//! `cargo xtask mutate` tried on a toy crate in a repository of its own: every verdict that can come out.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const MANIFEST: &str = "[package]\nname = \"toy\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[workspace]\n";

const LIBRARY: &str = "\
//! A toy.

/// Twice the number.
pub fn double(number: u32) -> u32 {
    2 * number
}

/// Counts down to zero.
pub fn count_down(mut number: u32) -> u32 {
    while number > 0 {
        number -= 1;
    }
    number
}

#[cfg(test)]
mod tests {
    #[test]
    fn doubles() {
        assert_eq!(super::double(3), 6);
    }

    #[test]
    #[ignore = \"slow\"]
    fn doubles_slowly() {
        assert_eq!(super::double(30), 60);
    }

    #[test]
    fn ends() {
        assert_eq!(super::count_down(3), 0);
    }

    #[test]
    fn is_wrong() {
        assert_eq!(super::double(1), 1);
    }
}
";

/// Name | tests | a further header line | the changed code | what it becomes | the verdict.
const MUTATIONS: &str = "\
aborts | tests::ends                                | | number -= 1; | std::process::abort(); | red
absent | tests::nothing                             | | 2 * number | 3 * number | no such test
broken | tests::doubles                             | | 2 * number | 2 * | does not compile
green  | tests::ends                                | | 2 * number | 3 * number | STILL GREEN
hangs  | tests::ends                                | # timeout: 2 | number -= 1; | number -= 0; | HANGS
red    | toy::tests::doubles, tests::doubles_slowly | | 2 * number | 3 * number | red
stale  | tests::doubles                             | | 4 * number | 5 * number | does not apply
target | tests::doubles                             | # target: --test no | 2 * number | 3 * number | does not compile unmutated
wrong  | tests::is_wrong                            | | 2 * number | 3 * number | red unmutated
";

/// The cells of a line, without the spaces around them.
fn cells(line: &str) -> Vec<&str> {
    line.split('|').map(str::trim).collect()
}

/// The mutation of a line of [`MUTATIONS`], as its file's name and text.
fn patch(line: &str) -> (String, String) {
    let [name, tests, further, from, to, _] = cells(line)[..] else { panic!("six cells: {line}") };
    let tests = tests.replace(", ", "\n# test: ");
    let lines: Vec<&str> = LIBRARY.lines().collect();
    let place = lines.iter().position(|line| line.trim() == from).unwrap_or(1);
    let text = format!(
        "# what: {name}\n# test: {tests}\n# package: toy\n{further}\n\
         diff --git a/src/lib.rs b/src/lib.rs\n--- a/src/lib.rs\n+++ b/src/lib.rs\n\
         @@ -{place},3 +{place},3 @@\n {above}\n-{from}\n+{to}\n {below}\n",
        above = lines[place - 1],
        from = lines[place].replace(lines[place].trim(), from),
        below = lines[place + 1],
    );
    (format!("tests/mutations/{name}.patch"), text)
}

/// A directory that disappears at the end of the test.
struct Scratch(PathBuf);

impl Scratch {
    /// The toy with its mutations, in a git repository; `None` where there is no git.
    fn create(name: &str) -> Option<Self> {
        let scratch = Self(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id())));
        scratch.write("Cargo.toml", MANIFEST);
        scratch.write("src/lib.rs", LIBRARY);
        scratch.write(".gitignore", "/target\n");
        for (name, text) in MUTATIONS.lines().map(patch) {
            scratch.write(&name, &text);
        }
        let made = Command::new("git").args(["init", "--quiet"]).current_dir(&scratch.0).status();
        made.is_ok_and(|status| status.success()).then_some(scratch)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("a name lies in a directory")).expect("the scratch can be written");
        fs::write(path, text).expect("the scratch can be written");
    }

    fn mutate(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command.arg("mutate").args(arguments).current_dir(&self.0);
        // What cargo says to this test is not meant for the toy.
        command.env("CARGO_MANIFEST_DIR", self.0.join("xtask")).env("CARGO_TARGET_DIR", self.0.join("target"));
        command.output().expect("xtask was built for this test")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The mutations and verdicts of a table, a pair for each test.
fn verdicts(table: &str) -> Vec<(String, String)> {
    let rows = table.lines().skip(2).filter(|line| line.starts_with('|')).map(cells);
    rows.map(|row| (row[1].to_string(), row[4].to_string())).collect()
}

#[test]
fn every_verdict_comes_out_and_the_tree_stays_untouched() {
    let Some(scratch) = Scratch::create("verdicts") else {
        eprintln!("skipped: git is not installed");
        return;
    };
    let output = scratch.mutate(&[]);
    let table = String::from_utf8(output.stdout).unwrap();
    let messages = String::from_utf8(output.stderr).unwrap();
    let mut found = verdicts(&table);
    found.sort();
    let mut expected = Vec::new();
    for mutation in MUTATIONS.lines().map(cells) {
        expected.extend(mutation[1].split(',').map(|_| (mutation[0].to_string(), mutation[5].to_string())));
    }
    assert_eq!(found, expected, "{table}\n{messages}");
    assert_eq!(output.status.code(), Some(1));
    assert!(messages.contains("7 of 9 mutations did not turn their tests red"), "{messages}");
    assert_eq!(fs::read_to_string(scratch.0.join("target/mutate/table.md")).unwrap(), table);
    assert_eq!(fs::read_to_string(scratch.0.join("src/lib.rs")).unwrap(), LIBRARY);
    assert_eq!(fs::read_to_string(scratch.0.join("target/mutate/tree/src/lib.rs")).unwrap(), LIBRARY);

    let output = scratch.mutate(&["red", "tests/mutations/aborts.patch"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(verdicts(&String::from_utf8(output.stdout).unwrap()).len(), 3);
}

#[test]
fn names_and_headers_are_checked_before_anything_runs() {
    let Some(scratch) = Scratch::create("names") else {
        eprintln!("skipped: git is not installed");
        return;
    };
    let output = scratch.mutate(&["rde"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "xtask: no mutation `rde`; did you mean red?\n");

    let output = scratch.mutate(&["--list", "red"]);
    assert_eq!(output.status.code(), Some(0));
    let list = String::from_utf8(output.stdout).unwrap();
    assert_eq!(list.lines().count(), 4);
    assert!(list.contains("toy::tests::doubles_slowly"), "{list}");

    scratch.write("tests/mutations/unfinished.patch", "# what: nothing\n");
    let output = scratch.mutate(&["red"]);
    assert_eq!(output.status.code(), Some(2));
    let message = "xtask: unfinished.patch: there must be a unified diff after the header\n";
    assert_eq!(String::from_utf8(output.stderr).unwrap(), message);
    assert!(!scratch.0.join("target").exists());
}
