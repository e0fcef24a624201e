//! Reading an input file, with settings from the command line written into it before it is read.

use super::diagnostic::Fault;
use super::start::{Files, Unusable};
use super::validate::Invalid;
use super::wording::explain;
use super::{Input, Sweep};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};
use toml_edit::{DocumentMut, Item, TableLike, TomlError};

/// An input that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The file can't be read.
    #[error("error: {name}: can't be read: {source}")]
    Read {
        /// The file.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not what it should be; the message shows where.
    #[error("{0}")]
    Wrong(String),
}

/// `--set path=value`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The key's path, dotted.
    pub path: String,
    /// The value as TOML, or a bare word.
    pub value: String,
}

impl std::str::FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((path, value)) if !path.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Self { path: path.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err(format!("`{text}`: must have the form path.to.key=value")),
        }
    }
}

/// An input read and found right, with the text it came from.
#[derive(Debug, Clone)]
pub struct InputFile {
    name: String,
    text: String,
    files: Arc<Files>,
    /// What the text says.
    pub input: Input,
    /// The points of its sweep; one point without settings where there is none.
    pub sweep: Sweep,
}

impl InputFile {
    /// The text, with the settings written into it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Reads a file and applies settings to it.
    ///
    /// # Errors
    /// A file that can't be read; a text that is wrong, with place, value and requirement.
    pub fn read(path: &Path, settings: &[Setting]) -> Result<Self, InputError> {
        Self::read_with(path, settings, Files::beside(path.parent().unwrap_or(Path::new(""))))
    }

    /// Reads a file and applies settings to it; the files that it names are found by `files`.
    ///
    /// # Errors
    /// A file that can't be read; a text that is wrong, with place, value and requirement.
    pub fn read_with(path: &Path, settings: &[Setting], files: Files) -> Result<Self, InputError> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|source| InputError::Read { name: name.clone(), source })?;
        let text = String::from_utf8(bytes).map_err(|error| no_text(&name, &error))?;
        Self::parse(&name, &text, settings, files)
    }

    /// Reads a text called `name` and applies settings to it; the files that it names are found by `files`.
    ///
    /// # Errors
    /// A text that is wrong, with place, value and requirement.
    pub fn parse(name: &str, text: &str, settings: &[Setting], files: Files) -> Result<Self, InputError> {
        let mut file = Self::parse_one(name, text, settings, &Arc::new(files), |setting, reason| {
            InputError::Wrong(format!("error: --set {}={}: {reason}", setting.path, setting.value))
        })?;
        file.sweep = Sweep::of(&file.input).map_err(|invalid| file.fault(&invalid))?;
        // Every point must be right before the first one runs.
        for point in &file.sweep.points {
            file.at(point)?;
        }
        Ok(file)
    }

    /// The input at one point of its sweep.
    ///
    /// # Errors
    /// A point at which the input is wrong.
    pub fn at(&self, point: &super::Point) -> Result<Input, InputError> {
        if point.settings.is_empty() {
            return Ok(self.input.clone());
        }
        let misplaced =
            |setting: &Setting, reason| self.fault(&Invalid::new(format!("sweep.{}", setting.path), "", reason));
        let mut input = Self::parse_one(&self.name, &self.text, &point.settings, &self.files, misplaced)?.input;
        input.sweep.clear();
        Ok(input)
    }

    /// The paths of the files that the input names at any of its points, and where each is.
    ///
    /// # Errors
    /// A point at which the input is wrong.
    pub fn named_files(&self) -> Result<BTreeMap<String, PathBuf>, InputError> {
        let mut named = BTreeMap::new();
        for point in &self.sweep.points {
            if let Some((start, ..)) = self.at(point)?.system.start.file() {
                named.insert(start.path.clone(), self.files.locate(&start.path));
            }
        }
        Ok(named)
    }

    /// A fault found by those who use the input, shown where the input says it.
    pub fn fault(&self, invalid: &Invalid) -> InputError {
        fault(&self.name, &self.text, invalid)
    }

    /// Reads a text with settings; `misplaced` words what is said of one that can't be written into it.
    fn parse_one(
        name: &str,
        text: &str,
        settings: &[Setting],
        files: &Arc<Files>,
        misplaced: impl Fn(&Setting, String) -> InputError,
    ) -> Result<Self, InputError> {
        let (name, text) = apply(name, text, settings, misplaced)?;
        let mut input: Input =
            toml::from_str(&text).map_err(|error| unreadable(&name, &text, error.span(), error.message()))?;
        input.load(files).map_err(|unusable| match unusable {
            Unusable::File(error) => error,
            Unusable::Wrong(invalid) => fault(&name, &text, &invalid),
        })?;
        input.validate().map_err(|invalid| fault(&name, &text, &invalid))?;
        Ok(Self { name, text, files: Arc::clone(files), input, sweep: Sweep::default() })
    }
}

