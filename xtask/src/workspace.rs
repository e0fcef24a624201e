//! Where the workspace lies, and how cargo is called in it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::failure::Failure;

/// The checkout that the tasks work on.
#[derive(Debug)]
pub struct Workspace {
    /// The directory of the workspace's `Cargo.toml`.
    pub root: PathBuf,
    /// Where cargo builds: `CARGO_TARGET_DIR`, or `target` in the root.
    pub target: PathBuf,
}

impl Workspace {
    /// The workspace around this crate, as cargo says at run time; without cargo, around the current directory.
    pub fn find() -> Result<Self, Failure> {
        let here = env::current_dir().map_err(|error| Failure::file(Path::new("."), &error))?;
        let manifest = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
        let root = manifest
            .as_deref()
            .and_then(Path::parent)
            .or_else(|| here.ancestors().find(|directory| directory.join("xtask/Cargo.toml").is_file()))
            .ok_or_else(|| Failure::usage("no workspace around the current directory"))?
            .to_path_buf();
        let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |target| here.join(target));
        Ok(Self { root, target })
    }

    /// A path as people write it: relative to the root where it lies below.
    pub fn shorten(&self, path: &Path) -> String {
        path.strip_prefix(&self.root).unwrap_or(path).display().to_string()
    }

    /// The cargo that runs this task, in the root, without standard input.
    pub fn cargo(&self) -> Command {
        let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.current_dir(&self.root).stdin(Stdio::null());
        command
    }
}
