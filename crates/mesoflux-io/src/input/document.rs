//! Reading an input file, with settings from the command line written into it before it is read.

use super::diagnostic::{nearest_known, render};
use super::validate::Invalid;
use super::{Input, Sweep};
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};
use toml_edit::{DocumentMut, Item, TableLike};

/// An input that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The file can't be read.
    #[error("{name}: {source}")]
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
    /// What the text says.
    pub input: Input,
    /// The points of its sweep; one point without settings where there is none.
    pub sweep: Sweep,
}

impl InputFile {
    /// Reads a file and applies settings to it.
    ///
    /// # Errors
    /// A file that can't be read; a text that is wrong, with place, value and requirement.
    pub fn read(path: &Path, settings: &[Setting]) -> Result<Self, InputError> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| InputError::Read { name: name.clone(), source })?;
        Self::parse(&name, &text, settings)
    }

    /// Reads a text called `name` and applies settings to it.
    ///
    /// # Errors
    /// A text that is wrong, with place, value and requirement.
    pub fn parse(name: &str, text: &str, settings: &[Setting]) -> Result<Self, InputError> {
        let mut file = Self::parse_one(name, text, settings)?;
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
        let mut settings = point.settings.clone();
        settings.push(Setting { path: "sweep".into(), value: "{}".into() });
        Ok(Self::parse_one(&self.name, &self.text, &settings)?.input)
    }

    /// A fault found by those who use the input, shown where the input says it.
    pub fn fault(&self, invalid: &Invalid) -> InputError {
        fault(&self.name, &self.text, invalid)
    }

    fn parse_one(name: &str, text: &str, settings: &[Setting]) -> Result<Self, InputError> {
        let (name, text) = apply(name, text, settings)?;
        let input: Input = toml::from_str(&text).map_err(|error| {
            let help = nearest_known(error.message()).map(|known| format!("did you mean `{known}`?"));
            InputError::Wrong(render(&name, &text, error.span(), error.message(), help.as_deref()))
        })?;
        input.validate().map_err(|invalid| fault(&name, &text, &invalid))?;
        Ok(Self { name, text, input, sweep: Sweep::default() })
    }
}

fn fault(name: &str, text: &str, invalid: &Invalid) -> InputError {
    let span = locate(text, &invalid.path);
    InputError::Wrong(render(name, text, span, &invalid.to_string(), invalid.help.as_deref()))
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
fn apply(name: &str, text: &str, settings: &[Setting]) -> Result<(String, String), InputError> {
    if settings.is_empty() {
        return Ok((name.to_owned(), text.to_owned()));
    }
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
        InputError::Wrong(render(name, text, error.span(), error.message(), None))
    })?;
    for setting in settings {
        let value: toml_edit::Value =
            setting.value.parse().unwrap_or_else(|_| toml_edit::Value::from(setting.value.as_str()));
        set(document.as_table_mut(), &setting.path, value).map_err(|reason| {
            InputError::Wrong(format!("error: --set {}={}: {reason}", setting.path, setting.value))
        })?;
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
