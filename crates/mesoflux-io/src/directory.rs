//! Directories that runs write to: never another run's, and files whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file or directory that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum DirectoryError {
    /// The explicit name is taken.
    #[error("--out {0}: exists already; choose another directory, or give --force to write into it")]
    Exists(String),
    /// The system refused.
    #[error("{path}: {source}")]
    Io {
        /// What was to be written.
        path: String,
        /// Why it wasn't.
        source: std::io::Error,
    },
}

/// A directory that belongs to one run.
#[derive(Debug, Clone)]
pub struct OutputDirectory {
    path: PathBuf,
}

impl OutputDirectory {
    /// Makes the directory `wanted`; one that exists is refused unless `force` is given.
    ///
    /// # Errors
    /// A name that is taken, or a directory that can't be made.
    pub fn explicit(wanted: &Path, force: bool) -> Result<Self, DirectoryError> {
        if wanted.exists() && !force {
            return Err(DirectoryError::Exists(wanted.display().to_string()));
        }
        std::fs::create_dir_all(wanted).map_err(|source| failed(wanted, source))?;
        Ok(Self { path: wanted.to_owned() })
    }

    /// Makes a new directory named after an input: `name`, or `name-2`, `name-3`, … where that is taken.
    ///
    /// # Errors
    /// A directory that can't be made.
    pub fn named_after(input: &Path) -> Result<Self, DirectoryError> {
        let name = input.file_stem().map_or_else(|| "run".to_owned(), |stem| stem.to_string_lossy().into_owned());
        for number in 1u64.. {
            let path = PathBuf::from(if number == 1 { name.clone() } else { format!("{name}-{number}") });
            // Making the directory is the test: two runs that start at once can't both have it.
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path }),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(source) => return Err(failed(&path, source)),
            }
        }
        unreachable!("there are more numbers than directories")
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes a file or directory of an earlier run, if it is there; nothing else in the directory is touched.
    ///
    /// # Errors
    /// Something that can't be removed.
    pub fn remove(&self, name: &str) -> Result<(), DirectoryError> {
        let path = self.path.join(name);
        let removed = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        match removed {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(failed(&path, source)),
            _ => Ok(()),
        }
    }

    /// Writes a file whole: under another name first, on disk before it takes its own.
    ///
    /// # Errors
    /// A file that can't be written; the old one, if any, is then still there.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), DirectoryError> {
        let target = self.path.join(name);
        let write = || -> std::io::Result<()> {
            let mut file = tempfile::NamedTempFile::new_in(&self.path)?;
            file.write_all(contents)?;
            file.as_file().sync_all()?;
            file.persist(&target)?;
            std::fs::File::open(&self.path)?.sync_all()
        };
        write().map_err(|source| failed(&target, source))
    }
}

fn failed(path: &Path, source: std::io::Error) -> DirectoryError {
    DirectoryError::Io { path: path.display().to_string(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_explicit_directory_that_exists_is_refused_unless_forced() {
        let parent = tempfile::tempdir().unwrap();
        let wanted = parent.path().join("out");
        let first = OutputDirectory::explicit(&wanted, false).unwrap();
        first.write("results.json", b"{}").unwrap();
        assert!(matches!(OutputDirectory::explicit(&wanted, false), Err(DirectoryError::Exists(_))));
        let forced = OutputDirectory::explicit(&wanted, true).unwrap();
        forced.write("results.json", b"[]").unwrap();
        assert_eq!(std::fs::read(wanted.join("results.json")).unwrap(), b"[]");
        assert_eq!(std::fs::read_dir(&wanted).unwrap().count(), 1, "no temporary file is left");
    }
}
