//! What the tests of files share: the files under `tests/input`, and the numbers that mutations are drawn with.

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

/// A small generator of its own (`SplitMix64`), so that the same mutations come on every machine.
pub struct Random(pub u64);

impl Random {
    /// A number from 0 to `bound` − 1.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % bound as u64) as usize
    }
}
