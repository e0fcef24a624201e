//! Structure and thermodynamics from the command line: g(r), the pressure from it, compressibility by two routes, speed of sound.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Folder, STRUCTURE, error, estimate, list, table, value};
use serde_json::Value;

/// Groot and Warren's fluid, long enough for numbers to be compared.
fn fluid(time: f64) -> String {
    FLUID
        .replace("particles = 64", "particles = 192")
        .replace("equilibration_time = 0.2", "equilibration_time = 4.0")
        .replace("production_time = 4.0", &format!("production_time = {time:?}"))
        .replace("sample_interval = 2", "sample_interval = 10")
}

#[test]
fn the_two_pressures_agree() {
    let measures = "
[measure.P]
quantity = \"pressure\"
routes.virial = {}
routes.radial_distribution = {}
";
    let results = Folder::with(&format!("{}{measures}", fluid(20.0))).run_for_results("");
    let (virial, (binned, standard_error)) =
        (value(&results, "P", "virial"), value(&results, "P", "radial_distribution"));
    println!("{virial:?} by the virial, {binned}({standard_error}) from g(r)");
    assert!((binned / virial.0 - 1.0).abs() < 1e-4, "{binned} against {virial:?}");
    assert!((standard_error / virial.1 - 1.0).abs() < 1e-2);
    assert!(results["comparisons"].as_array().unwrap().is_empty(), "both saw the same run");
}

#[test]
fn two_pressures_of_a_mixture_agree() {
    let mixture = fluid(10.0)
        .replace("particles = 192", "")
        .replace("[dynamics]", "[pair.A-B]\npotential.soft = { repulsion = 35.0, cutoff = 0.9 }\n[dynamics]");
    let species = "[species.A]\nparticles = 120\n[species.B]\nparticles = 72\n";
    let measures = "
[measure.P]
quantity = \"pressure\"
routes.virial = {}
routes.radial_distribution = {}

[measure.g]
quantity = \"radial_distribution\"
routes.histogram = { bins = 40 }
";
    let folder = Folder::with(&format!("{mixture}{species}{measures}"));
    let results = folder.run_for_results("");
    let (virial, binned) = (value(&results, "P", "virial").0, value(&results, "P", "radial_distribution").0);
    assert!((binned / virial - 1.0).abs() < 1e-4, "{binned} against {virial}");
    let (header, rows) = table(&folder, "g-histogram.csv");
    assert_eq!(header.iter().step_by(3).skip(1).collect::<Vec<_>>(), ["effective_samples [1]"; 4]);
    let names: Vec<&String> = header.iter().skip(1).step_by(3).collect();
    assert_eq!(names, ["g [1]", "g_A-A [1]", "g_A-B [1]", "g_B-B [1]"]);
    for row in rows {
        // All pairs are those of the three kinds.
        let pairs = [0.5 * 120.0 * 119.0, 120.0 * 72.0, 0.5 * 72.0 * 71.0];
        let sum: f64 = (0..3).map(|kind| pairs[kind] * row[4 + 3 * kind]).sum();
        assert!((sum / (0.5 * 192.0 * 191.0) - row[1]).abs() < 1e-10 * (1.0 + row[1]), "{row:?}");
    }
}

#[test]
fn the_distribution_has_the_structure_of_the_fluid() {
    let folder = Folder::with(&format!("{}[measure.g]\nquantity = \"radial_distribution\"\n", fluid(20.0)));
    let results = folder.run_for_results("");
    let (header, rows) = table(&folder, "g-histogram.csv");
    assert_eq!(header, ["distance [l]", "g [1]", "standard_error [1]", "effective_samples [1]"]);
    assert_eq!(rows.len(), 100);
    // To half the box, which is less than three cutoffs.
    let half = 0.5 * (192.0f64 / 3.0).cbrt();
    assert!((rows[99][0] - 0.995 * half).abs() < 1e-9, "{:?}", rows[99]);
    let highest = rows.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    let found = estimate(&results, "g", "histogram");
    assert!((found["value"].as_f64().unwrap() - highest[1]).abs() < 1e-9);
    assert_eq!(found["conditions"]["distance"].as_f64().unwrap(), highest[0]);
    // The soft repulsion: a first shell, 20 to 40 % above the mean, between 0.8 and 1 (Groot and Warren 1997), few pairs at
    // contact, little beyond.
    assert!((0.75..1.0).contains(&highest[0]) && (1.1..1.4).contains(&highest[1]), "{highest:?}");
    assert!(rows[4..10].iter().all(|row| row[1] < 0.5), "{:?}", &rows[4..10]);
    assert!(rows[95..].iter().all(|row| (row[1] - 1.0).abs() < 0.05 && row[2] < 0.02), "{:?}", &rows[95..]);
    // A bin without pairs isn't known to be empty.
    assert!(rows.iter().all(|row| row[2] > 0.0), "{:?}", rows[0]);
}

