//! Disks that are full, directories that vanish, files that are damaged: exit 4 with file and reason, and what was kept leads on.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, error, list, printed, wait_until};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

/// Three runs, tables and a figure.
const MEASURE: &str = r#"
[measure.mobility]
quantity = "mobility"
forcing = "color_drift"
routes.nemd = { magnitude = [4.0, 8.0] }
routes.norton = { flux = 2.0 }
"#;

fn input() -> String {
    let input = FLUID.replace("replicas = 2", "replicas = 1\ncheckpoint_interval = 20");
    format!("{input}{MEASURE}")
}

/// A run that lasts until something happens to it.
fn endless() -> String {
    FLUID.replace("replicas = 2", "replicas = 1\ncheckpoint_interval = 50").replace("= 4.0", "= 400.0")
}

fn fails(output: &Output, code: i32, parts: &[&str]) {
    let message = error(output);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.starts_with("error: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
}

/// The program's options for a mount namespace of one's own, if the system grants one.
fn namespace() -> Option<&'static str> {
    let granted = |option: &&str| {
        let mut command = Command::new("unshare");
        let command = command.args([option, "sh", "-c", "mount -t tmpfs tmpfs /tmp"]);
        command.output().is_ok_and(|output| output.status.success())
    };
    let option = ["-m", "-rm"].into_iter().find(granted);
    if option.is_none() {
        eprintln!("skipped: this system grants no mount namespace");
    }
    option
}

/// Runs a script in a mount namespace of its own.
fn in_namespace(folder: &Folder, option: &str, script: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_mesoflux");
    let mut command = Command::new("unshare");
    command.args([option, "sh", "-c", script]).current_dir(folder.path()).env("mesoflux", program).output().unwrap()
}

/// Where a run on a full disk came to its end, from the file that its message names.
fn point_of_failure(message: &str) -> &'static str {
    let name = message.lines().next().unwrap().strip_suffix(": No space left on device (os error 28)");
    let path = name.unwrap_or_else(|| panic!("no reason in {message}"));
    match Path::new(path).extension().unwrap().to_str().unwrap() {
        "toml" => "input",
        "checkpoint" => "state",
        "csv" => "table",
        "svg" => "figure",
        "json" => "results",
        _ => panic!("{message}"),
    }
}

#[test]
fn a_disk_that_is_full_at_any_point_costs_nothing_that_was_kept() {
    let Some(option) = namespace() else { return };
    let folder = Folder::with(&input());
    folder.run("--quiet --out undisturbed");
    std::fs::create_dir(folder.file("disk")).unwrap();
    let mut seen = BTreeSet::new();
    for pages in 1.. {
        assert!(pages < 200, "the run doesn't fit on any disk");
        let kept = format!("kept-{pages}");
        let script = format!(
            "mount -t tmpfs -o size={}k tmpfs disk && \"$mesoflux\" run fluid.toml --quiet --threads 1 --out disk/out; \
             code=$?; cp -r disk {kept}; exit $code",
            4 * pages
        );
        let output = in_namespace(&folder, option, &script);
        let out = format!("{kept}/out");
        if output.status.success() {
            folder.assert_same_results(&out, "undisturbed");
            break;
        }
        fails(&output, 4, &["error: ", "disk/out"]);
        let states = folder.checkpoints(&out).len();
        let point = point_of_failure(error(&output));
        seen.insert(format!("{point}{}", if point == "state" && states > 0 { ", later" } else { "" }));
        assert!(!folder.file(&out).join("results.json").exists(), "at {pages} pages: the runs have no results");
        let resumed = folder.mesoflux(&format!("resume {out} --quiet"));
        if folder.file(&out).join("input.toml").exists() {
            assert_eq!((resumed.status.code(), error(&resumed)), (Some(0), ""), "at {pages} pages");
            folder.assert_same_results(&out, "undisturbed");
            let results = folder.results(&out);
            let number = |key: &str| results[key].as_f64().unwrap();
            let again = number("particle_steps_per_second") * number("wall_seconds");
            assert!(states == 0 || again < 0.99 * number("particle_steps"), "at {pages} pages: no state was used");
            if point != "input" {
                assert!(error(&output).contains("go on with: mesoflux resume disk/out"), "{}", error(&output));
            }
        } else {
            fails(&resumed, 4, &[&format!("{out}: holds no input.toml")]);
            assert_eq!(states, 0);
        }
    }
    for point in ["input", "state", "state, later", "results"] {
        assert!(seen.contains(point), "no failure at {point:?} among {seen:?}");
    }
    assert!(seen.contains("table") || seen.contains("figure"), "no failure at a table or figure among {seen:?}");
}

