//! Exit codes and the messages that come with them: 0 done, 2 wrong input or command line, 3 numerical failure, 4 files.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, error, printed};

/// Expects a failure: its code, and what its message must hold.
fn fails(folder: &Folder, arguments: &str, code: i32, parts: &[&str]) {
    let output = folder.mesoflux(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments}: {}", error(&output));
    assert_eq!(printed(&output), "", "{arguments}: what went wrong belongs on standard error");
    let message = error(&output);
    assert!(message.starts_with("error: "), "{arguments}: {message}");
    for part in parts {
        assert!(message.contains(part), "{arguments}: no {part:?} in\n{message}");
    }
}

fn nothing_was_made(folder: &Folder) {
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the input is there");
}

#[test]
fn a_run_that_is_done_exits_with_0() {
    assert_eq!(Folder::with(FLUID).mesoflux("run fluid.toml").status.code(), Some(0));
}

#[test]
fn a_wrong_input_exits_with_2_and_leaves_no_directory() {
    let folder = Folder::with(&FLUID.replace("density", "densty"));
    fails(&folder, "run fluid.toml", 2, &["system.densty: unknown key", "fluid.toml:6:1", "^^^^^^", "`density`"]);
    folder.write("fluid.toml", FLUID.replace("density = 3.0", "density = -3"));
    fails(&folder, "run fluid.toml", 2, &["system.density = -3.0: must be positive", "fluid.toml:6:11"]);
    nothing_was_made(&folder);
}

#[test]
fn an_input_that_is_no_text_exits_with_2() {
    let folder = Folder::with(FLUID);
    folder.write("fluid.toml", b"title = \"caf\xe9\"\n");
    fails(&folder, "run fluid.toml", 2, &["fluid.toml: line 1 holds the byte 0xe9: must be text in UTF-8"]);
}

#[test]
fn a_wrong_setting_exits_with_2() {
    let folder = Folder::with(FLUID);
    let cases = [
        ("--set run.replicas=0", "run.replicas = 0: must be at least 1"),
        ("--set run.replica=3", "did you mean `replicas`?"),
        ("--set system.start=cubic", "did you mean `cubic_lattice`?"),
        ("--set run.replicas.first=3", "--set run.replicas.first=3: `replicas` is a value, not a table"),
        ("--set run.replicas", "must have the form path.to.key=value"),
        ("--set =3", "must have the form path.to.key=value"),
    ];
    for (arguments, part) in cases {
        fails(&folder, &format!("run fluid.toml {arguments}"), 2, &[part]);
    }
    // A setting is named with the place, which is not in the file alone.
    fails(&folder, "run fluid.toml --set run.replicas=0", 2, &["fluid.toml with run.replicas=0"]);
    nothing_was_made(&folder);
}

#[test]
fn a_wrong_command_line_exits_with_2() {
    let folder = Folder::with(FLUID);
    for arguments in [
        "ran fluid.toml",
        "run",
        "run fluid.toml --thread 2",
        "run fluid.toml --threads 0",
        "run fluid.toml --threads two",
        "run fluid.toml --seed -1",
        "run fluid.toml --force",
        "run fluid.toml other.toml",
    ] {
        fails(&folder, arguments, 2, &[]);
    }
    nothing_was_made(&folder);
}

#[test]
fn a_run_that_blows_up_exits_with_3_and_says_where_and_why() {
    let cores = "potential.wca = { epsilon = 1.0, sigma = 1.0 }";
    let input = FLUID
        .replace("potential.soft = { repulsion = 25.0, cutoff = 1.0 }", cores)
        .replace("density = 3.0", "density = 0.8")
        .replace("time_step = 0.02", "time_step = 0.5");
    let folder = Folder::with(&input);
    let parts = ["equilibrium run", "replica 0", "at step ", "particle ", "Likely cause: the time step is too large"];
    fails(&folder, "run fluid.toml", 3, &parts);
}

#[test]
fn an_input_that_cannot_be_read_exits_with_4() {
    let folder = Folder::with(FLUID);
    fails(&folder, "run absent.toml", 4, &["absent.toml: can't be read"]);
    fails(&folder, "run .", 4, &["can't be read"]);
    nothing_was_made(&folder);
}

#[test]
fn results_that_cannot_be_written_exit_with_4() {
    let folder = Folder::with(FLUID);
    folder.write("file", "in the way");
    fails(&folder, "run fluid.toml --out file/out", 4, &["file/out"]);
    // A folder stands where the copy of the input belongs.
    std::fs::create_dir_all(folder.file("out/input.toml")).unwrap();
    fails(&folder, "run fluid.toml --out out --force", 4, &["input.toml"]);
}