#[test]
fn the_compressibilities_of_an_ideal_fluid() {
    let measures = "
[measure.kappa]
quantity = \"isothermal_compressibility\"
routes.derivative = {}
routes.fluctuation = {}

[measure.c]
quantity = \"sound_speed\"
routes.derivative = {}
routes.fluctuation = {}
";
    let ideal = fluid(200.0).replace("potential.soft = { repulsion = 25.0, cutoff = 1.0 }\n", "");
    let folder = Folder::with(&format!("{}{measures}", ideal.replace("[run]", "[species.fluid]\nmass = 4.0\n[run]")));
    let results = folder.run_for_results("");
    for (measurement, expected) in [("kappa", 1.0 / 3.0), ("c", 0.5)] {
        // κ_T = 1/(ρ kT), c_T = √(kT/m).
        let (found, standard_error) = value(&results, measurement, "fluctuation");
        println!("{measurement}: {found}({standard_error}) by fluctuation");
        assert!(((found - expected) / standard_error).abs() < 3.0 && standard_error < 0.2 * expected);
        let (found, standard_error) = value(&results, measurement, "derivative");
        println!("{measurement}: {found}({standard_error}) by derivative");
        assert!(((found - expected) / standard_error).abs() < 3.0 && standard_error < 0.2 * expected);
    }
    let kinds: Vec<&Value> =
        list(&results["runs"]).iter().filter(|run| run["route"] == "derivative").map(|run| &run["point"]).collect();
    assert_eq!(kinds.len(), 8, "two replicas at four densities, for both measurements together");
    let (_, rows) = table(&folder, "kappa-derivative.csv");
    assert_eq!(rows.len(), 4);
    for (row, factor) in rows.iter().zip([0.9, 0.95, 1.05, 1.1]) {
        assert!((row[0] / (3.0 * factor) - 1.0).abs() < 1e-9);
        assert!((row[1] / (row[0] * row[3]) - 1.0).abs() < 1e-6, "P = ρ kT at its own density: {row:?}");
    }
    let (_, rows) = table(&folder, "kappa-fluctuation.csv");
    assert_eq!(rows.iter().map(|row| row[3]).collect::<Vec<_>>(), [3.0, 6.0, 4.0, 3.0, 12.0, 12.0]);
    assert!(rows.iter().all(|row| ((row[1] - 1.0) / row[2]).abs() < 3.5), "{rows:?}");
    assert_eq!(list(&results["comparisons"]).len(), 2, "the two routes share no run");
}

#[test]
fn recorders_of_structure_go_on_to_the_same_bits() {
    let folder = Folder::with(&format!("{FLUID}{STRUCTURE}"));
    folder.run("--quiet --out short");
    let longer = folder.mesoflux("resume short --quiet --set run.production_time=7.0 --threads 3");
    assert_eq!((longer.status.code(), error(&longer)), (Some(0), ""));
    folder.run("--quiet --out long --threads 1 --set run.production_time=7.0");
    folder.assert_same_results("short", "long");
    folder.run("--quiet --out once");
    assert_ne!(folder.read("once/g-histogram.csv"), folder.read("long/g-histogram.csv"));
}

#[test]
fn a_start_from_a_file_is_compressed_with_its_box() {
    let folder = Folder::with(FLUID);
    folder.run("--quiet --out first");
    let state = folder.checkpoints("first")[0].clone();
    let start = format!("start.checkpoint = {{ path = {:?} }}", state.to_str().unwrap());
    let input = FLUID.replace("particles = 64\ndensity = 3.0", &start);
    let measure =
        "[measure.kappa]\nquantity = \"isothermal_compressibility\"\nroutes.derivative = { density_step = 0.1 }\n";
    folder.write("fluid.toml", format!("{input}{measure}"));
    folder.run_for_results("");
    let (_, rows) = table(&folder, "kappa-derivative.csv");
    assert!((rows[0][0] - 2.7).abs() < 1e-9 && (rows[1][0] - 3.3).abs() < 1e-9);
    assert!(rows[1][1] > rows[0][1] + 3.0, "the pressure rises with the density: {rows:?}");
}