#[test]
fn a_directory_that_becomes_read_only_stops_the_run() {
    let Some(option) = namespace() else { return };
    let folder = Folder::with(&endless());
    let script = "\"$mesoflux\" run fluid.toml --quiet --out out & \
                  until ls out/states/*.checkpoint >/dev/null 2>&1; do sleep 0.01; done; \
                  mount --bind out/states out/states && \
                  until mount -o remount,ro,bind out/states 2>/dev/null; do sleep 0.001; done; wait $!";
    let output = in_namespace(&folder, option, script);
    fails(&output, 4, &["out/states/point-0-run-0-replica-0.", ".checkpoint: Read-only file system", "resume out"]);
    goes_on(&folder, "out");
}

/// What a disturbed endless run has kept, cut short, must be what an undisturbed one of that length is.
fn goes_on(folder: &Folder, directory: &str) {
    assert!(!folder.file(directory).join("results.json").exists());
    let resumed = folder.mesoflux(&format!("resume {directory} --quiet --set run.checkpoint_interval=1000000"));
    assert_eq!((resumed.status.code(), error(&resumed)), (Some(0), ""));
    folder.run("--quiet --out undisturbed --set run.checkpoint_interval=1000000");
    folder.assert_same_results(directory, "undisturbed");
}

#[test]
fn a_directory_that_vanishes_stops_the_run() {
    let folder = Folder::with(&endless());
    let child = folder.start("run fluid.toml --quiet --out out");
    folder.wait_for_state("out");
    std::fs::rename(folder.file("out"), folder.file("elsewhere")).unwrap();
    let output = child.wait_with_output().unwrap();
    fails(&output, 4, &["out/states/point-0-run-0-replica-0.", ".checkpoint: No such file or directory"]);
    goes_on(&folder, "elsewhere");
}

#[test]
fn states_replaced_by_a_file_stop_the_run() {
    let folder = Folder::with(&endless());
    let child = folder.start("run fluid.toml --quiet --out out");
    folder.wait_for_state("out");
    std::fs::rename(folder.file("out/states"), folder.file("states")).unwrap();
    folder.write("out/states", "in the way");
    fails(&child.wait_with_output().unwrap(), 4, &["out/states/point-0-run-0-replica-0.", "Not a directory"]);
    fails(&folder.mesoflux("resume out"), 4, &["out/states: not a directory"]);
    std::fs::remove_file(folder.file("out/states")).unwrap();
    std::fs::rename(folder.file("states"), folder.file("out/states")).unwrap();
    goes_on(&folder, "out");
}

#[test]
fn results_that_cannot_be_written_are_written_by_resume() {
    let folder = Folder::with(&endless());
    folder.run("--quiet --out undisturbed --set run.checkpoint_interval=1000000");
    let child = folder.start("run fluid.toml --quiet --out out");
    wait_until("the input", || folder.file("out/input.toml").exists());
    // A folder with something in it can't be replaced.
    std::fs::create_dir_all(folder.file("out/results.json/in-the-way")).unwrap();
    fails(&child.wait_with_output().unwrap(), 4, &["out/results.json: ", "go on with: mesoflux resume out"]);
    fails(&folder.mesoflux("resume out --quiet"), 4, &["out/results.json: "]);
    std::fs::remove_dir_all(folder.file("out/results.json")).unwrap();
    assert_eq!(folder.mesoflux("resume out --quiet").status.code(), Some(0));
    assert_eq!(folder.results("out")["particle_steps_per_second"], 0.0, "no step was done again");
    folder.assert_same_results("out", "undisturbed");
}

#[test]
fn results_that_are_half_written_are_written_again() {
    let folder = Folder::with(&input());
    folder.run("--quiet --out out");
    folder.copy("out", "undisturbed");
    let whole = folder.read("out/results.json");
    folder.write("out/results.json", &whole[..whole.len() / 2]);
    assert_eq!(folder.mesoflux("resume out --quiet").status.code(), Some(0));
    folder.assert_same_results("out", "undisturbed");
}

