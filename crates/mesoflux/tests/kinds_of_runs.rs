//! Every kind of run that an input can describe: mixtures, velocity Verlet, constant energy, an ideal fluid, all starts.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, list};
use serde_json::Value;

const TEMPERATURE: &str = "\n[measure.T]\nquantity = \"temperature\"\n";

const SOFT: &str = "potential.soft = { repulsion = 25.0, cutoff = 1.0 }\n";

/// The kinetic temperature of a run must be about 1.
fn warm(results: &Value) {
    for run in list(&results["runs"]) {
        let temperature = run["temperature"].as_f64().unwrap();
        assert!((0.8..1.2).contains(&temperature), "{run}");
    }
    assert_eq!(results["complete"], true);
}

#[test]
fn a_mixture_of_two_species() {
    let species =
        "[species.A]\nparticles = 40\n\n[species.B]\nparticles = 24\nmass = 2.0\n\n[pair.A-B]\nfriction = \"none\"\n\n";
    let input = FLUID.replace("particles = 64\n", "").replace("[pair.all]", &format!("{species}[pair.all]"));
    let input = input.replace("equilibration_time = 0.2", "equilibration_time = 5.0");
    let results = Folder::with(&format!("{input}{TEMPERATURE}")).run_for_results("");
    warm(&results);
    assert_eq!(results["input"]["system"]["particles"], 64);
    assert_eq!(results["input"]["pair"]["A-B"]["friction"], "none");
    assert!(results["input"]["pair"]["A-B"].get("potential").is_none(), "what all says stays in force");
}

#[test]
fn velocity_verlet() {
    let input = FLUID.replace("time_step = 0.02", "time_step = 0.02\nvelocity_verlet = { lambda = 0.65 }");
    let results = Folder::with(&format!("{input}{TEMPERATURE}")).run_for_results("");
    warm(&results);
    assert_eq!(results["input"]["dynamics"]["velocity_verlet"]["lambda"], 0.65);
    assert!(results["input"]["dynamics"].get("word").is_none());
}

#[test]
fn constant_energy() {
    let input = FLUID
        .replace("time_step = 0.02", "time_step = 0.005\nword = \"BAB\"\nthermostat = \"none\"")
        .replace("friction.linear = { coefficient = 4.5, cutoff = 1.0 }\n", "");
    let measures = "\n[measure.T]\nquantity = \"temperature\"\n\n[measure.U]\nquantity = \"potential_energy\"\n";
    let folder = Folder::with(&format!("{input}{measures}").replace("replicas = 2", "replicas = 1"));
    // One sample a run: the state after one step, and that after many, have the same energy.
    let energy = |arguments: &str| {
        let results = folder.run_for_results(&format!("--force --set run.equilibration_time={arguments}"));
        let value = |index: usize| list(&results["estimates"])[index]["value"].as_f64().unwrap();
        1.5 * 63.0 * value(0) + value(1)
    };
    let (early, late) = (energy("0.1"), energy("8.0"));
    assert!((early / late - 1.0).abs() < 2e-3, "{early} and {late}");
}

#[test]
fn an_ideal_fluid_without_a_potential() {
    let measures = "\n[measure.P]\nquantity = \"pressure\"\n\n[measure.T]\nquantity = \"temperature\"\n";
    let results = Folder::with(&format!("{}{measures}", FLUID.replace(SOFT, ""))).run_for_results("");
    warm(&results);
    let value = |index: usize| list(&results["estimates"])[index]["value"].as_f64().unwrap();
    assert!((value(0) / (3.0 * value(1)) - 1.0).abs() < 1e-10, "P = ρ kT: {} and {}", value(0), value(1));
}

#[test]
fn every_start_and_sweep_order() {
    // A random start of soft particles is hot until the thermostat has taken away what their overlaps set free.
    let folder = Folder::with(&FLUID.replace("equilibration_time = 0.2", "equilibration_time = 5.0"));
    for start in ["cubic_lattice", "fcc_lattice", "random"] {
        for order in ["alternating", "forward"] {
            let settings = format!("--force --set system.start={start} --set dynamics.sweep={order}");
            warm(&folder.run_for_results(&settings));
        }
    }
}

#[test]
fn overlapping_cores_of_a_random_start_are_relaxed() {
    let input = FLUID
        .replace(SOFT, "potential.wca = { epsilon = 1.0, sigma = 1.0 }\n")
        .replace("density = 3.0", "density = 0.6\nstart = \"random\"")
        .replace("coefficient = 4.5, cutoff = 1.0", "coefficient = 4.5, cutoff = 1.5")
        .replace("time_step = 0.02", "time_step = 0.002")
        .replace("equilibration_time = 0.2", "equilibration_time = 2.0");
    warm(&Folder::with(&input).run_for_results(""));
}

#[test]
fn an_odd_number_of_particles_and_a_box_that_is_no_cube() {
    let input = FLUID.replace("particles = 64\ndensity = 3.0", "particles = 71\nbox = [2.7, 3.1, 2.9]");
    let forced = "\n[measure.mobility]\nquantity = \"mobility\"\nforcing = \"two_particle_drift\"\nroutes.norton = { flux = 0.5 }\n";
    warm(&Folder::with(&format!("{input}{forced}")).run_for_results(""));
}
