//! What a study's files say: `study.toml` with its items, series and panels, as plain structs; no code runs from them.

use serde::de::{Deserialize, Deserializer, Error};
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// `study.toml`.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyInput {
    /// What is studied, in one line.
    pub title: String,
    /// The publication.
    pub source: String,
    /// What shortens each input in the quick form: keys of the input with their values.
    #[serde(default)]
    pub quick: BTreeMap<String, toml::Table>,
    /// The figures and tables.
    pub item: InOrder<ItemInput>,
}

/// `[item.NAME]`: a figure or table of the publication.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ItemInput {
    /// What it shows.
    pub title: String,
    /// Panels side by side.
    #[serde(default = "two")]
    pub columns: usize,
    /// Data by name, each written as a CSV file.
    pub series: InOrder<SeriesInput>,
    /// What is drawn; nothing for a table.
    #[serde(default)]
    pub panel: InOrder<PanelInput>,
}

fn two() -> usize {
    2
}

/// Where a series comes from.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SeriesInput {
    /// Estimates of a measurement by a method, `of = "mobility/norton"`, one for each point of the input's sweep.
    Estimates(FromRuns),
    /// Rows of a table beside the results, `of = "mobility-norton.csv"`, at every point of the sweep. Its name is the one that it has
    /// without a sweep.
    Table(FromRuns),
    /// A series over another.
    Ratio(RatioInput),
    /// A series times a constant and a power of x.
    Product(ProductInput),
    /// Numbers that the publication gives.
    Published(PublishedInput),
}

/// Numbers out of run directories, one point a row.
///
/// A *name* is a column of the table (without its unit), or `value` for estimates; or one of an estimate's conditions; or else the path of a
/// key in the input, such as `system.particles` or `system.box.0`, with its value at the sweep's point. The standard error of a column is the
/// column `standard_error` right after it; one that has none is exact.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FromRuns {
    /// The inputs whose runs are read, one after the other.
    pub input: Names,
    /// Which estimates or table.
    pub of: String,
    /// The name of x; the rows are numbered if it's left out.
    pub x: Option<String>,
    /// x is multiplied by these names' values to these powers; all errors count as independent.
    #[serde(default)]
    pub x_times: BTreeMap<String, f64>,
    /// The name of y.
    #[serde(default = "value")]
    pub y: String,
    /// y is multiplied by these names' values to these powers; all errors count as independent.
    #[serde(default)]
    pub times: BTreeMap<String, f64>,
    /// y is multiplied by this constant.
    #[serde(default = "one")]
    pub factor: f64,
    /// Only rows in which these names have this value, or one in `[low, high]`.
    #[serde(default, rename = "where")]
    pub only: toml::Table,
}

fn value() -> String {
    "value".to_owned()
}

fn one() -> f64 {
    1.0
}

/// `ratio = { … }`: at each x of the numerator, with the denominator interpolated in log–log where it has no point at that x.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RatioInput {
    /// The series above.
    pub numerator: String,
    /// The series below.
    pub denominator: String,
}

/// `product = { … }`: y · factor · x^power.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProductInput {
    /// The series.
    pub of: String,
    /// The constant.
    #[serde(default = "one")]
    pub factor: f64,
    /// The exponent of x.
    #[serde(default)]
    pub power: f64,
}

/// `published = { … }`: points as they are printed, to be drawn or compared with.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedInput {
    /// x of every point.
    pub x: Vec<f64>,
    /// y of every point.
    pub y: Vec<f64>,
    /// The standard errors of y; exact if left out.
    #[serde(default)]
    pub y_error: Vec<f64>,
}

impl PublishedInput {
    /// What is wrong with it.
    pub fn fault(&self) -> Option<&'static str> {
        let count = self.x.len();
        if self.y.len() != count || !(self.y_error.is_empty() || self.y_error.len() == count) {
            return Some("x, y and y_error must have as many numbers each");
        }
        let finite = self.x.iter().chain(&self.y).all(|number| number.is_finite());
        let errors = self.y_error.iter().all(|error| *error >= 0.0 && error.is_finite());
        (!(finite && errors)).then_some("every number must be finite, every error at least zero")
    }
}

