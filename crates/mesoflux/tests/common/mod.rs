//! What the tests of the command line share: a folder of their own, tiny inputs, the program, its results.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a test")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A soft fluid that runs in a hundredth of a second, with nothing measured.
pub const FLUID: &str = r#"
title = "A drop of a soft fluid"

[system]
particles = 64
density = 3.0

[pair.all]
potential.soft = { repulsion = 25.0, cutoff = 1.0 }
friction.linear = { coefficient = 4.5, cutoff = 1.0 }

[dynamics]
temperature = 1.0
time_step = 0.02

[run]
replicas = 2
equilibration_time = 0.2
production_time = 4.0
sample_interval = 2
"#;

/// Every quantity and route.
pub const MEASURES: &str = r#"
[measure.mobility]
quantity = "mobility"
forcing = "color_drift"
routes.msd = { longest_lag = 1.0 }
routes.nemd = { magnitude = [4.0, 8.0], autocorrelation = {}, histogram = { range = [-3.0, 6.0] } }
routes.norton = { flux = 2.0, check_forcing_observable = true, histogram = { range = [-50.0, 50.0], bins = 10 } }

[measure.viscosity]
quantity = "shear_viscosity"
forcing = "sinusoidal"
routes.norton = { flux = [0.0, 0.3], autocorrelation = { longest_lag = 0.1 }, profile = { bins = 4 } }

[measure.T]
quantity = "temperature"

[measure.T_configurational]
quantity = "configurational_temperature"

[measure.P]
quantity = "pressure"

[measure.U]
quantity = "potential_energy"

[measure.D]
quantity = "diffusion_coefficient"
"#;

/// Momentum exchange, forced and by swaps.
pub const EXCHANGE: &str = r#"
[measure.viscosity_by_exchange]
quantity = "shear_viscosity"
routes.momentum_exchange = { stress = [0.5, 1.0], interval = 3, bins = 8 }

[measure.viscosity_by_swaps]
quantity = "shear_viscosity"
flow = "z"
gradient = "x"
routes.momentum_exchange = { kind = "swap", interval = 5, bins = 8 }
"#;

/// Every route to structure and thermodynamics.
pub const STRUCTURE: &str = r#"
[measure.g]
quantity = "radial_distribution"
routes.histogram = { bins = 20 }

[measure.P_g]
quantity = "pressure"
routes.radial_distribution = {}

[measure.kappa]
quantity = "isothermal_compressibility"
routes.derivative = { density_step = 0.05 }
routes.fluctuation = {}

[measure.c]
quantity = "sound_speed"
routes.derivative = { density_step = 0.05 }
routes.fluctuation = {}
"#;

/// Every route by a correlation in time, and what else is said of fluctuations.
pub const CORRELATIONS: &str = r#"
[measure.eta]
quantity = "shear_viscosity"
routes.green_kubo = { sample_interval = 3 }
routes.green_kubo_total_stress = { sample_interval = 3 }
routes.einstein_helfand = {}
routes.transverse_current = { wavenumbers = 1 }

[measure.zeta]
quantity = "bulk_viscosity"

[measure.D_by_velocities]
quantity = "diffusion_coefficient"
routes.vacf = {}

[measure.tau]
quantity = "correlation_time"
observable = "pressure"
routes.blocking = {}
routes.correlation = {}

[measure.spread]
quantity = "asymptotic_variance"
observable = "shear_stress"

[measure.p_of_T]
quantity = "probability_density"
observable = "temperature"
routes.counting = { range = [0.5, 1.5], bins = 20 }

[measure.speeds]
quantity = "speed_distribution"
routes.speed_histogram = { bins = 20, sample_interval = 4 }
"#;

/// The estimate of a measurement by a method.
pub fn estimate<'a>(results: &'a Value, measurement: &str, method: &str) -> &'a Value {
    let found = |estimate: &&Value| estimate["measurement"] == measurement && estimate["method"] == method;
    list(&results["estimates"]).iter().find(found).unwrap_or_else(|| panic!("no {measurement} by {method}"))
}

/// Its value and standard error.
pub fn value(results: &Value, measurement: &str, method: &str) -> (f64, f64) {
    let estimate = estimate(results, measurement, method);
    let number = |field: &str| estimate[field].as_f64().unwrap_or_else(|| panic!("{field} of {estimate}"));
    (number("value"), number("standard_error"))
}

