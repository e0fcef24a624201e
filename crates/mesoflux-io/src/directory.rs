//! Directories that runs write to: never another run's, one process at a time, and files whole or not at all.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Begins the name of every file that is being written; one that is left was cut short.
const UNFINISHED: &str = ".mesoflux-unfinished-";

/// A file or directory that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum DirectoryError {
    /// The explicit name is taken.
    #[error("--out {0}: exists already; choose another directory, or give --force to write into it")]
    Exists(String),
    /// Another process works there.
    #[error("{path}: is in use by {holder}; wait for its end, or choose another directory")]
    InUse {
        /// The directory.
        path: String,
        /// Who, as far as can be known.
        holder: String,
    },
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
        if let Some(parent) = wanted.parent() {
            std::fs::create_dir_all(parent).map_err(|source| failed(wanted, source))?;
        }
        // Making the directory is the test: two runs that start at once can't both have it.
        match std::fs::create_dir(wanted) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                if !force {
                    return Err(DirectoryError::Exists(wanted.display().to_string()));
                }
                if !wanted.is_dir() {
                    return Err(failed(wanted, ErrorKind::NotADirectory.into()));
                }
            }
            made => made.map_err(|source| failed(wanted, source))?,
        }
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
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path }),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
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
            Err(source) if source.kind() != ErrorKind::NotFound => Err(failed(&path, source)),
            _ => Ok(()),
        }
    }

    /// Removes everything but the entry `kept`.
    ///
    /// # Errors
    /// Something that can't be read or removed.
    pub fn remove_all_but(&self, kept: &str) -> Result<(), DirectoryError> {
        self.remove_where(|name| name != kept)
    }

    /// Removes what a process left half-written when it was killed.
    ///
    /// # Errors
    /// Something that can't be read or removed.
    pub fn remove_unfinished(&self) -> Result<(), DirectoryError> {
        self.remove_where(|name| name.starts_with(UNFINISHED))
    }

    fn remove_where(&self, unwanted: impl Fn(&str) -> bool) -> Result<(), DirectoryError> {
        for entry in std::fs::read_dir(&self.path).map_err(|source| failed(&self.path, source))? {
            let name = entry.map_err(|source| failed(&self.path, source))?.file_name();
            if let Some(name) = name.to_str().filter(|name| unwanted(name)) {
                self.remove(name)?;
            }
        }
        Ok(())
    }

    /// Keeps every other process out for as long as the lock lives. The system releases it when a process dies, however it dies.
    ///
    /// Where the file system knows no locks, the lock says so and keeps nobody out.
    ///
    /// # Errors
    /// Another process that holds it; a file that can't be made.
    pub fn lock(&self, name: &str) -> Result<Lock, DirectoryError> {
        let path = self.path.join(name);
        let open = File::options().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open.map_err(|source| failed(&path, source))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let told = file.read_to_string(&mut holder).is_ok() && !holder.trim().is_empty();
                let holder = if told { holder.trim().to_owned() } else { "another process".to_owned() };
                return Err(DirectoryError::InUse { path: self.path.display().to_string(), holder });
            }
            Err(TryLockError::Error(reason)) => {
                let path = path.display();
                return Ok(Lock {
                    _file: file,
                    warning: Some(format!("{path}: can't be locked: {reason}; nothing keeps a second process out")),
                });
            }
        }
        // The name is a courtesy to whoever finds the lock held: a disk too full for it is no reason to stop.
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(this_process().as_bytes()));
        Ok(Lock { _file: file, warning: None })
    }

    /// Writes a file whole: under another name first, on disk before it takes its own.
    ///
    /// # Errors
    /// A file that can't be written; the old one, if any, is then still there.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), DirectoryError> {
        self.write_with(name, |file| file.write_all(contents))
    }

    /// Writes a file whole, its contents being what `fill` puts into it.
    ///
    /// # Errors
    /// A file that can't be written, or that `fill` doesn't finish; the old one, if any, is then still there.
    pub fn write_with(
        &self,
        name: &str,
        fill: impl FnOnce(&mut File) -> std::io::Result<()>,
    ) -> Result<(), DirectoryError> {
        let target = self.path.join(name);
        let unfinished = self.path.join(format!("{UNFINISHED}{name}"));
        let write = || -> std::io::Result<()> {
            let mut file = File::create(&unfinished)?;
            fill(&mut file)?;
            file.sync_all()?;
            std::fs::rename(&unfinished, &target)?;
            File::open(&self.path)?.sync_all()
        };
        write().map_err(|source| {
            // What is there of it takes room that a full disk lacks.
            let _ = std::fs::remove_file(&unfinished);
            failed(&target, source)
        })
    }
}

/// The right to write to a directory, given up with the value.
#[derive(Debug)]
pub struct Lock {
    _file: File,
    /// Why it keeps nobody out, if it doesn't.
    pub warning: Option<String>,
}

/// This process, for those whom its lock keeps out.
fn this_process() -> String {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let at = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
    format!("process {}{at}\n", std::process::id())
}

fn failed(path: &Path, source: std::io::Error) -> DirectoryError {
    DirectoryError::Io { path: path.display().to_string(), source }
}

#[cfg(test)]
mod tests;
