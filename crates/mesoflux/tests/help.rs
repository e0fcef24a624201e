//! The help texts, compared with those under `tests/snapshots`. After a change on purpose,
//! `MESOFLUX_UPDATE=1 cargo test -p mesoflux --test help` writes the new ones: read them before you keep them.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, printed};
use std::path::Path;

fn compare(arguments: &str, snapshot: &str) {
    let output = Folder::with(FLUID).mesoflux(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots").join(snapshot);
    if std::env::var_os("MESOFLUX_UPDATE").is_some() {
        std::fs::write(&path, printed(&output)).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(printed(&output), expected, "mesoflux {arguments} no longer prints {snapshot}");
}

#[test]
fn help() {
    compare("--help", "help.txt");
}

#[test]
fn help_of_each_command() {
    for command in ["run", "resume", "check", "reproduce"] {
        compare(&format!("{command} --help"), &format!("help-{command}.txt"));
    }
}

#[test]
fn version() {
    let output = Folder::with(FLUID).mesoflux("--version");
    assert_eq!(printed(&output), format!("mesoflux {}\n", env!("CARGO_PKG_VERSION")));
}
