//! The files under `tests/input/good`: what follows from them, that their defaults are said back in full, that they cover
//! every key there is.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{bare_name, directory, input_files};
use mesoflux_io::input::{Files, Input, InputFile};
use std::collections::BTreeMap;
use std::path::Path;

fn read(name: &str) -> InputFile {
    let paths = input_files("good");
    let path = paths.iter().find(|path| bare_name(path) == name).unwrap();
    InputFile::read(path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 1e-12 * expected.abs()
}

/// What must follow from an input.
struct Derived {
    particles: u64,
    counts: &'static [usize],
    masses: &'static [f64],
    sides: [f64; 3],
    density: f64,
    cutoff: f64,
    skin: f64,
    word: Option<&'static str>,
}

/// A fluid of particles of mass 1 whose largest cutoff is 1, with the skin that follows from time steps of 0.01 or more.
fn soft(particles: u64, counts: &'static [usize], sides: [f64; 3]) -> Derived {
    let density = particles as f64 / sides.iter().product::<f64>();
    Derived { particles, counts, masses: &[1.0], sides, density, cutoff: 1.0, skin: 0.3, word: Some("ABOBA") }
}

#[test]
fn what_an_input_leaves_open_follows_from_the_rest() {
    let cube = |volume: f64| [volume.cbrt(); 3];
    let one = Derived {
        particles: 500,
        counts: &[500],
        masses: &[1.0],
        sides: cube(500.0 / 0.85),
        density: 0.85,
        cutoff: 2.5,
        skin: 0.25,
        word: Some("ABOBA"),
    };
    let expected = [
        // 40 steps of a thermal particle are 1.6, more than three tenths of the cutoff.
        (
            "smallest.toml",
            Derived { particles: 216, counts: &[216], sides: cube(72.0), density: 3.0, cutoff: 1.0, skin: 0.3, ..one },
        ),
        (
            "liquid.toml",
            Derived { masses: &[2.0], sides: [8.0, 9.0, 8.5], density: 500.0 / 612.0, word: Some("OBABO"), ..one },
        ),
        // The species in the order of their names; the largest cutoff is that of the mixed pair; short steps
        // make the skin thin.
        (
            "mixture.toml",
            Derived {
                counts: &[100, 400],
                masses: &[8.0, 1.0],
                sides: cube(625.0),
                density: 0.8,
                cutoff: 3.0,
                skin: (0.14f64 * 9.0 * (0.002 * 0.5f64.sqrt()) * 3.0).sqrt(),
                ..one
            },
        ),
        (
            "velocity_verlet.toml",
            Derived {
                particles: 192,
                counts: &[192],
                sides: [4.0; 3],
                density: 3.0,
                cutoff: 1.0,
                skin: 0.3,
                word: None,
                ..one
            },
        ),
        (
            "non_newtonian.toml",
            Derived {
                particles: 600,
                counts: &[300, 200, 100],
                masses: &[1.0, 2.0, 1.0],
                sides: cube(37.5),
                density: 16.0,
                cutoff: 1.0,
                skin: (0.14f64 * 9.0 * 0.001 * 0.1f64.sqrt()).sqrt(),
                word: None,
            },
        ),
        ("constant_energy.toml", Derived { skin: (0.14f64 * 9.0 * 0.002 * 2.5).sqrt(), word: Some("BAB"), ..one }),
        ("langevin.toml", Derived { sides: cube(500.0 / 0.6), density: 0.6, word: Some("BAOAB"), ..one }),
        ("polymer.toml", Derived { counts: &[30, 70, 500], masses: &[1.0, 1.5, 1.0], ..soft(600, &[], cube(200.0)) }),
        ("from_lammps_data.toml", Derived { masses: &[2.5, 1.0], ..soft(66, &[6, 60], [4.0; 3]) }),
        ("from_extended_xyz.toml", soft(100, &[100], [3.2; 3])),
        ("molecules_in_file.toml", soft(100, &[100], [3.2; 3])),
        ("correlations.toml", soft(192, &[192], [4.0; 3])),
        ("structure.toml", soft(192, &[192], [4.0; 3])),
        ("expressions.toml", Derived { masses: &[1.0, 1.0], ..soft(500, &[100, 400], [4.0, 5.0, 8.5]) }),
        ("sweep.toml", Derived { sides: cube(500.0 / 3.0), density: 3.0, cutoff: 1.0, skin: 0.3, ..one }),
    ];
    assert_eq!(expected.len(), input_files("good").len(), "every good input has its derived values here");
    for (name, derived) in expected {
        let input = read(name).input;
        let full = input.with_defaults();
        assert_eq!(input.particles(), derived.particles, "{name}");
        assert_eq!(input.species_counts(), derived.counts, "{name}");
        assert_eq!(input.masses(), derived.masses, "{name}");
        assert!((0..3).all(|axis| close(input.sides()[axis], derived.sides[axis])), "{name}: {:?}", input.sides());
        assert_eq!(input.interactions().cutoff(), derived.cutoff, "{name}");
        assert!(close(input.skin(), derived.skin), "{name}: skin {}", input.skin());
        if input.sweep.is_empty() {
            assert_eq!(full.system.particles, Some(derived.particles), "{name}");
            assert_eq!(full.system.sides, Some(input.sides()), "{name}");
            assert!(close(full.system.density.unwrap(), derived.density), "{name}");
            assert_eq!(full.run.skin, Some(input.skin()), "{name}");
        } else {
            assert_eq!((&full.system, full.run.skin), (&input.system, None), "{name}: its points decide these");
        }
        assert_eq!(full.dynamics.word.as_deref(), derived.word, "{name}");
    }
}

#[test]
fn the_examples_are_good_inputs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(paths.len() >= 4, "{paths:?}");
    for path in paths {
        InputFile::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn defaults_are_the_documented_ones() {
    let input = read("smallest.toml").input;
    let [seed, replicas, interval] = [input.run.seed, input.run.replicas, input.run.sample_interval];
    assert_eq!([seed, replicas, interval], [1, 1, 10]);
    let full = serde_json::to_value(input.with_defaults()).unwrap();
    assert_eq!(full["species"], serde_json::json!({ "fluid": { "mass": 1.0, "particles": 216 } }));
    assert_eq!(full["system"]["start"], "cubic_lattice");
    assert_eq!(full["pair"]["all"]["friction"]["linear"]["exponent"], 2.0);
    assert_eq!(full["dynamics"]["thermostat"], "pair_ornstein_uhlenbeck");
    assert_eq!(full["dynamics"]["sweep"], "alternating");
    let measured = serde_json::to_value(read("mixture.toml").input.with_defaults().measure).unwrap();
    assert_eq!(measured["pressure"]["routes"], serde_json::json!({ "virial": {} }));
    assert_eq!(measured["D"]["routes"], serde_json::json!({ "msd": { "longest_lag": 0.05 } }));
    let liquid = serde_json::to_value(read("liquid.toml").input.with_defaults().measure).unwrap();
    assert_eq!(liquid["mobility"]["routes"]["nemd"]["magnitude"], serde_json::json!([2.0, 4.0]));
}

#[test]
fn steps_are_the_nearest_number_of_time_steps() {
    let input = read("liquid.toml").input;
    assert_eq!([0.0, 0.0024, 0.0026, 1.0, 10.0].map(|time| input.steps(time)), [0, 0, 1, 200, 2000]);
}

#[test]
fn an_override_holds_in_both_orders_and_leaves_the_rest() {
    let laws = read("mixture.toml").input.interactions();
    let (large, small) = (0u8, 1u8);
    assert!(laws.potentials.get(small, small).as_ref().is_some_and(|law| law.cutoff() < 1.2), "that of all");
    assert_eq!(laws.potentials.get(small, large).as_ref().map(mesoflux_core::potential::Potential::cutoff), Some(3.0));
    assert_eq!(laws.potentials.get(large, small).as_ref().map(mesoflux_core::potential::Potential::cutoff), Some(3.0));
    assert!(laws.frictions.get(small, large).is_some(), "only the potential was overridden");
    assert!(laws.potentials.get(large, large).is_none() && laws.frictions.get(large, large).is_none());
}

/// The input of an input with its defaults, written out and read again.
fn said_back(input: &Input) -> InputFile {
    let text = toml::to_string(&input.with_defaults()).unwrap();
    InputFile::parse("said back", &text, &[], Files::beside(&directory("good")))
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn an_input_with_its_defaults_is_an_input_with_the_same_defaults() {
    for path in input_files("good") {
        let file = InputFile::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let again = said_back(&file.input);
        let (first, second) = (file.input.with_defaults(), again.input.with_defaults());
        assert_eq!(first, second, "{}", bare_name(&path));
        assert_eq!(file.sweep, again.sweep, "{}", bare_name(&path));
    }
}

#[test]
fn a_sweep_gives_every_combination_with_the_last_key_fastest() {
    let file = read("sweep.toml");
    let coefficient = "pair.all.friction.linear.coefficient";
    let mut expected = Vec::new();
    for word in ["ABOBA", "OBABO"] {
        for friction in [0.5, 4.5, 40.5] {
            expected.push((word.to_owned(), friction));
        }
    }
    let mut found = Vec::new();
    for point in &file.sweep.points {
        let input = file.at(point).unwrap();
        let laws = serde_json::to_value(&input.pair["all"]).unwrap();
        let friction = laws["friction"]["linear"]["coefficient"].as_f64().unwrap();
        assert_eq!(point.values[coefficient].as_float(), Some(friction));
        assert!(input.sweep.is_empty(), "a point is not swept again");
        found.push((input.dynamics.word().to_owned(), friction));
    }
    assert_eq!(found, expected);
}

/// The tables whose keys are names of the user's choice.
const NAMED: [&str; 6] = ["species", "pair", "measure", "bond", "molecule", "field"];

/// The keys of every table, as paths in which names of the user's choice are `*`.
fn tables(prefix: &str, table: &toml::Table, found: &mut BTreeMap<String, Vec<String>>) {
    found.entry(prefix.to_owned()).or_default().extend(table.keys().cloned());
    for (key, value) in table {
        let named = NAMED.contains(&prefix);
        let key = if named { "*" } else { key };
        let path = if prefix.is_empty() { key.to_owned() } else { format!("{prefix}.{key}") };
        if let Some(inner) = value.as_table().filter(|_| path != "sweep") {
            tables(&path, inner, found);
        }
    }
}

#[test]
fn the_good_inputs_cover_every_key() {
    let mut given = BTreeMap::new();
    let mut known: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in input_files("good") {
        let text = std::fs::read_to_string(&path).unwrap();
        let table: toml::Table = text.parse().unwrap();
        tables("", &table, &mut given);
        let mut concrete = Vec::new();
        probes("", &table, &mut concrete);
        for place in concrete {
            // The answer to a key that can't be names those that can.
            let setting = format!("{place}no_such_key=1").parse().unwrap();
            let message = InputFile::parse("probe", &text, &[setting], Files::beside(&directory("good")))
                .unwrap_err()
                .to_string();
            let title = message.lines().next().unwrap_or_default();
            let names = title.split("must be").nth(1).unwrap_or_default();
            let mut table: Vec<&str> = place.split_terminator('.').collect();
            if table.len() > 1 && NAMED.contains(&table[0]) {
                table[1] = "*";
            }
            known.entry(table.join(".")).or_default().extend(names.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    assert!(known.values().map(Vec::len).sum::<usize>() > 30, "the probes no longer find the known keys");
    for (table, keys) in known {
        for key in keys {
            assert!(given[&table].contains(&key), "no good input gives `{key}` in `{table}`");
        }
    }
}

/// The tables of an input to which a key could be added, each with a dot at its end.
fn probes(prefix: &str, table: &toml::Table, found: &mut Vec<String>) {
    let named = prefix.strip_suffix('.').is_some_and(|name| NAMED.contains(&name));
    let translation = prefix.starts_with("system.start.") && prefix.matches('.').count() == 4;
    let open = named || translation || prefix == "sweep." || prefix.ends_with("parameters.");
    // A law is chosen by its only key.
    let choice =
        ["potential.", "friction.", "thermostat.", "start.", "forcing."].iter().any(|end| prefix.ends_with(end));
    if !open && !choice {
        found.push(prefix.to_owned());
    }
    for (key, value) in table {
        if let Some(inner) = value.as_table() {
            probes(&format!("{prefix}{key}."), inner, found);
        }
    }
}
