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
    /// There are files, and none is whole.
    #[error("{}; no whole state of this run is left: delete what there is of it to begin this run again (the others go on from theirs)", list(.0))]
    NoneWhole(Vec<CheckpointError>),
}

fn list(errors: &[CheckpointError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// The two checkpoint files of one run.
#[derive(Debug, Clone)]
pub struct CheckpointFiles {
    names: [String; 2],
    next: usize,
}

/// What was found of a run.
#[derive(Debug)]
pub struct Found<T> {
    /// The newest whole state.
    pub state: T,
    /// The file it came from.
    pub path: PathBuf,
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

    /// Reads the newest whole state; `None` where there are no files.
    ///
    /// `age` tells from the bytes which of the two is newer, `decode` makes a state of them; either may refuse, and
    /// the other file is then taken. The next state is written over the file that was not taken.
    ///
    /// # Errors
    /// Files of which none is whole.
    pub fn read<T>(
        &mut self,
        directory: &Path,
        age: impl Fn(&[u8]) -> Result<u64, String>,
        decode: impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<Option<Found<T>>, CheckpointError> {
        let mut whole = Vec::new();
        let mut damaged = Vec::new();
        for (place, name) in self.names.iter().enumerate() {
            match read_file(&directory.join(name), &age) {
                Ok(Some((age, contents))) => whole.push((age, place, contents)),
                Ok(None) => {}
                Err(error) => damaged.push(error),
            }
        }
        whole.sort_by_key(|(age, ..)| std::cmp::Reverse(*age));
        for (_, place, contents) in whole {
            let path = directory.join(&self.names[place]);
            match decode(&contents[HEADER..]) {
                Ok(state) => {
                    self.next = 1 - place;
                    return Ok(Some(Found { state, path, damaged }));
                }
                Err(reason) => damaged.push(CheckpointError::Damaged { path: path.display().to_string(), reason }),
            }
        }
        if damaged.is_empty() { Ok(None) } else { Err(CheckpointError::NoneWhole(damaged)) }
    }
}

/// The contents of a whole file and the age of the state in it; `None` where there is no file.
fn read_file(
    path: &Path,
    age: impl Fn(&[u8]) -> Result<u64, String>,
) -> Result<Option<(u64, Vec<u8>)>, CheckpointError> {
    let name = || path.display().to_string();
    let contents = match std::fs::read(path) {
        Ok(contents) => contents,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(CheckpointError::Read { path: name(), source }),
    };
    let age = decode(&contents).and_then(age).map_err(|reason| CheckpointError::Damaged { path: name(), reason })?;
    Ok(Some((age, contents)))
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

    fn read(
        files: &mut CheckpointFiles,
        directory: &OutputDirectory,
    ) -> Result<Option<Found<Vec<u8>>>, CheckpointError> {
        let age = |state: &[u8]| state.first_chunk().map(|step| u64::from_le_bytes(*step)).ok_or("short".to_owned());
        let decode =
            |state: &[u8]| if state.len() == 8 { Ok(state.to_vec()) } else { Err("has another length".to_owned()) };
        files.read(directory.path(), age, decode)
    }

    fn flip_a_bit(path: &Path) {
        let mut bytes = std::fs::read(path).unwrap();
        *bytes.last_mut().unwrap() ^= 4;
        std::fs::write(path, bytes).unwrap();
    }

    #[test]
    fn the_newest_whole_state_is_read_and_a_damaged_one_passed_over() {
        let parent = tempfile::tempdir().unwrap();
        let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
        let mut files = CheckpointFiles::new("run");
        assert!(read(&mut files, &directory).unwrap().is_none());
        for step in 1u64..=5 {
            files.write(&directory, &step.to_le_bytes()).unwrap();
        }
        let newest = read(&mut CheckpointFiles::new("run"), &directory).unwrap().unwrap();
        assert_eq!(newest.state, 5u64.to_le_bytes());
        // The fifth state went over the third, into the first file.
        flip_a_bit(&directory.path().join("run.a.checkpoint"));
        let mut files = CheckpointFiles::new("run");
        let reserve = read(&mut files, &directory).unwrap().unwrap();
        assert_eq!((reserve.state, reserve.damaged.len()), (4u64.to_le_bytes().to_vec(), 1));
        assert!(reserve.path.ends_with("run.b.checkpoint"));
        // What comes next replaces the damaged file, not the whole one.
        files.write(&directory, &6u64.to_le_bytes()).unwrap();
        let both = read(&mut CheckpointFiles::new("run"), &directory).unwrap().unwrap();
        assert_eq!((both.state, both.damaged.len()), (6u64.to_le_bytes().to_vec(), 0));
    }

    #[test]
    fn a_newer_state_that_can_t_be_understood_is_passed_over() {
        let parent = tempfile::tempdir().unwrap();
        let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
        let mut files = CheckpointFiles::new("run");
        files.write(&directory, &1u64.to_le_bytes()).unwrap();
        files.write(&directory, &[9; 20]).unwrap();
        let found = read(&mut files, &directory).unwrap().unwrap();
        assert_eq!((found.state, found.damaged.len()), (1u64.to_le_bytes().to_vec(), 1));
    }

    #[test]
    fn where_no_file_is_whole_all_are_named() {
        let parent = tempfile::tempdir().unwrap();
        let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
        let mut files = CheckpointFiles::new("run");
        for step in 1u64..=2 {
            files.write(&directory, &step.to_le_bytes()).unwrap();
        }
        for name in ["run.a.checkpoint", "run.b.checkpoint"] {
            flip_a_bit(&directory.path().join(name));
        }
        let message = read(&mut files, &directory).unwrap_err().to_string();
        for part in ["state/run.a.checkpoint: has the checksum", "state/run.b.checkpoint: has the checksum", "delete"] {
            assert!(message.contains(part), "no {part:?} in {message}");
        }
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
