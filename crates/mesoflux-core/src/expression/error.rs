//! What is wrong with an expression, and where.

use std::fmt;
use std::ops::Range;

/// Where something is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// In the text, at these bytes.
    Text(Range<usize>),
    /// In the whole expression.
    Whole,
    /// At the parameter of this name.
    Parameter(String),
}

/// A name that isn't known, for those who want to guess which was meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// The name.
    pub name: String,
    /// All that are known there.
    pub known: Vec<String>,
}

/// An expression that can't be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpressionError {
    /// The text.
    pub text: String,
    /// Where in it, or beside it.
    pub place: Place,
    /// What is required.
    pub requirement: String,
    /// A name that isn't known.
    pub unknown: Option<Box<Unknown>>,
    /// What might help.
    pub help: Option<String>,
}

impl ExpressionError {
    pub(super) fn new(text: &str, place: Place, requirement: impl Into<String>) -> Self {
        Self { text: text.to_owned(), place, requirement: requirement.into(), unknown: None, help: None }
    }

    /// A fault that no single character has.
    pub(crate) fn whole(text: &str, requirement: impl Into<String>) -> Self {
        Self::new(text, Place::Whole, requirement)
    }

    /// A parameter with a name that has a meaning already.
    pub(crate) fn taken_name(text: &str, name: &str) -> Self {
        let requirement = "must have another name: this one has a meaning already";
        Self::new(text, Place::Parameter(name.to_owned()), requirement)
    }

    pub(super) fn helped(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The expression with carets under the place, where there is one.
    pub fn caret(&self) -> Option<String> {
        let Place::Text(range) = &self.place else { return None };
        let before = self.text.get(..range.start)?.chars().count();
        let width = self.text.get(range.clone())?.chars().count().max(1);
        Some(format!("{}\n{}{}", self.text, " ".repeat(before), "^".repeat(width)))
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.place {
            Place::Text(range) => {
                let before = self.text.get(..range.start).map_or(0, |text| text.chars().count());
                write!(f, "character {}: {}", before + 1, self.requirement)?;
            }
            Place::Whole => write!(f, "{}", self.requirement)?,
            Place::Parameter(name) => write!(f, "parameter {name}: {}", self.requirement)?,
        }
        self.caret().map_or(Ok(()), |caret| write!(f, "\n{caret}"))
    }
}

impl std::error::Error for ExpressionError {}
