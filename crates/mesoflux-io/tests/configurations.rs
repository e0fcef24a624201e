//! Start configurations: every field of the good files, and every file under `configuration/bad` refused with its message.
//!
//! `NAME.expected` beside a bad file holds its message. After a message was changed on purpose, `MESOFLUX_UPDATE=1 cargo
//! test -p mesoflux-io --test configurations` writes the new ones: read them as a user would before you keep them.

#![allow(clippy::unwrap_used, reason = "a test")]

mod configuration;

use configuration::{assert_consistent, bare_name, files, folder, format_of, has_extension, parse};
use mesoflux_io::configuration::{Bond, Configuration, ConfigurationError, Format, Motion, Named};
use std::path::PathBuf;

/// Reads the good file of this name.
fn good(name: &str) -> Configuration {
    let path = folder("good").join(name);
    Configuration::read(&path, format_of(&path)).unwrap()
}

fn named(names: &[(&str, u64)]) -> Vec<Named> {
    names.iter().map(|(name, line)| Named { name: (*name).to_owned(), line: *line }).collect()
}

#[test]
fn extended_xyz_as_ovito_writes_it() {
    let expected = Configuration {
        sides: [8.0, 6.0, 5.0],
        species: named(&[("A", 3), ("B", 4)]),
        kinds: vec![0, 1, 0, 1],
        // Relative to the origin at (-4, -3, -2.5).
        positions: vec![[0.5, 0.75, 0.0], [8.5, 3.0, 2.6], [4.0, 3.0, 2.5], [7.999_999_999_999_999_6, 5.5, 2.375]],
        motion: Some(Motion::Velocities(vec![
            [0.1, -0.2, 0.3],
            [1e-3, 0.0, -0.300_000_000_000_000_04],
            [0.0; 3],
            [-1.5, 2.5, 3.5],
        ])),
        masses: vec![None, None],
        bonds: vec![],
        bond_kinds: vec![],
    };
    assert_eq!(good("ovito.xyz"), expected);
}

#[test]
fn extended_xyz_as_ase_writes_it() {
    let expected = Configuration {
        sides: [5.0; 3],
        species: named(&[("Ar", 3), ("Xe", 5)]),
        kinds: vec![0, 0, 1],
        positions: vec![[0.0; 3], [1.25, 2.5, 3.75], [4.999_999_99, 1e-8, 2.5]],
        motion: Some(Motion::Momenta(vec![[1.0, -2.0, 3.0], [0.0; 3], [-1.0, 2.0, -3.0]])),
        // The second argon differs by less than a part in 10⁹: the first one counts.
        masses: vec![Some(39.948), Some(131.293)],
        bonds: vec![],
        bond_kinds: vec![],
    };
    assert_eq!(good("ase.xyz"), expected);
}

#[test]
fn of_several_frames_the_last_one_counts_and_columns_come_in_any_order() {
    let expected = Configuration {
        sides: [4.0, 5.5, 6.0],
        species: named(&[("water", 7)]),
        kinds: vec![0, 0],
        positions: vec![[0.5, 1.5, 2.5], [-0.5, 7.5, 2.5]],
        motion: None,
        masses: vec![Some(2.0)],
        bonds: vec![],
        bond_kinds: vec![],
    };
    assert_eq!(good("frames.xyz"), expected);
}

#[test]
fn species_of_extended_xyz_may_be_numbers_and_columns_the_usual_ones() {
    let numbered = good("numbered.xyz");
    assert_eq!(numbered.species, named(&[("7", 3), ("2", 4)]));
    assert_eq!(numbered.kinds, [0, 1, 0]);
    let usual = good("usual_columns.xyz");
    assert_eq!((usual.sides, usual.species), ([0.001, 1000.0, 0.5], named(&[("H", 3)])));
    assert_eq!((usual.positions, usual.masses), (vec![[0.1, 0.2, -0.3]], vec![None]));
}

