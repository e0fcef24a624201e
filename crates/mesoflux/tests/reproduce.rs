//! Studies: runs kept by the hash of their input, series read from them, claims judged, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, error, list, printed, table};
use serde_json::Value;
use std::path::Path;

const STUDY: &str = r#"
title = "A tiny study"
source = "Nobody"

[quick.fluid]
run.production_time = 2.0

[item.figure-1]
title = "Mobility against friction"

[item.figure-1.series]
mobility.estimates = { input = "fluid", of = "mobility/nemd", x = "pair.all.friction.linear.coefficient" }
scaled.product = { of = "mobility", factor = 2.0, power = 1.0 }
over.ratio = { numerator = "scaled", denominator = "mobility" }
flux.table = { input = "fluid", of = "mobility-nemd.csv", x = "pair.all.friction.linear.coefficient", y = "flux", where = { magnitude = 8.0 } }
quotient.table = { input = "fluid", of = "mobility-nemd.csv", x = "magnitude", y = "flux", times = { magnitude = -1.0 }, where.pair.all.friction.linear.coefficient = 9.0 }
work.table = { input = "fluid", of = "mobility-nemd.csv", x = "flux", x_times = { magnitude = 2.0 }, y = "magnitude", where = { magnitude = 8.0 } }
printed.published = { x = [9.0, 4.5], y = [0.1, 0.2], y_error = [0.01, 0.02] }

[item.figure-1.panel.only]
x = { label = "friction", logarithmic = true }
y = { label = "mobility" }
[item.figure-1.panel.only.layer]
nemd.points = { series = "mobility", label = "NEMD" }
law.power_law = { exponent = -1.0, series = "mobility", at = 9.0, label = "inverse" }

[item.table-1]
title = "Temperatures"

[item.table-1.series]
temperature.estimates = { input = ["fluid", "warm"], of = "T/kinetic", x = "dynamics.temperature" }
"#;

const CLAIMS: &str = r#"
[claim.warm]
item = "table-1"
text = "the warm fluid has its temperature"
measured.value = { of = "temperature", at = 2.0 }
expected = 2.0
expected_error = 0.1
required_error = 1.0

[claim.twice]
item = "figure-1"
text = "the scaled series is larger"
measured.ratio = { numerator = "scaled", denominator = "mobility" }
above = 1.0
required_error = 1e9
"#;

const MEASURE: &str = r#"
[measure.mobility]
quantity = "mobility"
forcing = "color_drift"
routes.nemd = { magnitude = [4.0, 8.0] }

[measure.T]
quantity = "temperature"

[sweep]
pair.all.friction.linear.coefficient = [4.5, 9.0]
"#;

/// A folder with a study `mine`.
fn study() -> Folder {
    let folder = Folder::with(FLUID);
    std::fs::create_dir_all(folder.file("mine/inputs")).unwrap();
    folder.write("mine/study.toml", STUDY);
    folder.write("mine/claims.toml", CLAIMS);
    folder.write("mine/inputs/fluid.toml", format!("{FLUID}{MEASURE}"));
    let warm = FLUID.replace("temperature = 1.0", "temperature = 2.0");
    folder.write("mine/inputs/warm.toml", format!("{warm}[measure.T]\nquantity = \"temperature\"\n"));
    folder
}

/// Runs `mesoflux reproduce`, which must succeed, and gives what it said on standard error.
fn reproduce(folder: &Folder, arguments: &str) -> String {
    let output = folder.mesoflux(&format!("reproduce {arguments}"));
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", error(&output));
    error(&output).to_owned()
}

fn verdicts(folder: &Folder, directory: &str) -> Vec<Value> {
    let verdicts: Value = serde_json::from_str(&folder.read(&format!("{directory}/verdicts.json"))).unwrap();
    list(&verdicts).to_vec()
}

/// The directories of the runs of an input.
fn points(folder: &Folder, directory: &str, input: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.file(&format!("{directory}/points"))).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.starts_with(&format!("{input}-"))).collect();
    names.sort();
    names.into_iter().map(|name| format!("{directory}/points/{name}")).collect()
}

#[test]
fn finished_runs_are_kept() {
    let folder = study();
    let said = reproduce(&folder, "mine --out out");
    assert!(said.contains("figure-1: fluid: 12 runs begin") && said.contains("table-1: warm: 2 runs begin"), "{said}");
    assert_eq!(said.matches("fluid").count(), 1, "both items share the input: {said}");
    // The wall time in them would change.
    let results = format!("{}/results.json", points(&folder, "out", "fluid")[0]);
    let (before, first) = (folder.read(&results), folder.read("out/verdicts.json"));
    let said = reproduce(&folder, "mine --out out");
    assert!(said.contains("fluid: 12 runs are there") && said.contains("warm: 2 runs are there"), "{said}");
    assert_eq!((folder.read(&results), folder.read("out/verdicts.json")), (before, first));
}