/// A way in which a file can be damaged, and how it is done.
type Damage = (&'static str, fn(&mut Vec<u8>));

fn damages() -> [Damage; 5] {
    [
        ("a flipped bit", |bytes| {
            let middle = bytes.len() / 2;
            bytes[middle] ^= 16;
        }),
        ("truncated", |bytes| bytes.truncate(bytes.len() / 3)),
        ("without contents", Vec::clear),
        ("with something at its end", |bytes| bytes.extend(b"more")),
        ("all zeros", |bytes| bytes.fill(0)),
    ]
}

#[test]
fn a_damaged_checkpoint_is_passed_over_and_it_is_said() {
    let folder = Folder::with(&input());
    folder.run("--quiet --out undisturbed");
    let files = folder.checkpoints("undisturbed");
    assert_eq!(files.len(), 6, "two states of each of three runs");
    let mut went_back = 0;
    for file in files.iter().take(2).map(|path| path.file_name().unwrap().to_str().unwrap()) {
        for (damage, change) in damages() {
            folder.copy("undisturbed", "out");
            let mut bytes = std::fs::read(folder.file("out/states").join(file)).unwrap();
            change(&mut bytes);
            folder.write(&format!("out/states/{file}"), bytes);
            let path = format!("out/states/{file}: ");
            for arguments in ["--quiet", "--json", ""] {
                folder.copy("out", "copy");
                std::fs::rename(folder.file("out"), folder.file("aside")).unwrap();
                std::fs::rename(folder.file("copy"), folder.file("out")).unwrap();
                let output = folder.mesoflux(&format!("resume out {arguments}"));
                assert_eq!(output.status.code(), Some(0), "{damage}: {}", error(&output));
                let said = if arguments.is_empty() { printed(&output) } else { error(&output) };
                let warning = format!("warning: nemd run, magnitude = 4.0, replica 0: {path}");
                assert!(said.contains(&warning) && said.contains("passed over"), "{damage}: {said}");
                let results = folder.results("out");
                let remark = list(&results["runs"])[0]["remarks"][0].as_str().unwrap();
                assert!(remark.starts_with(&path), "{damage}: {remark}");
                assert!(results["runs"][1].get("remarks").is_none());
                went_back += u64::from(results["particle_steps_per_second"].as_f64().unwrap() > 0.0);
                folder.assert_same_results("out", "undisturbed");
                std::fs::remove_dir_all(folder.file("out")).unwrap();
                std::fs::rename(folder.file("aside"), folder.file("out")).unwrap();
            }
            std::fs::remove_dir_all(folder.file("out")).unwrap();
        }
    }
    assert_eq!(went_back, 15, "one of the two files is the newest");
}

#[test]
fn where_all_checkpoints_of_a_run_are_damaged_they_are_named() {
    let folder = Folder::with(&input());
    folder.run("--quiet --out out");
    folder.copy("out", "undisturbed");
    let files = ["a", "b"].map(|letter| format!("out/states/point-0-run-1-replica-0.{letter}.checkpoint"));
    for file in &files {
        folder.write(file, "nothing");
    }
    let output = folder.mesoflux("resume out --quiet");
    let place = "error: nemd run, magnitude = 8.0, replica 0: ";
    fails(&output, 4, &[place, &files[0], &files[1], "no whole state of this run is left", "delete"]);
    for file in &files {
        std::fs::remove_file(folder.file(file)).unwrap();
    }
    assert_eq!(folder.mesoflux("resume out --quiet").status.code(), Some(0));
    folder.assert_same_results("out", "undisturbed");
}

#[test]
fn a_time_step_too_large_keeps_the_last_good_state() {
    let cores = "potential.wca = { epsilon = 1.0, sigma = 1.0 }";
    let input = FLUID
        .replace("potential.soft = { repulsion = 25.0, cutoff = 1.0 }", cores)
        .replace("density = 3.0", "density = 0.8")
        .replace("time_step = 0.02", "time_step = 0.035")
        .replace("replicas = 2", "replicas = 1\ncheckpoint_interval = 1")
        .replace("production_time = 4.0", "production_time = 400.0");
    let folder = Folder::with(&input);
    let output = folder.mesoflux("run fluid.toml --quiet --out out");
    fails(&output, 3, &["equilibrium run, replica 0: at step ", "particle ", "time step is too large"]);
    assert!(!folder.file("out/results.json").exists());
    assert_eq!(folder.checkpoints("out").len(), 2, "{}", error(&output));
    // From the state before it, the same happens at the same step.
    let again = folder.mesoflux("resume out --quiet");
    assert_eq!((again.status.code(), error(&again)), (Some(3), error(&output)));
    // Cut short before that step, the same run has results.
    let step = error(&output).split("at step ").nth(1).unwrap().split(':').next().unwrap();
    let time = 0.035 * (step.parse::<f64>().unwrap() - 2.0) - 0.2;
    assert_eq!(
        folder.mesoflux(&format!("run fluid.toml --quiet --set run.production_time={time}")).status.code(),
        Some(0)
    );
}
