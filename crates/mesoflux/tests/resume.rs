//! `mesoflux resume`: of finished runs, to longer ones, of changed inputs, of what is no run, and while another process is at work.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{EXCHANGE, FLUID, Folder, MEASURES, error, printed, wait_until};

/// Every route, one lag of them left to follow from the production time, and a sweep.
fn input() -> String {
    let sweep = "[measure.D2]\nquantity = \"diffusion_coefficient\"\n[sweep]\ndynamics.temperature = [1.0, 1.5]\n";
    format!("{FLUID}{MEASURES}{EXCHANGE}{sweep}")
}

fn refused(folder: &Folder, arguments: &str, code: i32, parts: &[&str]) {
    let output = folder.mesoflux(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments}: {}", error(&output));
    assert_eq!(printed(&output), "", "{arguments}");
    for part in parts {
        assert!(error(&output).contains(part), "{arguments}: no {part:?} in\n{}", error(&output));
    }
}

#[test]
fn a_finished_run_says_so_and_computes_nothing_again() {
    let folder = Folder::with(&input());
    let run = folder.run("--out out --threads 2");
    folder.copy("out", "before");
    let states = |folder: &Folder| {
        let modified = |path: &std::path::PathBuf| std::fs::metadata(path).unwrap().modified().unwrap();
        folder.checkpoints("out").iter().map(modified).collect::<Vec<_>>()
    };
    let kept = states(&folder);
    let resumed = folder.mesoflux("resume out --threads 1");
    assert_eq!(resumed.status.code(), Some(0));
    let message = error(&resumed);
    for part in ["the run in out was complete already", "mesoflux resume out --set run.production_time=TIME"] {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
    let table = |text: &str| text.split("\n\n").take(2).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(table(printed(&resumed)), table(printed(&run)));
    assert_eq!(states(&folder), kept, "no state was written again");
    assert_eq!(folder.results("out")["particle_steps_per_second"], 0.0);
    folder.assert_same_results("out", "before");
    let quiet = folder.mesoflux("resume out --quiet");
    assert_eq!((quiet.status.code(), printed(&quiet), error(&quiet)), (Some(0), "", ""));
    let json = folder.mesoflux("resume out --json");
    assert_eq!(printed(&json), folder.read("out/results.json"));
}

#[test]
fn a_run_made_longer_has_the_bits_of_one_that_was_long_from_the_start() {
    let folder = Folder::with(&input());
    folder.run("--quiet --out short");
    let longer = folder.mesoflux("resume short --quiet --set run.production_time=7.0 --threads 3");
    assert_eq!((longer.status.code(), error(&longer)), (Some(0), ""));
    assert_eq!(folder.results("short")["input"]["run"]["production_time"], 7.0);
    // Displacements are followed as far as they were from the beginning, and the input now says how far that is.
    folder.write("long.toml", folder.read("short/input.toml"));
    assert!(folder.read("long.toml").contains("longest_lag = 0.2"), "{}", folder.read("long.toml"));
    assert!(folder.mesoflux("run long.toml --quiet --out long --threads 1").status.success());
    folder.assert_same_results("short", "long");
    // Where lags are given, the input made longer by hand is the same run.
    let given = input().replace(
        "quantity = \"diffusion_coefficient\"",
        "quantity = \"diffusion_coefficient\"\nroutes.msd.longest_lag = 0.2",
    );
    folder.write("given.toml", given.replace("production_time = 4.0", "production_time = 7.0"));
    assert!(folder.mesoflux("run given.toml --quiet --out given").status.success());
    assert_eq!(folder.results("given")["estimates"], folder.results("short")["estimates"]);
    assert_eq!(folder.results("given")["runs"], folder.results("short")["runs"]);
}

#[test]
fn an_extension_that_fails_leaves_no_results_of_the_shorter_run() {
    let folder = Folder::with(FLUID);
    folder.run("--quiet --out out");
    // Of one run, nothing that is whole is left.
    for path in folder.checkpoints("out").iter().take(2) {
        std::fs::write(path, "nothing").unwrap();
    }
    refused(&folder, "resume out --set run.production_time=8.0", 4, &[]);
    assert!(!folder.file("out/results.json").exists());
}

#[test]
fn a_changed_input_is_refused_with_what_has_changed() {
    let folder = Folder::with(&input());
    folder.run("--quiet --out out");
    let before = folder.read("out/input.toml");
    for (change, parts) in [
        ("dynamics.time_step=0.01", ["dynamics.time_step = 0.01", "was 0.02"]),
        ("run.seed=5", ["run.seed = 5", "was 1"]),
        ("run.replicas=3", ["run.replicas = 3", "was 2"]),
        ("system.particles=66", ["system.particles = 66", "was 64"]),
        ("pair.all.friction.linear.coefficient=5.0", ["pair.all.friction.linear.coefficient = 5.0", "was 4.5"]),
        ("run.production_time=2.0", ["run.production_time = 2", "at least 4"]),
        ("measure.D.routes.msd.longest_lag=0.1", ["measure.D.routes.msd.longest_lag = 0.1", "was absent"]),
        ("measure.P2.quantity=pressure", ["measure.P2", "was absent"]),
        ("sweep.dynamics.temperature=[1.0]", ["sweep.dynamics.temperature = [1.0]", "was [1.0, 1.5]"]),
    ] {
        refused(&folder, &format!("resume out --set {change}"), 2, &parts);
        assert_eq!(folder.read("out/input.toml"), before, "{change}");
    }
    // The same by hand, in the copy that stands in the directory.
    folder.write("out/input.toml", before.replace("repulsion = 25.0", "repulsion = 26.0"));
    refused(&folder, "resume out", 2, &["pair.all.potential.soft.repulsion = 26.0", "was 25.0", "when the run began"]);
    // Comments and the cadence of checkpoints are free.
    folder.write("out/input.toml", format!("# a comment\n{before}"));
    let resumed = folder.mesoflux("resume out --quiet --set run.checkpoint_interval=3");
    assert_eq!((resumed.status.code(), error(&resumed)), (Some(0), ""));
}

#[test]
fn a_production_time_that_is_swept_cannot_become_longer() {
    let folder = Folder::with(&format!("{FLUID}\n[sweep]\nrun.production_time = [2.0, 4.0]\n"));
    folder.run("--quiet --out out");
    refused(&folder, "resume out --set run.production_time=8.0", 2, &["run.production_time: is swept"]);
}

#[test]
fn a_directory_that_holds_no_run_is_refused() {
    let folder = Folder::with(FLUID);
    refused(&folder, "resume absent", 4, &["error: absent: does not exist"]);
    std::fs::create_dir(folder.file("empty")).unwrap();
    refused(&folder, "resume empty", 4, &["error: empty: holds no input.toml; must be the directory of a run"]);
    // An input of somebody's own is no run.
    folder.write("empty/input.toml", FLUID);
    refused(&folder, "resume empty", 4, &["error: empty: holds no states"]);
    refused(&folder, "resume fluid.toml", 4, &["fluid.toml"]);
    assert_eq!(std::fs::read_dir(folder.file("empty")).unwrap().count(), 1, "nothing was made");
}

#[test]
fn a_second_process_is_kept_out_and_told_by_whom() {
    let folder = Folder::with(&FLUID.replace("production_time = 4.0", "production_time = 1e6"));
    let mut child = folder.start("run fluid.toml --quiet --out out --max-wall 20s");
    wait_until("the input", || folder.file("out/states/input.toml").exists());
    let holder = format!("out: is in use by process {}", child.id());
    refused(&folder, "resume out", 4, &[&holder]);
    refused(&folder, "run fluid.toml --out out --force", 4, &[&holder]);
    assert!(folder.file("out/states/input.toml").exists(), "nothing of it was touched");
    // However the process dies, nothing is left of its claim.
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(
        folder.mesoflux("run fluid.toml --quiet --out out --force --set run.production_time=1.0").status.code(),
        Some(0)
    );
}

#[test]
fn what_a_killed_process_left_half_written_is_removed() {
    let folder = Folder::with(FLUID);
    for arguments in ["resume out --quiet", "run fluid.toml --quiet --out out --force"] {
        if !folder.file("out").exists() {
            folder.run("--quiet --out out");
            folder.copy("out", "undisturbed");
        }
        let name = std::fs::read_dir(folder.file("out")).unwrap().count();
        for place in ["out", "out/states"] {
            folder.write(&format!("{place}/.mesoflux-unfinished-results.json"), "{");
        }
        assert_eq!(folder.mesoflux(arguments).status.code(), Some(0));
        assert_eq!(std::fs::read_dir(folder.file("out")).unwrap().count(), name);
        folder.assert_same_results("out", "undisturbed");
    }
}

#[test]
fn a_run_by_force_does_not_go_on_from_the_states_of_another() {
    let folder = Folder::with(FLUID);
    folder.run("--quiet --out out");
    folder.run("--quiet --out fresh --seed 2 --set run.replicas=1");
    folder.run("--quiet --out out --force --seed 2 --set run.replicas=1");
    folder.assert_same_results("out", "fresh");
    let names = |out: &str| {
        folder.checkpoints(out).into_iter().map(|path| path.file_name().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names("out"), names("fresh"));
}