/// The header and the rows of a table; what couldn't be told is not a number.
pub fn table(folder: &Folder, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = folder.read(&format!("out/{name}"));
    let mut lines = text.lines();
    let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let number = |field: &str| if field.is_empty() { f64::NAN } else { field.parse().unwrap() };
    (header, lines.map(|row| row.split(',').map(number).collect()).collect())
}

/// A folder in which the program runs.
pub struct Folder(TempDir);

impl Folder {
    /// A new folder with an input file `fluid.toml`.
    pub fn with(input: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("fluid.toml", input);
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        std::fs::write(self.file(name), contents).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Runs `mesoflux` with arguments separated by spaces.
    pub fn mesoflux(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Starts `mesoflux` with arguments separated by spaces, and doesn't wait for it.
    pub fn start(&self, arguments: &str) -> Child {
        self.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mesoflux"));
        command.args(arguments.split_whitespace()).current_dir(self.path()).env("COLUMNS", "100");
        command
    }

    /// Waits until a run into `directory` has kept a state.
    pub fn wait_for_state(&self, directory: &str) {
        wait_until("a checkpoint", || !self.checkpoints(directory).is_empty());
    }

    /// The checkpoints in a run's directory.
    pub fn checkpoints(&self, directory: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.file(directory).join("states")).into_iter().flatten();
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "checkpoint"));
        paths.retain(|path| !path.file_name().unwrap().to_str().unwrap().starts_with('.'));
        paths.sort();
        paths
    }

    /// Results, tables and figures in two directories must be the same to the bit, but for what the clock and the machine say.
    pub fn assert_same_results(&self, found: &str, expected: &str) {
        let (a, b) = (physics(self.results(found)), physics(self.results(expected)));
        assert_eq!(a, b, "{found} and {expected}");
        assert_eq!(a["complete"], true, "{found}");
        let mut compared = 0;
        for entry in std::fs::read_dir(self.file(expected)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "csv" || extension == "svg") {
                let name = path.file_name().unwrap().to_str().unwrap();
                assert_eq!(self.read(&format!("{found}/{name}")), self.read(&format!("{expected}/{name}")), "{name}");
                compared += 1;
            }
        }
        let tables = list(&b["estimates"]).iter().filter(|estimate| estimate.get("table").is_some()).count();
        assert!(compared >= tables, "{compared} of {tables} tables");
        for folder in [found.to_owned(), format!("{found}/states")] {
            for entry in std::fs::read_dir(self.file(&folder)).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                assert!(!name.starts_with('.'), "{folder}/{name} is left");
            }
        }
    }

    /// Copies a directory with everything in it.
    pub fn copy(&self, from: &str, to: &str) {
        let status = Command::new("cp").arg("-r").args([self.file(from), self.file(to)]).status().unwrap();
        assert!(status.success());
    }

    /// Runs `mesoflux run fluid.toml`, which must succeed.
    pub fn run(&self, arguments: &str) -> Output {
        let output = self.mesoflux(&format!("run fluid.toml {arguments}"));
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", error(&output));
        output
    }

    /// The results of a run into `directory`.
    pub fn results(&self, directory: &str) -> Value {
        serde_json::from_str(&self.read(&format!("{directory}/results.json"))).unwrap()
    }

    /// Runs into the directory `out` and reads the results.
    pub fn run_for_results(&self, arguments: &str) -> Value {
        self.run(&format!("--quiet --out out {arguments}"));
        self.results("out")
    }
}

/// The results without what the clock and the machine say, and without how the runs went.
pub fn physics(mut results: Value) -> Value {
    let fields = results.as_object_mut().unwrap();
    for circumstance in ["wall_seconds", "threads", "particle_steps_per_second"] {
        assert!(fields.remove(circumstance).is_some(), "{circumstance}");
    }
    for cadence in ["checkpoint_interval", "checkpoint_wall_seconds"] {
        fields["input"]["run"].as_object_mut().unwrap().remove(cadence);
    }
    for run in fields["runs"].as_array_mut().unwrap() {
        run.as_object_mut().unwrap().remove("remarks");
    }
    results
}

/// Waits for something that must come within half a minute.
pub fn wait_until(what: &str, condition: impl Fn() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(30), "{what} does not come");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Sends a signal to a process of one's own.
pub fn signal(child: &Child, name: &str) {
    let status = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(status.success(), "{name}");
}

/// SplitMix64: numbers that are the same at every run of a test.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Standard output.
pub fn printed(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

/// Standard error.
pub fn error(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

/// The elements of an array.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value} is no array"))
}