/// `[item.NAME.panel.NAME]`.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelInput {
    /// Above the panel.
    #[serde(default)]
    pub title: String,
    /// The horizontal axis.
    pub x: AxisInput,
    /// The vertical axis.
    pub y: AxisInput,
    /// What is drawn, from below to above.
    pub layer: InOrder<LayerInput>,
}

/// An axis.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisInput {
    /// What it shows.
    pub label: String,
    /// Whether it is logarithmic.
    #[serde(default)]
    pub logarithmic: bool,
    /// From where to where; what the data need if left out.
    pub range: Option<Range>,
}

/// Something drawn in a panel.
#[derive(Debug, Clone, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LayerInput {
    /// The points of a series with their errors.
    Points {
        /// The series.
        series: String,
        /// For the legend.
        label: String,
    },
    /// The points of a series, joined.
    Line {
        /// The series.
        series: String,
        /// For the legend.
        label: String,
        /// Whether the line is dashed.
        #[serde(default)]
        dashed: bool,
    },
    /// The points of a series as bars.
    Histogram {
        /// The series.
        series: String,
        /// For the legend.
        label: String,
    },
    /// The dashed line y = a x, with a the only point of a series.
    Slope {
        /// The series.
        series: String,
        /// For the legend; the slope is added.
        label: String,
    },
    /// The dashed line y ∝ x^exponent through a series at its point nearest to `at`.
    PowerLaw {
        /// The exponent.
        exponent: f64,
        /// The series.
        series: String,
        /// Which of its points.
        at: f64,
        /// For the legend.
        label: String,
    },
}

impl LayerInput {
    /// The series that it shows.
    pub fn series(&self) -> &str {
        match self {
            Self::Points { series, .. }
            | Self::Line { series, .. }
            | Self::Histogram { series, .. }
            | Self::Slope { series, .. }
            | Self::PowerLaw { series, .. } => series,
        }
    }

    /// What the legend calls it. Layers of one label have one color throughout the item.
    pub fn label(&self) -> &str {
        match self {
            Self::Points { label, .. }
            | Self::Line { label, .. }
            | Self::Histogram { label, .. }
            | Self::Slope { label, .. }
            | Self::PowerLaw { label, .. } => label,
        }
    }

    /// Whether it shows the points of a series rather than a line to compare them with.
    pub fn is_data(&self) -> bool {
        matches!(self, Self::Points { .. } | Self::Line { .. } | Self::Histogram { .. })
    }
}

impl ItemInput {
    /// The names of the inputs that it needs, each once.
    pub fn inputs(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (_, series) in &self.series {
            if let SeriesInput::Estimates(wanted) | SeriesInput::Table(wanted) = series {
                for name in &wanted.input.0 {
                    if !names.contains(name) {
                        names.push(name.clone());
                    }
                }
            }
        }
        names
    }

    /// The place of a label among all labels of the item.
    pub fn place_of(&self, label: &str) -> usize {
        let mut labels: Vec<&str> = Vec::new();
        for (_, layer) in self.panel.iter().flat_map(|(_, panel)| panel.layer.iter()) {
            if !labels.contains(&layer.label()) {
                labels.push(layer.label());
            }
        }
        labels.iter().position(|own| *own == label).unwrap_or(0)
    }
}

/// Named entries in the order in which the file has them.
#[derive(Debug, Clone)]
pub struct InOrder<T>(pub Vec<(String, T)>);

impl<T> Default for InOrder<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> InOrder<T> {
    /// The entry of a name.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.iter().find(|(own, _)| own == name).map(|(_, entry)| entry)
    }

    /// Names and entries.
    pub fn iter(&self) -> std::slice::Iter<'_, (String, T)> {
        self.0.iter()
    }

    /// The names.
    pub fn names(&self) -> Vec<&str> {
        self.iter().map(|(name, _)| name.as_str()).collect()
    }
}

