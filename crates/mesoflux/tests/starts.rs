//! Runs that start from files: particles, momenta, box and bonds are the file's, and a run keeps its own copy of it.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{Folder, error, list};
use serde_json::Value;
use std::fmt::Write;

/// One tiny step at constant energy: what is measured is the start.
const STILL: &str = r#"
[dynamics]
temperature = 1.0
time_step = 1e-7
word = "BAB"
thermostat = "none"

[run]
equilibration_time = 0.0
production_time = 4e-7
sample_interval = 1

[measure.T]
quantity = "temperature"

[measure.U]
quantity = "potential_energy"
"#;

const SPRING: &str = "[bond.spring]\npotential.harmonic = { stiffness = 8.0, length = 0.5 }\n";
/// A law that does nothing.
const LAW: &str = "[pair.all]\npotential.soft = { repulsion = 0.0, cutoff = 1.0 }\n";

fn value(results: &Value, quantity: &str) -> f64 {
    let estimate = list(&results["estimates"]).iter().find(|estimate| estimate["quantity"] == quantity).unwrap();
    estimate["value"].as_f64().unwrap_or_else(|| panic!("{estimate}"))
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-5 * expected.abs(), "{found} against {expected}");
}

/// Four dumbbells of length 0.9 and masses 1 and 3, each moving at (0.3, 0, 0) and (−0.1, 0, 0) plus a drift of all.
fn dumbbells(drift: f64) -> String {
    let (mut atoms, mut velocities, mut bonds) = (String::new(), String::new(), String::new());
    for k in 0..4 {
        let y = f64::from(k) - 1.5;
        // The second bead lies beyond the face of the box; atoms come in any order.
        writeln!(atoms, "{} 1 1 1.6 {y} 0\n{} 1 2 -1.5 {y} 0", 8 - 2 * k, 7 - 2 * k).unwrap();
        writeln!(velocities, "{} {} 0 0\n{} {} 0 0", 8 - 2 * k, 0.3 + drift, 7 - 2 * k, drift - 0.1).unwrap();
        writeln!(bonds, "{} 1 {} {}", k + 1, 8 - 2 * k, 7 - 2 * k).unwrap();
    }
    format!(
        "four dumbbells\n\n8 atoms\n2 atom types\n4 bonds\n1 bond types\n\n-2 2 xlo xhi\n-2 2 ylo yhi\n-2 2 zlo zhi\n\n\
         Masses\n\n1 1\n2 3\n\nAtoms # bond\n\n{atoms}\nVelocities\n\n{velocities}\nBonds\n\n{bonds}"
    )
}

fn dumbbell_input(keys: &str) -> String {
    format!(
        "[system]\nstart.lammps_data = {{ path = \"data/dumbbells.data\", species = {{ 1 = \"light\", 2 = \"heavy\" }}{keys} }}\n\
         [species.light]\n[species.heavy]\nmass = 3.0\n{SPRING}{LAW}{STILL}"
    )
}

fn folder_of_dumbbells(keys: &str) -> Folder {
    let folder = Folder::with(&dumbbell_input(keys));
    std::fs::create_dir(folder.file("data")).unwrap();
    folder.write("data/dumbbells.data", dumbbells(5.0));
    folder
}

#[test]
fn particles_momenta_and_bonds_of_a_lammps_file_are_taken_over() {
    let results = folder_of_dumbbells("").run_for_results("");
    // Without the drift, Σ m v² = 4 (0.09 + 3 · 0.01) over 3 (8 − 1) degrees of freedom.
    close(value(&results, "temperature"), 0.48 / 21.0);
    // Each bond is 0.9 long across the face: 4 · ½ · 8 · 0.4².
    close(value(&results, "potential_energy"), 2.56);
    let input = &results["input"];
    assert_eq!((&input["system"]["particles"], &input["species"]["heavy"]["particles"]), (&8.into(), &4.into()));
    assert_eq!(input["system"]["box"], serde_json::json!([4.0, 4.0, 4.0]));
}

#[test]
fn momenta_are_drawn_where_asked_and_differ_between_replicas() {
    let folder = folder_of_dumbbells(", momenta = \"draw\"");
    let results = folder.run_for_results("--set run.replicas=2 --set dynamics.temperature=5.0");
    let temperatures: Vec<f64> =
        list(&results["runs"]).iter().map(|run| run["temperature"].as_f64().unwrap()).collect();
    assert!(temperatures.iter().all(|kt| *kt > 0.5) && temperatures[0] != temperatures[1], "{temperatures:?}");
}

