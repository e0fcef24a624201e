//! Where results go, and what is printed: no run touches another's directory, `--json` and `--quiet` keep their word.

mod common;

use common::{FLUID, Folder, MEASURES, error, printed};

#[test]
fn the_default_directory_is_a_new_one_named_after_the_input() {
    let folder = Folder::with(FLUID);
    for expected in ["fluid", "fluid-2", "fluid-3"] {
        assert!(!folder.file(expected).exists());
        let output = folder.run("");
        assert!(folder.file(expected).join("results.json").is_file());
        let place = format!("results in {expected}");
        assert!(printed(&output).contains(&place), "no {place:?} in {}", printed(&output));
    }
    // Named after the file, not put beside it.
    std::fs::create_dir(folder.file("inputs")).unwrap();
    std::fs::copy(folder.file("fluid.toml"), folder.file("inputs/other.toml")).unwrap();
    assert!(folder.mesoflux("run inputs/other.toml").status.success());
    assert!(folder.file("other/results.json").is_file());
}

#[test]
fn an_explicit_directory_that_exists_needs_force() {
    let folder = Folder::with(FLUID);
    folder.run("--out a/b");
    let before = folder.read("a/b/results.json");
    let refused = folder.mesoflux("run fluid.toml --out a/b --seed 2");
    assert_eq!(refused.status.code(), Some(2));
    assert!(error(&refused).contains("a/b") && error(&refused).contains("--force"), "{}", error(&refused));
    assert_eq!(folder.read("a/b/results.json"), before);
    folder.run("--out a/b --seed 2 --force");
    assert_eq!(folder.results("a/b")["seed"], 2);
}

#[test]
fn json_prints_the_results_file_and_nothing_else() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    let output = folder.run("--json --out out");
    assert_eq!(printed(&output), folder.read("out/results.json"));
    assert_eq!(error(&output), "");
}

#[test]
fn quiet_prints_nothing() {
    let output = Folder::with(&format!("{FLUID}{MEASURES}")).run("--quiet");
    assert_eq!((printed(&output), error(&output)), ("", ""));
}

#[test]
fn the_table_shows_every_estimate() {
    let folder = Folder::with(&format!("{FLUID}{MEASURES}"));
    let output = folder.run("");
    let text = printed(&output);
    assert!(text.starts_with("A drop of a soft fluid\n\nmeasurement"), "{text}");
    for row in ["mobility  ", "T (temperature)", "P (pressure)", "U (potential_energy)", "D (diffusion_coefficient)"] {
        assert!(text.contains(row), "no {row:?} in\n{text}");
    }
    for method in ["msd", "nemd", "norton", "kinetic", "configurational", "virial", "direct"] {
        assert!(text.lines().any(|line| line.split_whitespace().any(|word| word == method)), "no {method} in\n{text}");
    }
    // Two digits of the error in parentheses.
    let kinetic = text.lines().find(|line| line.contains("kinetic")).unwrap();
    assert!(kinetic.contains('(') && kinetic.contains(") ") && kinetic.contains(" %"), "{kinetic}");
}
