//! What the tests of input files share: the files under `tests/input`.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::{Path, PathBuf};

/// A folder under `tests/input`.
pub fn directory(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/input").join(folder)
}

/// The input files of a folder under `tests/input`, by name.
pub fn input_files(folder: &str) -> Vec<PathBuf> {
    let folder = directory(folder);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    // Files that inputs start from lie in a folder of their own.
    paths.retain(|path| path.is_file());
    assert!(
        paths.iter().all(|path| path.extension().is_some_and(|end| end == "toml")),
        "only .toml in {}",
        folder.display()
    );
    paths
}

/// The name without folders.
pub fn bare_name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap()
}
