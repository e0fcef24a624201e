//! What the tests of the command line share: a folder of their own, tiny inputs, the program, its results.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a test")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
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
routes.nemd = { magnitude = [4.0, 8.0] }
routes.norton = { flux = 2.0, check_forcing_observable = true }

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
        let mut command = Command::new(env!("CARGO_BIN_EXE_mesoflux"));
        command.args(arguments.split_whitespace()).current_dir(self.path()).env("COLUMNS", "100");
        command.output().unwrap()
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
