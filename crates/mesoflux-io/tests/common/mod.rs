//! What the tests of input files share: the files under `tests/input`.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::{Path, PathBuf};

/// The input files of a folder under `tests/input`, by name.
pub fn input_files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/input").join(folder);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
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