#[test]
fn another_input_gets_another_directory() {
    let folder = study();
    reproduce(&folder, "mine/figure-1 --quick");
    let first = points(&folder, "mine-quick", "fluid");
    assert_eq!(folder.results(&first[0])["input"]["run"]["production_time"], 2.0);
    folder.write("mine/study.toml", STUDY.replace("production_time = 2.0", "production_time = 1.0"));
    reproduce(&folder, "mine/figure-1 --quick");
    let both = points(&folder, "mine-quick", "fluid");
    assert!(both.len() == 2 && both.contains(&first[0]), "{both:?}");
    // What says the same in other words is the same.
    folder.write("mine/study.toml", STUDY.replace("production_time = 2.0", "production_time = 1.0\nrun.seed = 1"));
    reproduce(&folder, "mine/figure-1 --quick");
    assert_eq!(points(&folder, "mine-quick", "fluid"), both);
}

#[cfg(unix)]
#[test]
fn a_study_that_was_interrupted_goes_on_to_the_same_bits() {
    let folder = study();
    let input = format!("{FLUID}{MEASURE}").replace("production_time = 4.0", "production_time = 100.0");
    let input = input.replace("replicas = 2", "replicas = 2\ncheckpoint_interval = 50");
    folder.write("mine/inputs/fluid.toml", input);
    reproduce(&folder, "mine --out undisturbed --threads 2");
    let child = folder.start("reproduce mine --out out --threads 1");
    let states = || points(&folder, "out", "fluid").iter().any(|point| !folder.checkpoints(point).is_empty());
    common::wait_until("a checkpoint", || folder.file("out/points").exists() && states());
    common::signal(&child, "INT");
    let stopped = child.wait_with_output().unwrap();
    assert_eq!(stopped.status.code(), Some(130), "{}", error(&stopped));
    assert!(error(&stopped).ends_with("stopped; to go on: mesoflux reproduce mine --out out\n"), "{}", error(&stopped));
    let point = &points(&folder, "out", "fluid")[0];
    assert_eq!(folder.results(point)["complete"], false);
    let said = reproduce(&folder, "mine --out out --threads 2");
    assert!(said.contains("fluid: 12 runs go on"), "{said}");
    for name in ["verdicts.json", "figure-1.svg", "figure-1/mobility.csv", "table-1/temperature.csv"] {
        assert_eq!(folder.read(&format!("out/{name}")), folder.read(&format!("undisturbed/{name}")), "{name}");
    }
    folder.assert_same_results(point, &points(&folder, "undisturbed", "fluid")[0]);
}

#[test]
fn out_of_time_nothing_is_lost() {
    let folder = study();
    reproduce(&folder, "mine/table-1 --out out");
    let output = folder.mesoflux("reproduce mine --quick --max-wall 0s");
    assert_eq!(output.status.code(), Some(130));
    assert!(error(&output).contains("stopped; to go on: mesoflux reproduce mine --quick\n"), "{}", error(&output));
    // Here the runs of the first item are there already.
    let output = folder.mesoflux("reproduce mine --out out --max-wall 0s");
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
}

