//! Verdicts: what is measured against what is claimed.

use super::claim::{Claim, Finding};
use serde::{Deserialize, Serialize};

/// The largest |z| that noise may explain.
pub const LIMIT: f64 = 2.5;

/// What becomes of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// |z| ≤ 2.5, and the standard error is as small as required.
    #[serde(rename = "holds")]
    Holds,
    /// |z| > 2.5.
    #[serde(rename = "fails")]
    Fails,
    /// Neither: the error is too large, or there is no number.
    #[serde(rename = "cannot tell")]
    CannotTell,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::CannotTell => "cannot tell",
        })
    }
}

/// On which side of `expected` the number must lie, if not at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Above it.
    Above,
    /// Below it.
    Below,
}

/// An entry of `verdicts.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The figure or table.
    pub item: String,
    /// The claim.
    pub claim: String,
    /// What the number must be, or the bound.
    pub expected: f64,
    /// For a bound, the side on which the number must lie.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// The number; null if it can't be told.
    pub measured: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// The standard error that is required; for a bound no more than the distance from it over 2.5.
    pub required_error: f64,
    /// The difference over its error; for a bound how far beyond it the number lies, 0 on the right side.
    pub z: Option<f64>,
    /// What follows.
    pub verdict: Verdict,
    /// What a reader must know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// What the runs warn of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// What a claim expects.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Expectation {
    Value(f64),
    Bound(Side, f64),
}

impl Claim {
    fn expectation(&self) -> Option<Expectation> {
        match (self.expected, self.above, self.below) {
            (Some(value), None, None) => Some(Expectation::Value(value)),
            (None, Some(bound), None) => Some(Expectation::Bound(Side::Above, bound)),
            (None, None, Some(bound)) => Some(Expectation::Bound(Side::Below, bound)),
            _ => None,
        }
    }

    /// What is wrong with it, if anything.
    pub fn fault(&self) -> Option<&'static str> {
        let numbers = [self.expected, self.above, self.below].into_iter().flatten();
        if self.expectation().is_none() {
            Some("must have exactly one of `expected`, `above`, `below`")
        } else if !(self.required_error > 0.0 && numbers.chain([self.required_error]).all(f64::is_finite)) {
            Some("`required_error` must be positive, and every number finite")
        } else if !(self.expected_error >= 0.0 && self.expected_error.is_finite()) {
            Some("`expected_error` must be at least zero and finite")
        } else {
            None
        }
    }

    /// Judges what was found.
    ///
    /// A claim holds if |z| ≤ 2.5 and the standard error is no larger than required, fails if |z| > 2.5, and can't be told otherwise.
    ///
    /// A bound asks on which side the number lies. On the wrong side z is the distance from the bound over its error, on the right
    /// side 0. But a number nearer to the bound than 2.5 standard errors doesn't tell the sides apart: the error that is required is
    /// therefore the distance over 2.5, if that is less than the claim's own.
    pub fn judge(&self, found: Result<Finding, String>) -> Judged {
        let (expected, side) = match self.expectation() {
            Some(Expectation::Bound(side, bound)) => (bound, Some(side)),
            Some(Expectation::Value(value)) => (value, None),
            None => (0.0, None),
        };
        let mut judged = Judged {
            item: self.item.clone(),
            claim: self.text.clone(),
            expected,
            side,
            measured: None,
            standard_error: None,
            required_error: self.required_error,
            z: None,
            verdict: Verdict::CannotTell,
            note: None,
            warnings: Vec::new(),
        };
        let finding = match found {
            Ok(finding) if finding.value.is_finite() && finding.standard_error.is_finite() => finding,
            Ok(_) => {
                judged.note = Some("there is no finite number".to_owned());
                return judged;
            }
            Err(reason) => {
                judged.note = Some(reason);
                return judged;
            }
        };
        let mut notes = finding.notes;
        judged.warnings = finding.warnings;
        judged.measured = Some(finding.value);
        judged.standard_error = Some(finding.standard_error);
        let difference = finding.value - expected;
        let error = finding.standard_error.hypot(self.expected_error);
        let beyond = match side {
            None => difference,
            Some(Side::Above) => difference.min(0.0),
            Some(Side::Below) => difference.max(0.0),
        };
        if error > 0.0 {
            let z = finding.violation.unwrap_or(beyond / error);
            judged.z = Some(z);
            if side.is_some() && finding.violation.is_none() {
                judged.required_error = self.required_error.min(difference.abs() / LIMIT);
            }
            judged.verdict = if z.abs() > LIMIT {
                Verdict::Fails
            } else if finding.standard_error <= judged.required_error {
                Verdict::Holds
            } else {
                Verdict::CannotTell
            };
        } else if side.is_some() {
            // What is exact, such as the chance of a test, lies on one side of a bound or on the other.
            judged.verdict = if beyond == 0.0 { Verdict::Holds } else { Verdict::Fails };
        } else {
            notes.push("the number has no error".to_owned());
        }
        judged.note = (!notes.is_empty()).then(|| notes.join("; "));
        judged
    }
}

/// The verdicts of before with those of an item replaced, in the order of `items`; those of other items are dropped.
pub fn replaced(before: Vec<Judged>, item: &str, new: Vec<Judged>, items: &[&str]) -> Vec<Judged> {
    let mut all: Vec<Judged> = before.into_iter().filter(|entry| entry.item != item).chain(new).collect();
    let place = |entry: &Judged| items.iter().position(|item| *item == entry.item);
    all.retain(|entry| place(entry).is_some());
    all.sort_by_key(place);
    all
}