#[test]
fn lammps_data_as_write_data_writes_it() {
    let expected = Configuration {
        sides: [8.0, 6.0, 5.0],
        species: named(&[("1", 14), ("2", 15)]),
        kinds: vec![0, 1, 0, 0, 0, 1],
        positions: vec![
            [0.5, 0.75, 0.1],
            [1.0, 0.75, 0.300_000_000_000_000_04],
            [1.5, 0.75, 0.5],
            [7.999_999_999_999_999_6, 2.9, 4.75],
            [4.0, 3.0, 0.0],
            [4.001, 5.5, 2.5],
        ],
        motion: Some(Motion::Velocities(vec![
            [0.1, -1.0, 1e-9],
            [0.2, 0.0, 0.0],
            [0.3, 0.0, 0.0],
            [0.4, 0.0, 0.0],
            [0.5, 0.0, 0.123_456_789_012_345_68],
            [0.6, 0.0, 0.0],
        ])),
        masses: vec![Some(1.0), Some(2.5)],
        bonds: vec![
            Bond { kind: 0, first: 0, second: 1 },
            Bond { kind: 0, first: 2, second: 1 },
            Bond { kind: 1, first: 3, second: 4 },
            Bond { kind: 0, first: 4, second: 5 },
        ],
        bond_kinds: named(&[("1", 47), ("2", 49)]),
    };
    assert_eq!(good("write_data_bond.data"), expected);
}

#[test]
fn lammps_data_with_labels_and_gaps_between_ids() {
    let expected = Configuration {
        sides: [10.0, 10.0, 10.5],
        species: named(&[("head", 32), ("tail", 33), ("W", 34)]),
        kinds: vec![0, 1, 1],
        positions: vec![[4.0, 5.0, 6.5], [7.0, 8.0, 9.5], [1.0, 2.0, 3.5]],
        motion: None,
        masses: vec![Some(1.5), Some(3.0), Some(1.0)],
        bonds: vec![Bond { kind: 0, first: 0, second: 2 }],
        bond_kinds: named(&[("head-tail", 22)]),
    };
    assert_eq!(good("labels_full.data"), expected);
}

#[test]
fn lammps_data_without_masses_knows_where_types_come_from() {
    let atomic = good("atomic.data");
    // The first type has no particle: what remains is the header.
    assert_eq!(atomic.species, named(&[("1", 3), ("2", 9), ("3", 8)]));
    assert_eq!((atomic.kinds, atomic.masses), (vec![2, 1], vec![None; 3]));
    assert_eq!((atomic.motion, atomic.bonds, atomic.bond_kinds), (None, vec![], vec![]));
}

#[test]
fn lammps_data_of_every_style() {
    assert_eq!(good("dpd.data").positions, [[1.5; 3], [0.5; 3]]);
    assert_eq!(good("charge.data").positions, [[0.5; 3]]);
    let head = "\n1 atoms\n1 atom types\n0 2 xlo xhi\n0 2 ylo yhi\n0 2 zlo zhi\nAtoms";
    let lines = [
        ("atomic", "1 1 .5 .5 .5"),
        ("bond", "1 7 1 .5 .5 .5"),
        ("angle", "1 7 1 .5 .5 .5"),
        ("molecular", "1 7 1 .5 .5 .5"),
        ("charge", "1 1 0 .5 .5 .5"),
        ("dpd", "1 1 7 .5 .5 .5"),
        ("full", "1 7 1 0 .5 .5 .5"),
    ];
    for (style, line) in lines {
        for flags in ["", " -1 0 1"] {
            let text = format!("{head} # {style}\n\n{line}{flags}\n");
            let configuration = parse(Format::LammpsData, style, text.as_bytes()).unwrap();
            assert_eq!((configuration.kinds, configuration.positions), (vec![0], vec![[0.5; 3]]), "{style}{flags}");
        }
    }
}

#[test]
fn good_configurations_are_consistent_and_the_same_with_the_line_ends_of_windows() {
    let paths = files("good");
    assert!(paths.len() >= 8);
    for path in paths {
        let text = std::fs::read(&path).unwrap();
        let configuration = parse(format_of(&path), "good", &text).unwrap();
        assert_consistent(&configuration);
        let windows = String::from_utf8(text).unwrap().replace('\n', "\r\n");
        let windows = format!("\u{feff}{windows}");
        assert_eq!(
            parse(format_of(&path), "windows", windows.as_bytes()).unwrap(),
            configuration,
            "{}",
            path.display()
        );
    }
}

