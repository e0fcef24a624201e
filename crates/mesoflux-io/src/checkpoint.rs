//! Checkpoint files: a state that is whole or refused, with the one before it in reserve.
//!
//! A file is a line that names the format, the length and the checksum (CRC-32) of what follows, and the state itself. It is written
//! under another name, flushed to disk and renamed, so that a crash leaves the old one. Two are kept and written in turn.

use crate::directory::{DirectoryError, OutputDirectory};
use std::path::{Path, PathBuf};

/// The first line of every checkpoint.
const MAGIC: &[u8] = b"mesoflux checkpoint 1\n";
/// Length of the state and its checksum.
const HEADER: usize = MAGIC.len() + 8 + 4;

/// A checkpoint that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file can't be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file isn't one, or not a whole one.
    #[error("{path}: {reason}")]
    Damaged {
        /// The file.
        path: String,
        /// What gave it away.
        reason: String,
    },
}

/// The two checkpoint files of one run.
#[derive(Debug, Clone)]
pub struct CheckpointFiles {
    names: [String; 2],
    next: usize,
}

/// What was found of a run.
#[derive(Debug)]
pub struct Found {
    /// The newer of the whole states.
    pub state: Vec<u8>,
    /// Files that were passed over, and why.
    pub damaged: Vec<CheckpointError>,
}

impl CheckpointFiles {
    /// The files of the run of this name.
    pub fn new(name: &str) -> Self {
        Self { names: [format!("{name}.a.checkpoint"), format!("{name}.b.checkpoint")], next: 0 }
    }

    /// Writes a state over the older of the two files.
    ///
    /// # Errors
    /// A file that can't be written; both old ones are then still there.
    pub fn write(&mut self, directory: &OutputDirectory, state: &[u8]) -> Result<(), DirectoryError> {
        directory.write(&self.names[self.next], &encode(state))?;
        self.next = 1 - self.next;
        Ok(())
    }

    /// Reads the newest whole state, by `age` of the two; `None` where there are no files.
    ///
    /// The next state is written over the other file.
    ///
    /// # Errors
    /// Files of which none is whole.
    pub fn read(
        &mut self,
        directory: &Path,
        age: impl Fn(&[u8]) -> Option<u64>,
    ) -> Result<Option<Found>, CheckpointError> {
        let mut best: Option<(u64, usize, Vec<u8>)> = None;
        let mut damaged = Vec::new();
        for (place, name) in self.names.iter().enumerate() {
            let path = directory.join(name);
            if !path.exists() {
                continue;
            }
            match read_file(&path, &age) {
                Ok((age, state)) if best.as_ref().is_none_or(|(older, ..)| *older < age) => {
                    best = Some((age, place, state));
                }
                Ok(_) => {}
                Err(error) => damaged.push(error),
            }
        }
        match (best, damaged.is_empty()) {
            (Some((_, place, state)), _) => {
                self.next = 1 - place;
                Ok(Some(Found { state, damaged }))
            }
            (None, true) => Ok(None),
            (None, false) => Err(damaged.swap_remove(0)),
        }
    }
}

fn read_file(path: &PathBuf, age: impl Fn(&[u8]) -> Option<u64>) -> Result<(u64, Vec<u8>), CheckpointError> {
    let name = || path.display().to_string();
    let bytes = std::fs::read(path).map_err(|source| CheckpointError::Read { path: name(), source })?;
    let damaged = |reason: String| CheckpointError::Damaged { path: name(), reason };
    let state = decode(&bytes).map_err(damaged)?;
    let age = age(state).ok_or_else(|| damaged("the state in it is of another version of the program".to_owned()))?;
    Ok((age, state.to_vec()))
}

/// A state as the contents of a file.
pub fn encode(state: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + state.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&(state.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&crc32fast::hash(state).to_le_bytes());
    bytes.extend_from_slice(state);
    bytes
}

/// The state in the contents of a file.
///
/// # Errors
/// What shows that the contents are not what was written.
pub fn decode(bytes: &[u8]) -> Result<&[u8], String> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err("is not a mesoflux checkpoint: must begin with its format line".to_owned());
    };
    let (Some(length), Some(sum), Some(state)) = (rest.first_chunk::<8>(), rest.get(8..12), rest.get(12..)) else {
        return Err(format!("is truncated: has {} bytes, must have at least {HEADER}", bytes.len()));
    };
    let length = u64::from_le_bytes(*length);
    if state.len() as u64 != length {
        return Err(format!("has {} bytes of state: must have {length}", state.len()));
    }
    let found = crc32fast::hash(state);
    if sum != found.to_le_bytes() {
        return Err(format!("has the checksum {found:08x}: must have the one in its header, or bits have changed"));
    }
    Ok(state)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn age(state: &[u8]) -> Option<u64> {
        Some(u64::from_le_bytes(*state.first_chunk()?))
    }

    #[test]
    fn the_newest_whole_state_is_read_and_a_damaged_one_passed_over() {
        let parent = tempfile::tempdir().unwrap();
        let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
        let mut files = CheckpointFiles::new("run");
        assert!(files.read(directory.path(), age).unwrap().is_none());
        for step in 1u64..=5 {
            files.write(&directory, &step.to_le_bytes()).unwrap();
        }
        let newest = CheckpointFiles::new("run").read(directory.path(), age).unwrap().unwrap();
        assert_eq!(newest.state, 5u64.to_le_bytes());
        // The fifth state went over the third, into the first file.
        let path = directory.path().join("run.a.checkpoint");
        let mut bytes = std::fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 4;
        std::fs::write(&path, bytes).unwrap();
        let mut files = CheckpointFiles::new("run");
        let reserve = files.read(directory.path(), age).unwrap().unwrap();
        assert_eq!((reserve.state, reserve.damaged.len()), (4u64.to_le_bytes().to_vec(), 1));
        // What comes next replaces the damaged file, not the whole one.
        files.write(&directory, &6u64.to_le_bytes()).unwrap();
        let both = CheckpointFiles::new("run").read(directory.path(), age).unwrap().unwrap();
        assert_eq!((both.state, both.damaged.len()), (6u64.to_le_bytes().to_vec(), 0));
    }

    #[test]
    fn no_flipped_bit_and_no_truncation_is_accepted() {
        let state: Vec<u8> = (0..200).collect();
        let good = encode(&state);
        assert_eq!(decode(&good).unwrap(), state);
        for length in 0..good.len() {
            assert!(decode(&good[..length]).is_err(), "truncated to {length} bytes");
        }
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(&bad).is_err(), "bit {bit} flipped");
        }
    }
}
