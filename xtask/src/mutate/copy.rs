//! A copy of the working tree, in which the code may be broken; the tree itself is never touched.

use std::collections::BTreeMap;
use std::fs::{self, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::failure::Failure;

/// What a path of the tree holds.
#[derive(Debug, PartialEq)]
enum Content {
    File(Vec<u8>, Permissions),
    Link(PathBuf),
}

impl Content {
    /// What lies at the path now; `None` where nothing does, or a directory.
    fn read(path: &Path) -> io::Result<Option<Self>> {
        let kind = match fs::symlink_metadata(path) {
            Ok(kind) => kind,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        if kind.is_symlink() {
            Ok(Some(Self::Link(fs::read_link(path)?)))
        } else if kind.is_file() {
            Ok(Some(Self::File(fs::read(path)?, kind.permissions())))
        } else {
            Ok(None)
        }
    }

    /// Puts the content at the path, where nothing lies yet.
    fn write(&self, path: &Path) -> io::Result<()> {
        match self {
            Self::File(bytes, permissions) => {
                fs::write(path, bytes)?;
                fs::set_permissions(path, permissions.clone())
            }
            #[cfg(unix)]
            Self::Link(to) => std::os::unix::fs::symlink(to, path),
            #[cfg(not(unix))]
            Self::Link(_) => Err(io::Error::new(io::ErrorKind::Unsupported, "symbolic links are copied on Unix only")),
        }
    }
}

/// The tree as it was when the task began, and the directory that it is copied to.
#[derive(Debug)]
pub struct Copy {
    files: BTreeMap<PathBuf, Content>,
    /// The directory of the copy.
    pub directory: PathBuf,
}

impl Copy {
    /// Reads what git tracks or would track (changes that are not committed included) and copies it.
    pub fn create(root: &Path, directory: &Path) -> Result<Self, Failure> {
        let arguments = ["ls-files", "-z", "--cached", "--others", "--exclude-standard"];
        let listed = Command::new("git").current_dir(root).args(arguments).stdin(Stdio::null()).output();
        let listed = listed.map_err(|error| Failure::task(format!("git could not be started: {error}")))?;
        if !listed.status.success() {
            let reason = String::from_utf8_lossy(&listed.stderr);
            return Err(Failure::task(format!("git could not list the files of the tree: {}", reason.trim())));
        }
        let mut files = BTreeMap::new();
        for name in listed.stdout.split(|byte| *byte == 0).filter(|name| !name.is_empty()) {
            let name = std::str::from_utf8(name)
                .map_err(|_| Failure::task(format!("{}: must be UTF-8", String::from_utf8_lossy(name))))?;
            let path = root.join(name);
            // A file deleted but still tracked, and a nested repository, have no content.
            if let Some(content) = Content::read(&path).map_err(|error| Failure::file(&path, &error))? {
                files.insert(PathBuf::from(name), content);
            }
        }
        let copy = Self { files, directory: directory.to_path_buf() };
        copy.restore()?;
        Ok(copy)
    }

    /// Makes the copy equal to the tree again. A file that is equal already keeps its time of change, so that
    /// cargo rebuilds only what differs; a file that does not belong there is removed.
    pub fn restore(&self) -> Result<(), Failure> {
        remove_strangers(&self.directory, &self.directory, &self.files)
            .map_err(|error| Failure::file(&self.directory, &error))?;
        for (name, content) in &self.files {
            let path = self.directory.join(name);
            restore_file(&path, content).map_err(|error| Failure::file(&path, &error))?;
        }
        Ok(())
    }

    /// Whether any file of the tree is different or missing in the copy.
    pub fn differs(&self) -> Result<bool, Failure> {
        for (name, content) in &self.files {
            let path = self.directory.join(name);
            if Content::read(&path).map_err(|error| Failure::file(&path, &error))?.as_ref() != Some(content) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Applies a patch to the copy, strictly: every line of context must agree.
    pub fn patch_command(&self, patch: &Path) -> Command {
        let mut command = Command::new("git");
        // The copy lies inside the repository. Were git to notice, it would take the paths of a `git diff` as relative
        // to the repository, find all of them outside the copy, and silently apply nothing.
        if let Some(parent) = self.directory.parent() {
            command.env("GIT_CEILING_DIRECTORIES", parent);
        }
        command.env_remove("GIT_DIR").env_remove("GIT_WORK_TREE").env_remove("GIT_INDEX_FILE");
        command.current_dir(&self.directory).args(["apply", "--whitespace=nowarn"]).arg(patch);
        command
    }
}

/// Writes the content where it differs from what lies there.
fn restore_file(path: &Path, content: &Content) -> io::Result<()> {
    let present = Content::read(path)?;
    if present.as_ref() == Some(content) {
        return Ok(());
    }
    if present.is_some() {
        fs::remove_file(path)?;
    } else if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)?;
    }
    content.write(path)
}

/// Removes everything below the directory that is not a file of the tree or a directory above one.
fn remove_strangers(top: &Path, directory: &Path, files: &BTreeMap<PathBuf, Content>) -> io::Result<()> {
    if !directory.exists() {
        return fs::create_dir_all(directory);
    }
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        let path = entry.path();
        let name = path.strip_prefix(top).map_err(io::Error::other)?;
        if entry.file_type()?.is_dir() {
            // In order of paths, the files below a directory come right after the directory itself would.
            let holds_files = files.range(name.to_path_buf()..).next().is_some_and(|(file, _)| file.starts_with(name));
            if holds_files && !files.contains_key(name) {
                remove_strangers(top, &path, files)?;
            } else {
                fs::remove_dir_all(&path)?;
            }
        } else if !files.contains_key(name) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}
