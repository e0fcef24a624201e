//! Runs that are killed, interrupted or out of time go on to the same bits as undisturbed ones, on any number of threads.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{EXCHANGE, FLUID, Folder, MEASURES, Random, error, printed, signal, wait_until};
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

const KILLS: u64 = 20;

/// A run, killed at random moments and resumed with another number of threads each time, against the same run undisturbed.
///
/// Only kills of a living process count: a leg that comes to its end must have the undisturbed results, and the run begins anew with
/// shorter legs. The first runs have longer and longer ones until something is kept. No speed of the machine makes this fail.
fn killed_again_and_again(input: &str, seed: u64) {
    let folder = Folder::with(input);
    let start = Instant::now();
    folder.run("--quiet --out undisturbed --threads 2");
    // Twenty legs of three quarters of a twentieth on average, starting included, hardly come to the end.
    let mut longest = 1.5 * start.elapsed().as_secs_f64() / KILLS as f64;
    let mut random = Random(seed);
    let mut kills = 0;
    while kills < KILLS || folder.checkpoints("killed").is_empty() {
        let threads = 1 + kills % 3;
        // A run that was killed before it had a directory has not begun.
        let begun = folder.file("killed/input.toml").exists();
        let verb = if begun { "resume killed" } else { "run fluid.toml --out killed --force" };
        let mut child = folder.start(&format!("{verb} --quiet --threads {threads}"));
        std::thread::sleep(Duration::from_secs_f64(random.uniform() * longest));
        let ended = child.try_wait().unwrap().is_some();
        child.kill().unwrap();
        assert_eq!(error(&child.wait_with_output().unwrap()), "", "{verb}");
        if ended {
            folder.assert_same_results("killed", "undisturbed");
            std::fs::remove_dir_all(folder.file("killed")).unwrap();
            longest /= 2.0;
        } else {
            kills += 1;
            longest *= if begun { 1.0 } else { 1.2 };
        }
    }
    let end = folder.mesoflux("resume killed --quiet --threads 3");
    assert_eq!((end.status.code(), error(&end)), (Some(0), ""));
    folder.assert_same_results("killed", "undisturbed");
    let results = folder.results("killed");
    let number = |key: &str| results[key].as_f64().unwrap();
    let last_leg = number("particle_steps_per_second") * number("wall_seconds");
    assert!(last_leg < 0.99 * number("particle_steps"), "the last leg did everything again");
}

#[test]
fn a_large_norton_run_survives_kill_9() {
    let norton =
        "[measure.mobility]\nquantity = \"mobility\"\nforcing = \"color_drift\"\nroutes.norton = { flux = 0.5 }";
    let input = FLUID
        .replace("particles = 64", "particles = 20_000")
        .replace("replicas = 2", "replicas = 1\ncheckpoint_interval = 2")
        .replace("production_time = 4.0", "production_time = 3.0");
    killed_again_and_again(&format!("{input}\n{norton}\n"), 1);
}

#[test]
fn a_sweep_of_two_routes_and_three_replicas_survives_kill_9() {
    let input = FLUID
        .replace("particles = 64", "particles = 300")
        .replace("replicas = 2", "replicas = 3\ncheckpoint_interval = 2");
    let measure = "[measure.mobility]\nquantity = \"mobility\"\nforcing = \"color_drift\"\n\
                   routes.msd = {}\nroutes.norton = { flux = 2.0 }\n\
                   [sweep]\npair.all.friction.linear.coefficient = [4.5, 20.0]\n";
    killed_again_and_again(&format!("{input}\n{measure}"), 2);
}

/// Some seconds of work that keep states.
fn long_input() -> String {
    let input = FLUID
        .replace("production_time = 4.0", "production_time = 20.0")
        .replace("replicas = 2", "replicas = 2\ncheckpoint_interval = 50");
    format!("{input}{MEASURES}{EXCHANGE}")
}

/// Whether a process has its own answer to a signal.
fn catches(child: &Child, signal: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0").trim().to_owned();
    u64::from_str_radix(&mask, 16).unwrap() >> (signal - 1) & 1 == 1
}

