//! `[sweep]`: keys of the input with several values; every combination is a point.

use super::document::Setting;
use super::{Input, Invalid};
use std::collections::BTreeMap;

/// The most points a sweep may have: more is a slip of the pen.
const MOST_POINTS: f64 = 10_000.0;

/// One combination of values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Point {
    /// The settings that lead from the input to this point.
    pub settings: Vec<Setting>,
    /// The same as values, by path, for the results.
    pub values: BTreeMap<String, toml::Value>,
}

/// All points of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// In the order in which the last key varies fastest.
    pub points: Vec<Point>,
}

impl Default for Sweep {
    fn default() -> Self {
        Self { points: vec![Point::default()] }
    }
}

impl Sweep {
    /// The points that an input asks for.
    pub(super) fn of(input: &Input) -> Result<Self, Invalid> {
        let mut axes = Vec::new();
        collect("", &input.sweep, &mut axes)?;
        let count: f64 = axes.iter().map(|(_, values)| values.len() as f64).product();
        if count > MOST_POINTS {
            return Err(Invalid::new("sweep", "", format!("has {count} points: must be at most {MOST_POINTS}")));
        }
        let mut points = vec![Point::default()];
        for (path, values) in axes {
            points = points
                .iter()
                .flat_map(|point| {
                    values.iter().map(|value| {
                        let mut point = point.clone();
                        point.settings.push(Setting { path: path.clone(), value: value.to_string() });
                        point.values.insert(path.clone(), value.clone());
                        point
                    })
                })
                .collect();
        }
        Ok(Self { points })
    }
}

/// The arrays at the leaves of a table, with their paths.
fn collect(prefix: &str, table: &toml::Table, axes: &mut Vec<(String, Vec<toml::Value>)>) -> Result<(), Invalid> {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) => collect(&path, inner, axes)?,
            toml::Value::Array(values) if !values.is_empty() => {
                if let Some(again) = (1..values.len()).find(|&index| values[..index].contains(&values[index])) {
                    return Err(Invalid::new(
                        format!("sweep.{path}.{again}"),
                        &values[again],
                        "must not be given twice",
                    ));
                }
                axes.push((path, values.clone()));
            }
            other => {
                return Err(Invalid::new(format!("sweep.{path}"), other, "must be an array of the values to try"));
            }
        }
    }
    Ok(())
}