#[test]
fn a_run_keeps_the_file_it_starts_from() {
    let folder = folder_of_dumbbells("");
    folder.run("--quiet --out whole");
    let stopped = folder.mesoflux("run fluid.toml --quiet --out stopped --max-wall 0s");
    assert_eq!(stopped.status.code(), Some(130), "{}", error(&stopped));
    std::fs::remove_dir_all(folder.file("data")).unwrap();
    let resumed = folder.mesoflux("resume stopped --quiet");
    assert_eq!(resumed.status.code(), Some(0), "{}", error(&resumed));
    assert_eq!(folder.results("stopped")["estimates"], folder.results("whole")["estimates"]);
    let gone = folder.mesoflux("run fluid.toml --quiet");
    assert_eq!(gone.status.code(), Some(4), "{}", error(&gone));
    assert!(error(&gone).contains("data/dumbbells.data, named by system.start.lammps_data.path"), "{}", error(&gone));
}

#[test]
fn a_checkpoint_is_a_start_with_its_bonds_and_momenta() {
    let folder = folder_of_dumbbells("");
    let first = folder.run_for_results("");
    let checkpoint = "out/states/point-0-run-0-replica-0.a.checkpoint";
    folder.write(
        "again.toml",
        format!(
            "[system]\nstart.checkpoint = {{ path = \"{checkpoint}\" }}\n[species.light]\n[species.heavy]\nmass = 3.0\n\
             {SPRING}{LAW}{STILL}"
        ),
    );
    let again = folder.mesoflux("run again.toml --quiet --out again");
    assert_eq!(again.status.code(), Some(0), "{}", error(&again));
    let second = folder.results("again");
    for quantity in ["temperature", "potential_energy"] {
        close(value(&second, quantity), value(&first, quantity));
    }
}

#[test]
fn the_last_frame_of_an_extended_xyz_file_is_the_start() {
    let frame = |x: f64, v: f64| {
        format!(
            "4\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3:velo:R:3\n\
             B {x} 0 0 {v} 0 0\nA 1 0 0 -{v} 0 0\nA 0 2 0 0 {v} 0\nA 0 3 0 0 -{v} 0\n"
        )
    };
    let soft = "potential.soft = { repulsion = 10.0, cutoff = 1.0 }";
    let folder = Folder::with(&format!(
        "[system]\nstart.extended_xyz = {{ path = \"drop.xyz\" }}\n[species.A]\n[species.B]\n\
         [pair.all]\n{soft}\n{STILL}"
    ));
    folder.write("drop.xyz", frame(0.0, 9.0) + &frame(0.4, 0.2));
    let results = folder.run_for_results("");
    close(value(&results, "temperature"), 4.0 * 0.04 / 9.0);
    // One pair is 0.6 apart, the other 1: ½ · 10 · 0.4².
    close(value(&results, "potential_energy"), 0.8);
}

#[test]
fn overlaps_at_the_start_are_refused_or_relaxed() {
    let xyz = "3\nLattice=\"6 0 0 0 6 0 0 0 6\" Properties=species:S:1:pos:R:3\nA 1 1 1\nA 1 1 1.2\nA 3 3 3\n";
    let folder = Folder::with(&format!(
        "[system]\nstart.extended_xyz = {{ path = \"drop.xyz\" }}\n\
         [pair.all]\npotential.wca = {{ epsilon = 1.0, sigma = 1.0 }}\n{STILL}"
    ));
    folder.write("drop.xyz", xyz);
    let refused = folder.mesoflux("run fluid.toml --quiet");
    assert_eq!(refused.status.code(), Some(2), "{}", error(&refused));
    let message = error(&refused);
    for part in ["particles 0 and 1 start 0.2", "must be at most 1000", "relax = true"] {
        assert!(message.contains(part), "{part} in {message}");
    }
    let results = folder.run_for_results("--set system.start.extended_xyz.relax=true");
    assert!(value(&results, "potential_energy") < 100.0);
    // Two particles in one place have no direction, and are parted all the same.
    folder.write("drop.xyz", xyz.replace("1 1 1.2", "1 1 1"));
    let results = folder.run_for_results("--force --set system.start.extended_xyz.relax=true");
    assert!(value(&results, "potential_energy") < 100.0);
}

#[test]
fn chains_made_by_the_input_run() {
    let input = format!(
        "[system]\ndensity = 3.0\n[species.bead]\n[species.water]\nparticles = 60\n\
         [bond.fene]\npotential.fene = {{ stiffness = 30.0, longest = 1.5 }}\n\
         [molecule.polymer]\ncount = 2\nblocks = [{{ species = \"bead\", beads = 10 }}]\nbond = \"fene\"\n\
         [pair.all]\npotential.soft = {{ repulsion = 25.0, cutoff = 1.0 }}\n{STILL}"
    );
    let folder = Folder::with(&input);
    let free = value(&folder.run_for_results(""), "potential_energy");
    let excluded = value(&folder.run_for_results("--force --set exclusions.potential_within=1"), "potential_energy");
    assert_eq!(folder.results("out")["input"]["species"]["bead"]["particles"], 20);
    // Bonded beads start where a bond likes to be; without their repulsion that is elsewhere.
    assert!((free - excluded).abs() > 1.0, "{free} and {excluded}");
}
