//! Where studies are found: those that are part of the program, and directories of one's own.

use super::{Study, StudyError};
use include_dir::{Dir, include_dir};
use std::path::{Path, PathBuf};

/// The published studies, `studies/` of the source.
static PUBLISHED: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../studies");

/// The files of a study.
#[derive(Debug, Clone)]
pub enum Source {
    /// Part of the program.
    Published(&'static Dir<'static>),
    /// In a directory.
    Folder(PathBuf),
}

impl Source {
    /// The text of a file.
    pub(super) fn text(&self, name: &str) -> Result<String, StudyError> {
        match self {
            Self::Published(directory) => {
                let file = directory.get_file(directory.path().join(name));
                let text = file.and_then(|file| file.contents_utf8()).map(str::to_owned);
                text.ok_or_else(|| StudyError::read(Path::new(name), std::io::ErrorKind::NotFound.into()))
            }
            Self::Folder(path) => {
                let path = path.join(name);
                std::fs::read_to_string(&path).map_err(|source| StudyError::read(&path, source))
            }
        }
    }
}

/// The names of the published studies, as people type them.
pub fn names() -> Vec<&'static str> {
    // A file name with an underscore, a study with a hyphen.
    let mut names: Vec<&str> =
        PUBLISHED.dirs().filter_map(|directory| directory.path().file_name()?.to_str()).map(hyphenated).collect();
    names.sort_unstable();
    names
}

/// `wu_shang` as `wu-shang`; leaked once for each of a few studies.
fn hyphenated(name: &'static str) -> &'static str {
    if name.contains('_') { name.replace('_', "-").leak() } else { name }
}

/// A published study; `None` if there is none of this name.
///
/// # Errors
/// None, unless the program was built from files that are wrong.
pub fn published(name: &str) -> Result<Option<Study>, StudyError> {
    let directory = PUBLISHED.get_dir(name.replace('-', "_")).filter(|_| !name.contains('_'));
    directory.map(|directory| Study::read(name, Source::Published(directory))).transpose()
}

/// The study in a directory, named after it.
///
/// # Errors
/// Files that can't be read or are wrong.
pub fn in_folder(path: &Path) -> Result<Study, StudyError> {
    let name = path.file_name().map_or_else(|| "study".to_owned(), |name| name.to_string_lossy().into_owned());
    Study::read(&name, Source::Folder(path.to_owned()))
}

/// What `STUDY[/ITEM]` names: a published study, or else a directory with a `study.toml`; and one of its items.
///
/// # Errors
/// A name that doesn't exist, with those that do; files that can't be read or are wrong.
pub fn find(wanted: &str) -> Result<(Study, Option<String>), StudyError> {
    let wanted = wanted.trim_end_matches('/');
    let (first, rest) = match wanted.split_once('/') {
        Some((first, rest)) => (first, Some(rest)),
        None => (wanted, None),
    };
    let (study, item) = if let Some(study) = published(first)? {
        (study, rest.map(str::to_owned))
    } else {
        let is_study = |path: &Path| path.join("study.toml").exists();
        let path = Path::new(wanted);
        match (path.parent(), path.file_name()) {
            _ if is_study(path) => (in_folder(path)?, None),
            (Some(folder), Some(item)) if is_study(folder) => {
                (in_folder(folder)?, Some(item.to_string_lossy().into_owned()))
            }
            _ => {
                let names = names().join(", ");
                let message = format!("no study `{first}`; there are: {names}; or give a directory with a study.toml");
                return Err(StudyError::Wrong(message));
            }
        }
    };
    if let Some(item) = &item {
        study.item(item)?;
    }
    Ok((study, item))
}
