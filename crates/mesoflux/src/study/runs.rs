//! What the finished runs of an input hold: estimates and tables, row by row, with names for every number.

use super::StudyError;
use super::table::{Cell, Cells, rows};
use mesoflux_io::input::InputFile;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The directory of an input's finished runs.
pub struct FinishedRuns {
    directory: PathBuf,
    /// The input at each point of its sweep, defaults filled in.
    points: Vec<toml::Table>,
    results: Value,
}

/// One row of numbers.
pub struct Row<'a> {
    cells: Cells,
    input: &'a toml::Table,
    /// What the run says beside the numbers, or why there are none.
    pub warnings: Vec<String>,
}

impl Row<'_> {
    /// The number of a name: a column, or else the path of a key in the input.
    pub fn number(&self, name: &str) -> Option<Cell> {
        let column = self.cells.iter().find(|(own, _)| own == name).map(|(_, cell)| *cell);
        column.or_else(|| {
            let mut keys = name.split('.');
            let first = self.input.get(keys.next()?)?;
            let value = keys.try_fold(first, |value, key| match value.as_array() {
                Some(numbers) => numbers.get(key.parse::<usize>().ok()?),
                None => value.get(key),
            })?;
            let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))?;
            Some(Cell { value: Some(number), error: Some(0.0) })
        })
    }
}

impl FinishedRuns {
    /// Reads what the runs of an input have left in a directory.
    ///
    /// # Errors
    /// Results that can't be read.
    pub fn read(file: &InputFile, directory: &Path) -> Result<Self, StudyError> {
        let path = directory.join("results.json");
        let text = std::fs::read_to_string(&path).map_err(|source| StudyError::read(&path, source))?;
        let results = serde_json::from_str(&text).map_err(|error| StudyError::read(&path, error.into()))?;
        let point = |point| Ok(toml::Table::try_from(file.at(point)?.with_defaults()).unwrap_or_default());
        let points = file.sweep.points.iter().map(point).collect::<Result<_, StudyError>>()?;
        Ok(Self { directory: directory.to_owned(), points, results })
    }

    /// The estimates of `measurement/method`, one for each point of the sweep.
    pub fn estimates(&self, of: &str) -> Vec<Row<'_>> {
        let (measurement, method) = of.split_once('/').unwrap_or((of, ""));
        let all = self.results["estimates"].as_array().map(Vec::as_slice).unwrap_or_default();
        let wanted = all.iter().filter(|record| record["measurement"] == measurement && record["method"] == method);
        wanted.zip(&self.points).map(|(record, input)| estimate(record, input)).collect()
    }

    /// The rows of a table at every point of the sweep, and the names of those that the runs didn't write.
    ///
    /// # Errors
    /// A table that can't be read.
    pub fn table(&self, name: &str) -> Result<(Vec<Row<'_>>, Vec<String>), StudyError> {
        let (mut found, mut absent) = (Vec::new(), Vec::new());
        for (index, input) in self.points.iter().enumerate() {
            let name = if self.points.len() == 1 {
                name.to_owned()
            } else {
                let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "csv"));
                format!("{stem}-{}.{extension}", index + 1)
            };
            let path = self.directory.join(&name);
            if !path.exists() {
                absent.push(name);
                continue;
            }
            let text = std::fs::read_to_string(&path).map_err(|source| StudyError::read(&path, source))?;
            let row = |cells| Row { cells, input, warnings: Vec::new() };
            found.extend(rows(&text).into_iter().map(row));
        }
        Ok((found, absent))
    }
}

/// An estimate as a row: `value` with its error, and its conditions.
fn estimate<'a>(record: &Value, input: &'a toml::Table) -> Row<'a> {
    let value = Cell { value: record["value"].as_f64(), error: record["standard_error"].as_f64() };
    let conditions = record["conditions"].as_object().into_iter().flatten();
    let error = |name: &str| record["conditions"][format!("{name}_standard_error")].as_f64().unwrap_or(0.0);
    let mut cells = vec![("value".to_owned(), value)];
    cells.extend(
        conditions
            .filter(|(_, value)| value.is_number())
            .map(|(name, value)| (name.clone(), Cell { value: value.as_f64(), error: Some(error(name)) })),
    );
    let warnings = record["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    Row { cells, input, warnings: warnings.map(str::to_owned).collect() }
}