#[test]
fn numbers_come_back_to_the_bit() {
    // Every 52nd exponent with digits that no short decimal has.
    let numbers: Vec<f64> = (0..40).map(|k: u64| f64::from_bits(k << 56 | 0x5555_1234_5678_9ABC_u64 >> k)).collect();
    assert!(numbers.iter().all(|number| number.is_finite()));
    let lattice = "Lattice=\"1 0 0 0 1 0 0 0 1\"";
    let mut text = format!("{}\n{lattice}\n", numbers.len());
    let mut data =
        format!("\n{} atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # atomic\n\n", numbers.len());
    for (place, number) in numbers.iter().enumerate() {
        text += &format!("A {number:e} {number:?} -{number:.17e}\n");
        data += &format!("{} 1 {number:e} {number:?} -{number:.17e}\n", place + 1);
    }
    for (format, text) in [(Format::ExtendedXyz, text), (Format::LammpsData, data)] {
        let read = parse(format, "numbers", text.as_bytes()).unwrap();
        for (position, number) in read.positions.iter().zip(&numbers) {
            assert_eq!(position.map(f64::to_bits), [*number, *number, -number].map(f64::to_bits), "{number:e}");
        }
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let path = folder("good").join("nowhere.xyz");
    let error = Configuration::read(&path, Format::ExtendedXyz).unwrap_err();
    assert!(matches!(error, ConfigurationError::Read { .. }));
    assert!(error.to_string().starts_with(&format!("{}: ", path.display())), "{error}");
}

#[test]
fn many_lines_take_little_time() {
    let count = 200_000;
    let mut text =
        format!("\n{count} atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # atomic\n\n");
    for line in 0..count {
        // Ids backward and with gaps, so that they are sorted and searched.
        text += &format!("{} 1 0.25 0.5 0.75\n", 3 * (count - line));
    }
    text += "\nVelocities\n\n";
    for line in 0..count {
        text += &format!("{} 1.5 -2.5 3.5\n", 3 * (line + 1));
    }
    let start = std::time::Instant::now();
    assert_eq!(parse(Format::LammpsData, "many", text.as_bytes()).unwrap().kinds.len(), count);
    assert!(start.elapsed().as_secs() < 2, "{:?}", start.elapsed());
}

/// The file that holds the message for a bad one.
fn expected_path(path: &std::path::Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".expected");
    PathBuf::from(name)
}

#[test]
fn every_bad_configuration_is_refused_with_its_message() {
    let update = std::env::var_os("MESOFLUX_UPDATE").is_some();
    let paths = files("bad");
    let mut wrong = Vec::new();
    for path in &paths {
        let (name, text) = (bare_name(path), std::fs::read(path).unwrap());
        let found = match parse(format_of(path), name, &text) {
            Err(error) => error.to_string(),
            Ok(_) => "the configuration is accepted".to_owned(),
        };
        if update {
            std::fs::write(expected_path(path), format!("{found}\n")).unwrap();
        }
        let expected = std::fs::read_to_string(expected_path(path)).unwrap_or_default();
        if expected.trim_end() != found || !found.starts_with(&format!("{name}: line ")) || !found.contains("must ") {
            wrong.push(format!("{name}\nexpected: {expected}\nfound: {found}\n"));
        }
    }
    assert!(wrong.is_empty(), "{} of {} messages differ:\n{}", wrong.len(), paths.len(), wrong.join("\n"));
    assert!(paths.len() >= 100, "only {} bad configurations were found", paths.len());
    // No message is left of a file that is gone.
    let messages = std::fs::read_dir(folder("bad")).unwrap().map(|entry| entry.unwrap().path());
    assert_eq!(messages.filter(|path| has_extension(path, "expected")).count(), paths.len());
}
