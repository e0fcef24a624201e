//! Published studies: inputs, the series drawn from their runs, and the claims that the series confirm or refute.
//!
//! A study is a directory with `study.toml` (its items, which are figures and tables, and the series that each shows), `claims.toml` (what the
//! publication says of them) and `inputs/NAME.toml` (ordinary inputs of mesoflux, in the publication's own lengths). The published
//! ones are part of the program. [`claim`] has the statistics, one kind of claim a file; [`verdict`] says what follows.

pub mod claim;
pub mod collect;
mod comparison;
pub mod definition;
pub mod drawing;
mod fit;
pub mod library;
pub mod point;
pub mod report;
pub mod runs;
pub mod series;
pub mod table;
pub mod verdict;

use claim::{Claim, ClaimsInput};
use definition::{InOrder, ItemInput, SeriesInput, StudyInput};
use library::Source;
use mesoflux_io::input::InputError;
use std::path::Path;

/// A study that can't be read, found, or understood.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file of it can't be read.
    #[error("error: {name}: can't be read: {source}")]
    Read {
        /// The file.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// It is not what it should be.
    #[error("error: {0}")]
    Wrong(String),
    /// One of its inputs is wrong.
    #[error("{0}")]
    Input(#[from] InputError),
}

impl StudyError {
    fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Read { name: path.display().to_string(), source }
    }
}

/// A study.
#[derive(Debug, Clone)]
pub struct Study {
    /// Its name on the command line.
    pub name: String,
    /// What `study.toml` says.
    pub definition: StudyInput,
    /// What `claims.toml` says.
    pub claims: InOrder<Claim>,
    source: Source,
}

impl Study {
    fn read(name: &str, source: Source) -> Result<Self, StudyError> {
        let parse_error = |file: &str, error: toml::de::Error| StudyError::Wrong(format!("{name}, {file}: {error}"));
        let definition: StudyInput =
            toml::from_str(&source.text("study.toml")?).map_err(|error| parse_error("study.toml", error))?;
        let claims: ClaimsInput =
            toml::from_str(&source.text("claims.toml")?).map_err(|error| parse_error("claims.toml", error))?;
        let study = Self { name: name.to_owned(), definition, claims: claims.claim, source };
        study.validate()?;
        Ok(study)
    }

    /// The item of a name.
    ///
    /// # Errors
    /// A name that doesn't exist, with those that do.
    pub fn item(&self, name: &str) -> Result<&ItemInput, StudyError> {
        let items = &self.definition.item;
        items.get(name).ok_or_else(|| {
            StudyError::Wrong(format!("{} has no item `{name}`; there are: {}", self.name, items.names().join(", ")))
        })
    }

    /// Every name must be that of something.
    fn validate(&self) -> Result<(), StudyError> {
        let wrong = |place: String, reason: &str| Err(StudyError::Wrong(format!("{}, {place}: {reason}", self.name)));
        for name in self.definition.quick.keys() {
            self.source.text(&format!("inputs/{name}.toml"))?;
        }
        for (name, item) in &self.definition.item {
            let place = |inner: &str| format!("study.toml: item.{name}.{inner}");
            for input in item.inputs() {
                self.source.text(&format!("inputs/{input}.toml"))?;
            }
            let mut known: Vec<&str> = Vec::new();
            for (series, input) in &item.series {
                let needed = match input {
                    SeriesInput::Ratio(ratio) => vec![&ratio.numerator, &ratio.denominator],
                    SeriesInput::Product(product) => vec![&product.of],
                    SeriesInput::Estimates(_) | SeriesInput::Table(_) | SeriesInput::Published(_) => Vec::new(),
                };
                if let Some(unknown) = needed.into_iter().find(|needed| !known.contains(&needed.as_str())) {
                    return wrong(place(&format!("series.{series}")), &format!("no series `{unknown}` before it"));
                }
                if let SeriesInput::Published(published) = input
                    && let Some(fault) = published.fault()
                {
                    return wrong(place(&format!("series.{series}")), fault);
                }
                known.push(series);
            }
            for (panel, input) in &item.panel {
                let mut drawn = input.layer.iter().map(|(_, layer)| layer.series());
                if let Some(unknown) = drawn.find(|series| !known.contains(series)) {
                    return wrong(place(&format!("panel.{panel}")), &format!("no series `{unknown}`"));
                }
            }
        }
        for (name, claim) in &self.claims {
            let place = || format!("claims.toml: claim.{name}");
            if let Some(fault) = claim.fault() {
                return wrong(place(), fault);
            }
            let Some(item) = self.definition.item.get(&claim.item) else {
                return wrong(place(), &format!("no item `{}`", claim.item));
            };
            if let Some(unknown) = claim.measured.series().into_iter().find(|series| item.series.get(series).is_none())
            {
                return wrong(place(), &format!("no series `{unknown}` in {}", claim.item));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_studies_are_right() {
        for name in library::names() {
            let study = library::published(name).unwrap().unwrap();
            assert!(!study.definition.item.0.is_empty(), "{name}");
            for (item, input) in &study.definition.item {
                for name in input.inputs() {
                    for quick in [false, true] {
                        let point = point::StudyPoint::new(&study, &name, quick).unwrap();
                        assert!(!point.file.input.measure.is_empty(), "{item}: {name} measures nothing");
                    }
                }
            }
        }
    }
}
