//! The files of results: each part in a file of its own, replaced only when that part was run again.

use crate::agreement::Agreement;
use crate::comparison::Comparison;
use crate::failure::Failure;
use crate::kernels::Kernels;
use crate::machine::Machine;
use crate::ours::Ours;
use crate::report;
use crate::scale::Scale;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Everything that was ever measured, as far as it was not measured again.
#[derive(Debug, Default)]
pub struct Results {
    /// `machine.json`: the machine of the last run.
    pub machine: Machine,
    /// `results.json`.
    pub comparisons: Vec<Comparison>,
    /// `agreement.json`.
    pub agreements: Vec<Agreement>,
    /// `scale.json`.
    pub scale: Option<Scale>,
    /// `kernels.json`.
    pub kernels: Option<Kernels>,
    /// `ours.json`.
    pub ours: Option<Ours>,
}

impl Results {
    /// What lies in a directory.
    pub fn read(directory: &Path) -> Result<Self, Failure> {
        Ok(Self {
            machine: read(directory, "machine.json")?,
            comparisons: read(directory, "results.json")?,
            agreements: read(directory, "agreement.json")?,
            scale: read(directory, "scale.json")?,
            kernels: read(directory, "kernels.json")?,
            ours: read(directory, "ours.json")?,
        })
    }

    /// Writes everything, and the page rendered from it.
    pub fn write(&self, directory: &Path) -> Result<(), Failure> {
        std::fs::create_dir_all(directory).map_err(|error| Failure::file(directory, error))?;
        write(directory, "machine.json", &self.machine)?;
        write(directory, "results.json", &self.comparisons)?;
        write(directory, "agreement.json", &self.agreements)?;
        self.scale.iter().try_for_each(|scale| write(directory, "scale.json", scale))?;
        self.kernels.iter().try_for_each(|kernels| write(directory, "kernels.json", kernels))?;
        self.ours.iter().try_for_each(|ours| write(directory, "ours.json", ours))?;
        replace(&directory.join("RESULTS.md"), &report::render(self))
    }

    /// Takes in new comparisons in place of those of the same work, integrator and number of threads.
    pub fn compared(&mut self, new: Vec<Comparison>) {
        self.comparisons.retain(|old| !new.iter().any(|new| new.replaces(old)));
        self.comparisons.extend(new);
        let key = |row: &Comparison| (row.work.clone(), row.integrator != "velocity-verlet", row.threads);
        self.comparisons.sort_by_key(key);
    }

    /// Takes in new agreements in place of those of the same work.
    pub fn agreed(&mut self, new: Vec<Agreement>) {
        self.agreements.retain(|old| !new.iter().any(|new| new.work == old.work));
        self.agreements.extend(new);
        self.agreements.sort_by_key(|row| row.work.clone());
    }
}

/// A file's content; the default where there is no file.
fn read<T: DeserializeOwned + Default>(directory: &Path, name: &str) -> Result<T, Failure> {
    let path = directory.join(name);
    match std::fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|source| Failure::Content { path, source }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(T::default()),
        Err(error) => Err(Failure::file(&path, error)),
    }
}

fn write(directory: &Path, name: &str, content: &impl Serialize) -> Result<(), Failure> {
    let path = directory.join(name);
    match serde_json::to_string_pretty(content) {
        Ok(text) => replace(&path, &format!("{text}\n")),
        Err(source) => Err(Failure::Content { path, source }),
    }
}

/// Writes a file whole or not at all.
fn replace(path: &Path, text: &str) -> Result<(), Failure> {
    let unfinished: PathBuf = path.with_extension("unfinished");
    std::fs::write(&unfinished, text).map_err(|error| Failure::file(&unfinished, error))?;
    std::fs::rename(&unfinished, path).map_err(|error| Failure::file(path, error))
}
