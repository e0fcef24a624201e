//! What can be wrong with the arguments of this crate's functions.

/// Input refused by an accumulator, a fit or a test. Each message names the value and the requirement.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A parameter lies outside its range.
    #[error("{name} = {value}: must be {requirement}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is asked for.
        requirement: &'static str,
    },
    /// An array has the wrong length.
    #[error("{name} has {found} entries: must have {expected}")]
    Length {
        /// The array.
        name: &'static str,
        /// Its length.
        found: usize,
        /// The length asked for.
        expected: usize,
    },
    /// An entry of an array is infinite or not a number.
    #[error("{name}[{index}] = {value}: must be finite")]
    NotFinite {
        /// The array.
        name: &'static str,
        /// Where in the array.
        index: usize,
        /// What was given.
        value: f64,
    },
    /// Two accumulators that describe different measurements can't be merged.
    #[error("cannot merge: {name} is {left} in one and {right} in the other")]
    Mismatch {
        /// The parameter that differs.
        name: &'static str,
        /// Its value in the accumulator merged into.
        left: f64,
        /// Its value in the other.
        right: f64,
    },
    /// The data don't determine what is asked for.
    #[error("{0}")]
    Underdetermined(&'static str),
}

/// Refuses the first entry of `values` that is infinite or not a number.
pub(crate) fn require_finite(name: &'static str, values: &[f64]) -> Result<(), AnalysisError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(AnalysisError::NotFinite { name, index, value: values[index] }),
        None => Ok(()),
    }
}

/// Refuses an array of another length.
pub(crate) fn require_length(name: &'static str, found: usize, expected: usize) -> Result<(), AnalysisError> {
    if found == expected { Ok(()) } else { Err(AnalysisError::Length { name, found, expected }) }
}
