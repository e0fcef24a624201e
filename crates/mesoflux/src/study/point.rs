//! An input of a study as it is run, and the directory that belongs to it by its contents.

use super::definition::leaves;
use super::{Study, StudyError};
use mesoflux_core::pair::KERNEL;
use mesoflux_io::input::{Files, InputFile, Setting};
use sha2::{Digest, Sha256};
use std::path::Path;

/// An input as a study runs it.
#[derive(Debug, Clone)]
pub struct StudyPoint {
    /// The input's name.
    pub name: String,
    /// The input, shortened in the quick form.
    pub file: InputFile,
    /// The name of its directory: the input's, and a hash of all that its results depend on.
    pub directory: String,
}

impl StudyPoint {
    /// The input of a name, in the publication's lengths or the quick form's.
    ///
    /// # Errors
    /// An input that can't be read or is wrong.
    pub fn new(study: &Study, name: &str, quick: bool) -> Result<Self, StudyError> {
        let text = study.source.text(&format!("inputs/{name}.toml"))?;
        let shorter = study.definition.quick.get(name).filter(|_| quick);
        let settings: Vec<Setting> = shorter.map_or_else(Vec::new, |table| {
            leaves(table).into_iter().map(|(path, value)| Setting { path, value: value.to_string() }).collect()
        });
        let file = InputFile::parse(
            &format!("{}, inputs/{name}.toml", study.name),
            &text,
            &settings,
            Files::beside(Path::new("")),
        )?;
        if !file.named_files()?.is_empty() {
            return Err(StudyError::Wrong(format!(
                "{}, inputs/{name}.toml: system.start names a file: an input of a study must stand alone",
                study.name
            )));
        }
        let directory = format!("{name}-{}", identity(&file));
        Ok(Self { name: name.to_owned(), file, directory })
    }
}

/// Twelve hexadecimal digits that follow from the complete input, the version of the program and its kernels.
fn identity(file: &InputFile) -> String {
    let input = toml::to_string(&file.input.with_defaults()).unwrap_or_else(|_| file.text().to_owned());
    let mut hash = Sha256::new();
    for part in [&input, env!("CARGO_PKG_VERSION"), KERNEL] {
        // Its length before each part: no two lists of parts are one text.
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}