#[test]
fn series_are_what_the_runs_say() {
    let folder = study();
    reproduce(&folder, "mine --out out");
    let results = folder.results(&points(&folder, "out", "fluid")[0]);
    let nemd: Vec<&Value> = list(&results["estimates"]).iter().filter(|record| record["method"] == "nemd").collect();
    let (header, mobility) = table(&folder, "figure-1/mobility.csv");
    assert_eq!(header, ["x", "x_error", "y", "y_error"]);
    assert_eq!(mobility.len(), 2);
    let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
    for ((row, record), friction) in mobility.iter().zip(&nemd).zip([4.5, 9.0]) {
        assert_eq!((row[0], row[1]), (friction, 0.0));
        close(row[2], record["value"].as_f64().unwrap());
        close(row[3], record["standard_error"].as_f64().unwrap());
    }
    let (_, scaled) = table(&folder, "figure-1/scaled.csv");
    let (_, over) = table(&folder, "figure-1/over.csv");
    for ((row, scaled), over) in mobility.iter().zip(&scaled).zip(&over) {
        close(scaled[2], 2.0 * row[0] * row[2]);
        close(scaled[3], 2.0 * row[0] * row[3]);
        close(over[2], 2.0 * row[0]);
    }
    // The second magnitude of each point of the sweep; and of the second point both magnitudes.
    let (_, flux) = table(&folder, "figure-1/flux.csv");
    let (_, quotient) = table(&folder, "figure-1/quotient.csv");
    assert_eq!((flux.len(), quotient.len()), (2, 2));
    let point = points(&folder, "out", "fluid")[0].clone();
    for (k, row) in flux.iter().enumerate() {
        let text = folder.read(&format!("{point}/mobility-nemd-{}.csv", k + 1));
        let numbers: Vec<f64> = text.lines().nth(2).unwrap().split(',').map(|number| number.parse().unwrap()).collect();
        assert_eq!(numbers[0], 8.0);
        assert_eq!((row[2], row[3]), (numbers[1], numbers[2]));
    }
    assert_eq!((quotient[0][0], quotient[1][0]), (4.0, 8.0));
    close(quotient[1][2], flux[1][2] / 8.0);
    close(quotient[1][3], flux[1][3] / 8.0);
    // x is a product, too, with the error of its factor.
    let (_, work) = table(&folder, "figure-1/work.csv");
    for row in &work {
        let flux = flux.iter().find(|flux| (64.0 * flux[2] / row[0] - 1.0).abs() < 1e-9).unwrap();
        close(row[1], 64.0 * flux[3]);
        assert_eq!((row[2], row[3]), (8.0, 0.0));
    }
    let (_, printed) = table(&folder, "figure-1/printed.csv");
    assert_eq!(printed, [[4.5, 0.0, 0.2, 0.02], [9.0, 0.0, 0.1, 0.01]]);
    let (_, temperature) = table(&folder, "table-1/temperature.csv");
    assert_eq!(temperature.iter().map(|row| row[0]).collect::<Vec<_>>(), [1.0, 1.0, 2.0]);
}

#[test]
fn verdicts_and_the_page() {
    let folder = study();
    let output = folder.mesoflux("reproduce mine --out out");
    let found = verdicts(&folder, "out");
    let said: Vec<_> =
        found.iter().map(|entry| (entry["item"].as_str().unwrap(), entry["claim"].as_str().unwrap())).collect();
    let expected = [("figure-1", "the scaled series is larger"), ("table-1", "the warm fluid has its temperature")];
    assert_eq!(said, expected);
    let warm = &found[1];
    let number = |field: &str| warm[field].as_f64().unwrap();
    let error = number("standard_error").hypot(0.1);
    assert!((number("z") - (number("measured") - 2.0) / error).abs() < 1e-12);
    assert_eq!(warm["verdict"], "holds", "{warm}");
    for part in ["A tiny study", "holds", "the warm fluid has its temperature", "verdicts in out"] {
        assert!(printed(&output).contains(part), "no {part} in\n{}", printed(&output));
    }
    let page = folder.read("out/README.md");
    for part in ["![Mobility against friction](figure-1.svg)", "| the warm fluid has its temperature | 2 |"] {
        assert!(page.contains(part), "no {part} in\n{page}");
    }
    assert!(folder.read("out/figure-1.svg").starts_with("<svg"));
    assert!(!folder.file("out/table-1.svg").exists());
    let output = folder.mesoflux("reproduce mine --out out --json --quiet");
    let json: Value = serde_json::from_str(printed(&output)).unwrap();
    assert_eq!(list(&json), found);
}

#[test]
fn one_item_leaves_the_verdicts_of_others() {
    let folder = study();
    reproduce(&folder, "mine/table-1 --out out");
    assert_eq!(verdicts(&folder, "out").len(), 1);
    assert!(points(&folder, "out", "fluid").len() == 1 && !folder.file("out/figure-1").exists());
    reproduce(&folder, "mine/figure-1 --out out");
    let both = verdicts(&folder, "out");
    assert_eq!(both.len(), 2);
    folder.write(
        "mine/claims.toml",
        CLAIMS.replace("expected = 2.0", "expected = 9.0").replace("above = 1.0", "above = 1e3"),
    );
    reproduce(&folder, "mine/table-1 --out out");
    let after = verdicts(&folder, "out");
    assert_eq!(after[0], both[0], "figure-1 was not asked for");
    assert_eq!(after[1]["verdict"], "fails");
}

