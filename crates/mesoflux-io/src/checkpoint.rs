//! Checkpoint files: a state that is whole or refused, with the one before it in reserve.
//!
//! A file is a line that names the format, the length and the checksum (CRC-32) of what follows, and the state itself. It is written
//! under another name, flushed to disk and renamed, so that a crash leaves the old one. Two are kept and written in turn.
//!
//! States are as large as memory allows: they stream to the file and from it, and the checksum is right before any of it is decoded.

use crate::directory::{DirectoryError, OutputDirectory};
use crate::stream::Values;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The first line of every checkpoint.
const MAGIC: &[u8] = b"mesoflux checkpoint 1\n";
/// What comes before the state: the line, the state's length and its checksum.
pub const HEADER: usize = MAGIC.len() + 8 + 4;
/// Bytes that go to the file or come from it at a time.
const BLOCK: usize = 1 << 16;

/// A checkpoint that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file can't be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        source: io::Error,
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

    /// Writes a state over the older of the two files; `state` streams it.
    ///
    /// # Errors
    /// A file that can't be written; both old ones are then still there.
    pub fn write(
        &mut self,
        directory: &OutputDirectory,
        state: impl FnOnce(&mut StateWriter) -> io::Result<()>,
    ) -> Result<(), DirectoryError> {
        directory.write_with(&self.names[self.next], |file| write_framed(file, state))?;
        self.next = 1 - self.next;
        Ok(())
    }

    /// Reads the newest whole state; `None` where there are no files.
    ///
    /// `age` tells from the first values which of the two is newer, `decode` makes a state of them all; either may refuse, and
    /// the other file is then taken. The next state is written over the file that was not taken.
    ///
    /// # Errors
    /// Files of which none is whole.
    pub fn read<T>(
        &mut self,
        directory: &Path,
        age: impl Fn(&mut StateReader) -> Result<u64, String>,
        decode: impl Fn(&mut StateReader) -> Result<T, String>,
    ) -> Result<Option<Found<T>>, CheckpointError> {
        let mut whole = Vec::new();
        let mut damaged = Vec::new();
        for (place, name) in self.names.iter().enumerate() {
            let path = directory.join(name);
            match WholeState::open(&path, &path.display().to_string()) {
                Ok(state) => match state.read(&age) {
                    Ok(age) => whole.push((age, place, state)),
                    Err(error) => damaged.push(error),
                },
                Err(CheckpointError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {}
                Err(error) => damaged.push(error),
            }
        }
        whole.sort_by_key(|(age, ..)| std::cmp::Reverse(*age));
        for (_, place, state) in whole {
            match state.read(&decode) {
                Ok(state) => {
                    self.next = 1 - place;
                    return Ok(Some(Found { state, path: directory.join(&self.names[place]), damaged }));
                }
                Err(error) => damaged.push(error),
            }
        }
        if damaged.is_empty() { Ok(None) } else { Err(CheckpointError::NoneWhole(damaged)) }
    }
}

/// What a state streams to.
pub type StateWriter<'a> = BufWriter<Summed<&'a mut File>>;

/// What a state streams from.
pub type StateReader<'a> = Values<BufReader<&'a File>>;

/// A file whose state is whole: of the length and the checksum that its header says.
#[derive(Debug)]
pub struct WholeState {
    file: File,
    name: String,
    length: u64,
}

impl WholeState {
    /// Opens the file at `path`, which messages call `name`.
    ///
    /// # Errors
    /// A file that can't be read, or that isn't what was written.
    pub fn open(path: &Path, name: &str) -> Result<Self, CheckpointError> {
        let unreadable = |source| CheckpointError::Read { path: name.to_owned(), source };
        let file = File::open(path).map_err(unreadable)?;
        let length = length_of_whole(BufReader::with_capacity(BLOCK, &file)).map_err(unreadable)?;
        let length = length.map_err(|reason| CheckpointError::Damaged { path: name.to_owned(), reason })?;
        Ok(Self { file, name: name.to_owned(), length })
    }

    /// Takes values from the beginning of the state on.
    ///
    /// # Errors
    /// A file that can't be read; what `take` refuses.
    pub fn read<T>(&self, take: impl Fn(&mut StateReader) -> Result<T, String>) -> Result<T, CheckpointError> {
        let path = || self.name.clone();
        let mut file = &self.file;
        file.seek(SeekFrom::Start(HEADER as u64)).map_err(|source| CheckpointError::Read { path: path(), source })?;
        let mut values = Values::new(BufReader::with_capacity(BLOCK, file), self.length);
        take(&mut values).map_err(|reason| CheckpointError::Damaged { path: path(), reason })
    }
}

/// Writes header and state; length and checksum are known at the end only.
fn write_framed(file: &mut File, state: impl FnOnce(&mut StateWriter) -> io::Result<()>) -> io::Result<()> {
    file.write_all(&[0; HEADER])?;
    let mut out = BufWriter::with_capacity(BLOCK, Summed::new(&mut *file));
    state(&mut out)?;
    let Summed { length, sum, .. } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.rewind()?;
    file.write_all(MAGIC)?;
    file.write_all(&length.to_le_bytes())?;
    file.write_all(&sum.finalize().to_le_bytes())
}

/// The length of the state in the contents of a file, or what shows that they are not what was written.
fn length_of_whole(mut contents: impl Read) -> io::Result<Result<u64, String>> {
    let mut header = Vec::new();
    contents.by_ref().take(HEADER as u64).read_to_end(&mut header)?;
    let Some(rest) = header.strip_prefix(MAGIC) else {
        return Ok(Err("is not a mesoflux checkpoint: must begin with its format line".to_owned()));
    };
    let (Some(said), Some(sum)) = (rest.first_chunk::<8>(), rest.get(8..12)) else {
        return Ok(Err(format!("is truncated: has {} bytes, must have at least {HEADER}", header.len())));
    };
    let said = u64::from_le_bytes(*said);
    let mut state = Summed::new(io::sink());
    // One byte too many is enough to know.
    io::copy(&mut contents.take(said.saturating_add(1)), &mut state)?;
    if state.length != said {
        let least = if state.length > said { "at least " } else { "" };
        return Ok(Err(format!("has {least}{} bytes of state: must have {said}", state.length)));
    }
    let found = state.sum.finalize();
    if sum != found.to_le_bytes() {
        return Ok(Err(format!("has the checksum {found:08x}: must have the one in its header, or bits have changed")));
    }
    Ok(Ok(said))
}

/// A writer that knows length and checksum of what went through it.
#[derive(Debug)]
pub struct Summed<W> {
    out: W,
    length: u64,
    sum: crc32fast::Hasher,
}

impl<W> Summed<W> {
    fn new(out: W) -> Self {
        Self { out, length: 0, sum: crc32fast::Hasher::new() }
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.length += written as u64;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests;