impl<'a, T> IntoIterator for &'a InOrder<T> {
    type Item = &'a (String, T);
    type IntoIter = std::slice::Iter<'a, (String, T)>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for InOrder<T> {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        let entries = BTreeMap::<String, Spanned<T>>::deserialize(input)?;
        let mut entries: Vec<(String, Spanned<T>)> = entries.into_iter().collect();
        entries.sort_by_key(|(_, entry)| entry.span().start);
        Ok(Self(entries.into_iter().map(|(name, entry)| (name, entry.into_inner())).collect()))
    }
}

/// One name, or an array of names.
#[derive(Debug, Clone)]
pub struct Names(pub Vec<String>);

impl<'de> Deserialize<'de> for Names {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        let word = |value: &Value| value.as_str().map(str::to_owned);
        let names = match Value::deserialize(input)? {
            Value::Array(values) => values.iter().map(word).collect(),
            value => word(&value).map(|name| vec![name]),
        };
        names.map(Self).ok_or_else(|| D::Error::custom("must be a name, or an array of names"))
    }
}

/// Numbers from `low` to `high`, both included: `[low, high]`, or one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The lowest.
    pub low: f64,
    /// The highest.
    pub high: f64,
}

/// Numbers that agree to so many parts are the same number.
const SAME: f64 = 1e-9;

impl Range {
    /// What a value of a file says.
    pub fn of(value: &Value) -> Option<Self> {
        let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        let (low, high) = match value.as_array().map(Vec::as_slice) {
            Some([low, high]) => (number(low)?, number(high)?),
            Some(_) => return None,
            None => (number(value)?, number(value)?),
        };
        (low <= high).then_some(Self { low, high })
    }

    /// Whether a number lies in it, but for rounding.
    pub fn contains(&self, number: f64) -> bool {
        let slack = SAME * number.abs();
        self.low - slack <= number && number <= self.high + slack
    }
}

impl<'de> Deserialize<'de> for Range {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        Self::of(&Value::deserialize(input)?).ok_or_else(|| D::Error::custom("must be a number, or [low, high]"))
    }
}

/// The leaves of a table with their dotted paths.
pub fn leaves(table: &toml::Table) -> Vec<(String, &Value)> {
    let mut found = Vec::new();
    for (key, value) in table {
        match value {
            Value::Table(inner) => {
                found.extend(leaves(inner).into_iter().map(|(path, value)| (format!("{key}.{path}"), value)));
            }
            value => found.push((key.clone(), value)),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_the_order_of_the_file() {
        let text = "[b]\nx = 1\n[a]\nx = 2\n[c.d]\nx = 3";
        let table: InOrder<toml::Table> = toml::from_str(text).unwrap();
        assert_eq!(table.names(), ["b", "a", "c"]);
        let dotted: InOrder<Value> = toml::from_str("z.points = 1\ny.line = { a = 2 }\nx = 3").unwrap();
        assert_eq!(dotted.names(), ["z", "y", "x"]);
    }

    #[test]
    fn paths_of_nested_tables() {
        let table: toml::Table = toml::from_str("run.seed = 1\n[measure.a.routes]\nnemd.magnitude = [1.0]").unwrap();
        let paths: Vec<String> = leaves(&table).into_iter().map(|(path, _)| path).collect();
        assert_eq!(paths, ["measure.a.routes.nemd.magnitude", "run.seed"]);
    }

    #[test]
    fn a_range_is_a_number_or_two() {
        let range = |text: &str| Range::of(&text.parse().unwrap());
        assert_eq!(range("0.3"), Some(Range { low: 0.3, high: 0.3 }));
        assert!(range("0.3").unwrap().contains(0.1 + 0.2));
        assert_eq!(range("[1, 2.5]"), Some(Range { low: 1.0, high: 2.5 }));
        for wrong in ["[2, 1]", "[1]", "\"a\"", "[1, 2, 3]"] {
            assert_eq!(range(wrong), None, "{wrong}");
        }
    }
}
