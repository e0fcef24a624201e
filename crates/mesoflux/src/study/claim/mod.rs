//! Claims of a publication: what is measured to check each, one file a kind, and what is expected.

mod agreement;
mod exponent;
mod exponent_with_correction;
mod local_exponents;
mod monotonic;
mod ratio;
mod value;

use super::definition::InOrder;
use super::series::Series;
use std::collections::BTreeMap;

/// `claims.toml`.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimsInput {
    /// The claims by name.
    #[serde(default)]
    pub claim: InOrder<Claim>,
}

/// `[claim.NAME]`: a sentence of a publication that a number can confirm or refute.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The item that it's about.
    pub item: String,
    /// The sentence.
    pub text: String,
    /// The number.
    pub measured: Kind,
    /// What the number must be; or else one of the next two.
    pub expected: Option<f64>,
    /// What it must lie above.
    pub above: Option<f64>,
    /// What it must lie below.
    pub below: Option<f64>,
    /// The standard error of `expected`; 0 if it is exact.
    #[serde(default)]
    pub expected_error: f64,
    /// The largest standard error with which the claim can hold.
    pub required_error: f64,
}

/// What is measured. Windows are ranges of x; a point that is missing in one leaves the claim untold.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The value of a series at a point.
    Value(value::Value),
    /// The relative difference of two series.
    Agreement(agreement::Agreement),
    /// The exponent p of y ∝ x^p.
    Exponent(exponent::Exponent),
    /// The exponent p of y ∝ x^p (1 + b x^q).
    ExponentWithCorrection(exponent_with_correction::ExponentWithCorrection),
    /// The slope from the last point but one to the last.
    LocalExponents(local_exponents::LocalExponents),
    /// The trend of a series that must have no step against it.
    Monotonic(monotonic::Monotonic),
    /// One series over another.
    Ratio(ratio::Ratio),
}

/// What was found for a claim.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Finding {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Something seen beside the number that refutes the claim, in units of its error.
    pub violation: Option<f64>,
    /// What a reader must know.
    pub notes: Vec<String>,
    /// What the runs warn of.
    pub warnings: Vec<String>,
}

/// The series of an item by name.
pub type Data = BTreeMap<String, Series>;

impl Kind {
    /// Measures it; what the runs warn of goes with it.
    ///
    /// # Errors
    /// Why it can't be told.
    pub fn measure(&self, data: &Data) -> Result<Finding, String> {
        let mut finding = self.number(data)?;
        for series in self.series().into_iter().filter_map(|name| data.get(name)) {
            finding.warnings.extend(series.warnings.iter().cloned());
        }
        Ok(finding)
    }

    fn number(&self, data: &Data) -> Result<Finding, String> {
        match self {
            Self::Value(kind) => kind.measure(data),
            Self::Agreement(kind) => kind.measure(data),
            Self::Exponent(kind) => kind.measure(data),
            Self::ExponentWithCorrection(kind) => kind.measure(data),
            Self::LocalExponents(kind) => kind.measure(data),
            Self::Monotonic(kind) => kind.measure(data),
            Self::Ratio(kind) => kind.measure(data),
        }
    }

    /// The series that it needs.
    pub fn series(&self) -> Vec<&str> {
        match self {
            Self::Value(kind) => vec![&kind.of],
            Self::Agreement(kind) => kind.between.iter().map(String::as_str).collect(),
            Self::Exponent(kind) => vec![&kind.of],
            Self::ExponentWithCorrection(kind) => vec![&kind.of],
            Self::LocalExponents(kind) => vec![&kind.of],
            Self::Monotonic(kind) => vec![&kind.of],
            Self::Ratio(kind) => vec![&kind.numerator, &kind.denominator],
        }
    }
}

fn series<'a>(data: &'a Data, name: &str) -> Result<&'a Series, String> {
    data.get(name).ok_or_else(|| format!("there is no series `{name}`"))
}

/// What to say of errors that were made larger.
fn inflated(excess: f64) -> String {
    format!("the points scatter {excess:.1} times as much as their errors allow; the error is larger by that")
}

#[cfg(test)]
mod tests;