/// A stop must leave incomplete results and say how to go on; what it says, given to a shell, must lead to the undisturbed results.
fn goes_on_as_printed(folder: &Folder, stopped: &Output, directory: &str) {
    assert_eq!(stopped.status.code(), Some(130), "{}", error(stopped));
    let before = folder.results(directory);
    assert_eq!(before["complete"], false);
    assert!(!folder.checkpoints(directory).is_empty());
    let message = error(stopped).trim_end();
    let line = message.strip_prefix("stopped; to go on: ").unwrap_or_else(|| panic!("{message}"));
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_mesoflux")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    let resumed = shell.args(["-c", line]).env("PATH", path).current_dir(folder.path()).output().unwrap();
    assert_eq!(resumed.status.code(), Some(0), "{line}: {}", error(&resumed));
    assert!(printed(&resumed).contains("results in "), "{}", printed(&resumed));
    folder.assert_same_results(directory, "undisturbed");
    // Every step counts: those that were done at the stop are not done again.
    let after = folder.results(directory);
    let number = |results: &serde_json::Value, key: &str| results[key].as_f64().unwrap();
    let again = number(&after, "particle_steps_per_second") * number(&after, "wall_seconds");
    let left = number(&after, "particle_steps") - number(&before, "particle_steps");
    assert!((again - left).abs() < 1.0, "{again} particle-steps where {left} were left");
}

#[test]
fn a_signal_stops_with_checkpoints_and_the_way_to_go_on() {
    let folder = Folder::with(&long_input());
    folder.run("--quiet --out undisturbed --set run.checkpoint_interval=1000000");
    // The last of them takes quotes in a shell.
    for (name, directory) in [("INT", "interrupted"), ("TERM", "terminated"), ("HUP", "it's-hung-up")] {
        let child = folder.start(&format!("run fluid.toml --quiet --threads 1 --out {directory}"));
        folder.wait_for_state(directory);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(printed(&output), "");
        goes_on_as_printed(&folder, &output, directory);
    }
}

#[test]
fn a_stop_prints_what_there_is() {
    let folder = Folder::with(&long_input());
    let child = folder.start("run fluid.toml --json --threads 1 --out out");
    folder.wait_for_state("out");
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), printed(&output)), (Some(130), &*folder.read("out/results.json")));
    let results = folder.results("out");
    // What has been done, not what was asked for.
    let asked = 2.0 * 4.0 * 64.0 * 1010.0;
    let done = results["particle_steps"].as_f64().unwrap();
    assert!(done > 0.0 && done < asked, "{done} of {asked}");
    assert!(results["runs"][0]["steps"].as_u64().unwrap() < 1000);
}

#[test]
fn a_run_out_of_wall_time_goes_on_later() {
    let folder = Folder::with(&long_input());
    folder.run("--quiet --out undisturbed --set run.checkpoint_interval=1000000");
    let output = folder.mesoflux("run fluid.toml --quiet --out late --max-wall 100ms --threads 1");
    goes_on_as_printed(&folder, &output, "late");
    // No time at all: nothing is begun, and nothing is lost.
    let none = folder.mesoflux("run fluid.toml --quiet --out none --max-wall 0s");
    assert_eq!(none.status.code(), Some(130));
    assert_eq!((&folder.results("none")["particle_steps"], folder.checkpoints("none").len()), (&0.0.into(), 0));
    assert_eq!(folder.mesoflux("resume none --quiet").status.code(), Some(0));
    folder.assert_same_results("none", "undisturbed");
}

#[test]
fn a_second_ctrl_c_ends_at_once() {
    // Placing so many particles takes a second, in which the first is not yet answered. On a busy machine the answer to the first may
    // all the same come before the second: then the test is tried again.
    let answered_once = |_| {
        let folder = Folder::with(&FLUID.replace("particles = 64", "particles = 1_000_000"));
        let child = folder.start("run fluid.toml --out out --threads 1");
        wait_until("the handler", || catches(&child, 2));
        signal(&child, "INT");
        signal(&child, "INT");
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130));
        // An orderly end writes results and says how to go on.
        folder.file("out/results.json").exists() || !error(&output).is_empty()
    };
    assert!(!(0..5).all(answered_once), "the second is never heard");
}

#[test]
fn a_second_hang_up_or_termination_changes_nothing() {
    let folder = Folder::with(&long_input());
    folder.run("--quiet --out undisturbed --set run.checkpoint_interval=1000000");
    let child = folder.start("run fluid.toml --quiet --threads 1 --out out");
    folder.wait_for_state("out");
    for name in ["HUP", "HUP", "TERM", "TERM"] {
        signal(&child, name);
    }
    goes_on_as_printed(&folder, &child.wait_with_output().unwrap(), "out");
}

#[test]
fn a_signal_that_is_ignored_stays_ignored() {
    let folder = Folder::with(&long_input());
    let line = format!("trap '' HUP; exec {} run fluid.toml --quiet --out out", env!("CARGO_BIN_EXE_mesoflux"));
    let mut child = Command::new("sh").args(["-c", &line]).current_dir(folder.path()).spawn().unwrap();
    folder.wait_for_state("out");
    assert!(catches(&child, 15) && !catches(&child, 1));
    signal(&child, "HUP");
    std::thread::sleep(Duration::from_millis(20));
    assert!(child.try_wait().unwrap().is_none());
    child.kill().unwrap();
    child.wait().unwrap();
}
