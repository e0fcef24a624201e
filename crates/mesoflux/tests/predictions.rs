//! What `check` predicts, and what is refused because of it.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, MEASURES, error, printed};

#[test]
fn check_predicts_memory_and_time_and_writes_nothing() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    let output = folder.mesoflux("check fluid.toml --threads 2");
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let text = printed(&output);
    for part in
        ["# memory: about ", " for 2 runs side by side, ", " are free here\n", "# time: about ", " on 2 threads, "]
    {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the input is there");
}

/// The number before a unit of memory, in bytes.
fn bytes(text: &str) -> f64 {
    let mut words = text.split_whitespace();
    let number: f64 = words.next().unwrap().parse().unwrap();
    let unit = words.next().unwrap();
    number
        * [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)]
            .iter()
            .find(|(name, _)| unit.starts_with(name))
            .unwrap()
            .1
}

/// What `check` predicts for so many particles, and what a run of this length with checkpoints takes, in bytes.
fn predicted_and_taken(particles: u64, time: f64, measures: &str) -> (f64, f64) {
    let input = FLUID
        .replace("particles = 64", &format!("particles = {particles}"))
        .replace("replicas = 2", "replicas = 1\ncheckpoint_interval = 15")
        .replace("equilibration_time = 0.2", "equilibration_time = 0.0")
        .replace("production_time = 4.0", &format!("production_time = {time:?}"));
    let folder = Folder::with(&format!("{input}{measures}"));
    let check = folder.mesoflux("check fluid.toml --threads 1");
    let predicted = bytes(printed(&check).split_once("# memory: about ").unwrap().1);
    // GNU's time is not everywhere; the kernel tells the peak of a child as well.
    let line = format!(
        "{} run fluid.toml --quiet --threads 1 --out out & PID=$!; \
         while kill -0 $PID 2>/dev/null; do grep VmHWM /proc/$PID/status 2>/dev/null; sleep 0.01; done; wait $PID",
        env!("CARGO_BIN_EXE_mesoflux")
    );
    let output = std::process::Command::new("sh").args(["-c", &line]).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", error(&output));
    let peak = printed(&output).lines().filter_map(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    (predicted, 1024.0 * peak.fold(0.0, f64::max))
}

#[test]
fn predicted_memory_is_what_a_run_takes() {
    let pressure = "[measure.P]\nquantity = \"pressure\"\n";
    let diffusion = "[measure.D]\nquantity = \"diffusion_coefficient\"\nroutes.msd = { longest_lag = 0.64 }\n";
    for (particles, time, measures) in [(20_000, 1.0, pressure), (20_000, 1.0, diffusion), (200_000, 0.4, pressure)] {
        let (predicted, taken) = predicted_and_taken(particles, time, measures);
        println!("{particles} particles: predicted {predicted:.3e}, taken {taken:.3e}");
        assert!(
            (0.8..1.2).contains(&(predicted / taken)),
            "{particles} particles, {measures}: predicted {predicted:.3e}, taken {taken:.3e}"
        );
    }
}

#[test]
fn more_particles_than_memory_are_refused_with_what_they_need() {
    let folder = Folder::with(&FLUID.replace("particles = 64", "particles = 4000000000"));
    for command in ["run fluid.toml --threads 1", "run fluid.toml --threads 1 --set system.particles=100000000000"] {
        let output = folder.mesoflux(command);
        assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    }
    let output = folder.mesoflux("run fluid.toml --threads 1");
    for part in [
        "system.particles: the runs need about ",
        " of memory at a time (4000000000 particles",
        "free here",
        "fluid.toml:5",
    ] {
        assert!(error(&output).contains(part), "{part} in {}", error(&output));
    }
    let check = folder.mesoflux("check fluid.toml");
    assert_eq!(check.status.code(), Some(0), "{}", error(&check));
    assert!(printed(&check).contains("TOO LITTLE"), "{}", printed(&check));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}