fn refused(folder: &Folder, arguments: &str, code: i32, parts: &[&str]) {
    let output = folder.mesoflux(&format!("reproduce {arguments}"));
    assert_eq!(output.status.code(), Some(code), "{arguments}: {}", error(&output));
    for part in parts {
        assert!(error(&output).contains(part), "{arguments}: no {part:?} in\n{}", error(&output));
    }
}

#[test]
fn what_does_not_exist_is_refused_with_what_does() {
    let folder = study();
    refused(&folder, "wu-chang", 2, &["error: no study `wu-chang`; there are: ", "wu-shang"]);
    refused(&folder, "wu_shang", 2, &["no study `wu_shang`"]);
    refused(&folder, "wu-shang/figure-77", 2, &["error: wu-shang has no item `figure-77`; there are: figure-1, "]);
    refused(&folder, "mine/figure-2", 2, &["error: mine has no item `figure-2`; there are: figure-1, table-1"]);
    refused(&folder, "", 2, &[]);
    assert!(!folder.file("mine-quick").exists() && !folder.file("wu-shang").exists(), "nothing is made");
}

#[test]
fn a_directory_of_something_else_is_refused() {
    let folder = study();
    refused(&folder, "mine", 2, &["mine: holds something that is no study of mesoflux", "--out"]);
    reproduce(&folder, "mine/table-1 --out out");
    refused(&folder, "mine --quick --out out", 2, &["out: holds mine: must be new, empty, or hold mine --quick"]);
    folder.copy("mine", "other");
    refused(&folder, "other --out out", 2, &["out: holds mine: must be new, empty, or hold other"]);
    std::fs::create_dir(folder.file("empty")).unwrap();
    reproduce(&folder, "mine/table-1 --out empty");
}

#[test]
fn a_wrong_study_is_refused_before_anything_runs() {
    let folder = study();
    let cases: [(&str, &str, &str, &[&str]); 9] = [
        (
            "study.toml",
            "\"scaled\", denominator",
            "\"scale\", denominator",
            &["item.figure-1.series.over: no series `scale` before it"],
        ),
        ("study.toml", "label = \"NEMD\"", "lable = \"NEMD\"", &["mine, study.toml", "lable"]),
        (
            "study.toml",
            "{ series = \"mobility\", label",
            "{ series = \"mobile\", label",
            &["panel.only: no series `mobile`"],
        ),
        ("claims.toml", "item = \"figure-1\"", "item = \"figure-3\"", &["claim.twice: no item `figure-3`"]),
        ("claims.toml", "of = \"temperature\"", "of = \"heat\"", &["claim.warm: no series `heat` in table-1"]),
        ("claims.toml", "above = 1.0", "above = 1.0\nbelow = 2.0", &["claim.twice: must have exactly one of"]),
        (
            "claims.toml",
            "required_error = 1.0",
            "required_error = 0.0",
            &["claim.warm: `required_error` must be positive"],
        ),
        (
            "inputs/fluid.toml",
            "density = 3.0",
            "density = -3.0",
            &["system.density = -3.0: must be positive", "mine, inputs/fluid.toml"],
        ),
        ("study.toml", "run.production_time", "run.productive_time", &["unknown key", "productive_time"]),
    ];
    for (file, right, wrong, parts) in cases {
        let path = format!("mine/{file}");
        let text = folder.read(&path);
        assert!(text.contains(right), "{right}");
        folder.write(&path, text.replacen(right, wrong, 1));
        refused(&folder, "mine --quick --out out", 2, parts);
        folder.write(&path, text);
    }
    assert!(!folder.file("out").exists());
    std::fs::remove_file(folder.file("mine/inputs/warm.toml")).unwrap();
    refused(&folder, "mine --out out", 4, &["warm.toml: can't be read"]);
}

#[test]
fn what_the_runs_do_not_measure_is_refused() {
    let folder = study();
    folder.write("mine/study.toml", STUDY.replace("of = \"mobility/nemd\"", "of = \"mobility/norton\""));
    refused(
        &folder,
        "mine --out out",
        2,
        &["item.figure-1.series.mobility", "\"mobility/norton\": the input fluid measures no such thing"],
    );
    assert!(!folder.file("out").exists());
    folder.write("mine/study.toml", STUDY.replace("y = \"flux\", where", "y = \"fluxes\", where"));
    refused(&folder, "mine --out out", 2, &["series `flux`: there is no `fluxes` in mobility-nemd.csv"]);
}

#[test]
fn the_published_inputs_are_whole() {
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
    for study in std::fs::read_dir(studies).unwrap() {
        for name in ["study.toml", "claims.toml", "inputs"] {
            assert!(study.as_ref().unwrap().path().join(name).exists(), "{name}");
        }
    }
}