/// A text that the reader refuses.
fn unreadable(name: &str, text: &str, span: Option<Range<usize>>, message: &str) -> InputError {
    InputError::Wrong(explain(text, span, message).render(name, text))
}

/// A file that holds no text.
fn no_text(name: &str, error: &std::string::FromUtf8Error) -> InputError {
    let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
    let line = valid.split(|&byte| byte == b'\n').count();
    let byte = error.as_bytes()[valid.len()];
    InputError::Wrong(format!("error: {name}: line {line} holds the byte {byte:#04x}: must be text in UTF-8"))
}

fn fault(name: &str, text: &str, invalid: &Invalid) -> InputError {
    let mut span = locate(text, &invalid.path);
    let mut message = invalid.to_string();
    if let (Some(within), Some(span)) = (&invalid.within, &mut span) {
        let (part, shown) = within.as_ref();
        let inside = |quoted: &str| quoted.get(1..quoted.len() - 1).map(str::to_owned);
        if text.get(span.clone()).and_then(inside) == inside(&invalid.value) {
            // The text stands there as it is, in one pair of quotes.
            *span = span.start + 1 + part.start..span.start + 1 + part.end;
        } else {
            message += &format!("\n{shown}");
        }
    }
    let fault = Fault { span, message, help: invalid.help.clone() };
    InputError::Wrong(fault.render(name, text))
}

/// Where the value of a dotted path stands in a text; of the longest part of the path that is there at all.
fn locate(text: &str, path: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut span = None;
    let mut table = document.get_ref();
    let mut array: Option<&toml::de::DeArray> = None;
    for key in path.split('.') {
        let value = match array {
            Some(array) => key.parse::<usize>().ok().and_then(|index| array.get(index)),
            None => table.get(key),
        };
        let Some(value) = value else { break };
        span = Some(value.span());
        match value.get_ref() {
            DeValue::Table(inner) => (table, array) = (inner, None),
            DeValue::Array(inner) => array = Some(inner),
            _ => break,
        }
    }
    span
}

/// Writes settings into a text; its name then tells that the text is not the file's alone.
fn apply(
    name: &str,
    text: &str,
    settings: &[Setting],
    misplaced: impl Fn(&Setting, String) -> InputError,
) -> Result<(String, String), InputError> {
    if settings.is_empty() {
        return Ok((name.to_owned(), text.to_owned()));
    }
    let mut document: DocumentMut =
        text.parse().map_err(|error: TomlError| unreadable(name, text, error.span(), error.message()))?;
    for setting in settings {
        let value: toml_edit::Value =
            setting.value.parse().unwrap_or_else(|_| toml_edit::Value::from(setting.value.as_str()));
        set(document.as_table_mut(), &setting.path, value).map_err(|reason| misplaced(setting, reason))?;
    }
    let set: Vec<String> = settings.iter().map(|setting| format!("{}={}", setting.path, setting.value)).collect();
    Ok((format!("{name} with {}", set.join(", ")), document.to_string()))
}

fn set(table: &mut dyn TableLike, path: &str, value: toml_edit::Value) -> Result<(), String> {
    match path.split_once('.') {
        None => {
            table.insert(path, Item::Value(value));
            Ok(())
        }
        Some((key, rest)) => {
            let inner = table.entry(key).or_insert_with(|| {
                let mut table = toml_edit::Table::new();
                table.set_implicit(true);
                Item::Table(table)
            });
            match inner.as_table_like_mut() {
                Some(inner) => set(inner, rest, value),
                None => Err(format!("`{key}` is a value, not a table: must be a path of keys as in the file")),
            }
        }
    }
}
