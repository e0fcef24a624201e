//! The series of an item, collected from finished runs as `study.toml` says.

use super::StudyError;
use super::claim::Data;
use super::comparison::Comparison;
use super::definition::{FromRuns, ItemInput, ProductInput, PublishedInput, Range, RatioInput, SeriesInput, leaves};
use super::runs::{FinishedRuns, Row};
use super::series::{Missing, Point, Series};
use super::table::Cell;
use std::collections::BTreeMap;

/// The finished runs of inputs, by the inputs' names.
pub type Finished = BTreeMap<String, FinishedRuns>;

/// All series of an item; one that is made of others comes after them in the file.
///
/// # Errors
/// Runs that can't be read, or that know nothing of what is asked for.
pub fn series(item: &ItemInput, finished: &Finished) -> Result<Data, StudyError> {
    let mut data = Data::new();
    for (name, input) in &item.series {
        let wrong = |reason: String| StudyError::Wrong(format!("series `{name}`: {reason}"));
        let found = match input {
            SeriesInput::Estimates(wanted) => estimates(wanted, finished).map_err(wrong)?,
            SeriesInput::Table(wanted) => table(wanted, finished)?.map_err(wrong)?,
            SeriesInput::Ratio(RatioInput { numerator, denominator }) => ratio(&data, numerator, denominator),
            SeriesInput::Product(product) => product_of(&data, product),
            SeriesInput::Published(published) => as_printed(published),
        };
        data.insert(name.clone(), found);
    }
    Ok(data)
}

fn estimates(wanted: &FromRuns, finished: &Finished) -> Result<Series, String> {
    let mut collected = Collected::new(wanted);
    for runs in wanted.input.0.iter().filter_map(|name| finished.get(name)) {
        runs.estimates(&wanted.of).iter().try_for_each(|row| collected.add(row))?;
    }
    Ok(collected.finish())
}

fn table(wanted: &FromRuns, finished: &Finished) -> Result<Result<Series, String>, StudyError> {
    let mut collected = Collected::new(wanted);
    for runs in wanted.input.0.iter().filter_map(|name| finished.get(name)) {
        let (rows, absent) = runs.table(&wanted.of)?;
        let missing = |name| Missing { x: None, reason: format!("the runs could tell too little to write {name}") };
        collected.series.missing.extend(absent.into_iter().map(missing));
        if let Err(reason) = rows.iter().try_for_each(|row| collected.add(row)) {
            return Ok(Err(reason));
        }
    }
    Ok(Ok(collected.finish()))
}

/// Points on their way into a series.
struct Collected<'a> {
    wanted: &'a FromRuns,
    only: Vec<(String, Option<Range>)>,
    series: Series,
    rows: usize,
}

impl<'a> Collected<'a> {
    fn new(wanted: &'a FromRuns) -> Self {
        let only = leaves(&wanted.only).into_iter().map(|(name, value)| (name, Range::of(value))).collect();
        Self { wanted, only, series: Series::default(), rows: 0 }
    }

    fn add(&mut self, row: &Row) -> Result<(), String> {
        let number = |name: &str| row.number(name).ok_or_else(|| format!("there is no `{name}` in {}", self.wanted.of));
        for (name, range) in &self.only {
            let value = number(name)?.value;
            if !range.zip(value).is_some_and(|(range, value)| range.contains(value)) {
                return Ok(());
            }
        }
        self.rows += 1;
        let with_factors = |name: &str, times: &BTreeMap<String, f64>| -> Result<_, String> {
            let mut factors = vec![(number(name)?, 1.0)];
            for (name, &power) in times {
                factors.push((number(name)?, power));
            }
            Ok(product(&factors))
        };
        let x = match &self.wanted.x {
            Some(name) => with_factors(name, &self.wanted.x_times)?,
            None => Some((self.rows as f64, 0.0)),
        };
        let factor = self.wanted.factor;
        let y = with_factors(&self.wanted.y, &self.wanted.times)?;
        let y = y.map(|(y, y_error)| (factor * y, factor.abs() * y_error));
        // A row's number says nothing to a reader.
        let place = x.map(|(x, _)| x).filter(|_| self.wanted.x.is_some());
        match (x, y) {
            (Some((x, x_error)), Some((y, y_error))) if y.is_finite() && y_error.is_finite() => {
                self.series.points.push(Point { x, x_error, y, y_error });
                let at = place.map_or_else(String::new, |x| format!(" at {x}"));
                let warnings = row.warnings.iter().map(|warning| format!("{}{at}: {warning}", self.wanted.of));
                self.series.warnings.extend(warnings);
            }
            _ => {
                let unknown = || format!("{} has no number with an error there", self.wanted.of);
                let reason = if row.warnings.is_empty() { unknown() } else { row.warnings.join("; ") };
                self.series.missing.push(Missing { x: place, reason });
            }
        }
        Ok(())
    }

    fn finish(self) -> Series {
        let Series { points, missing, warnings } = self.series;
        Series { warnings, ..Series::new(points, missing) }
    }
}

/// Π a^power with its error, s² = Σ (∂/∂a s_a)²; nothing where a number or its error is missing.
fn product(factors: &[(Cell, f64)]) -> Option<(f64, f64)> {
    let known = |(cell, power): &(Cell, f64)| Some((cell.value?, cell.error?, *power));
    let factors: Vec<(f64, f64, f64)> = factors.iter().map(known).collect::<Option<_>>()?;
    let derived_by = |own: Option<usize>| -> f64 {
        let raised = factors.iter().enumerate().map(|(k, &(value, _, power))| {
            if own == Some(k) { power * value.powf(power - 1.0) } else { value.powf(power) }
        });
        raised.product()
    };
    let variance: f64 = (0..factors.len()).map(|k| (derived_by(Some(k)) * factors[k].1).powi(2)).sum();
    Some((derived_by(None), variance.sqrt()))
}

fn ratio(data: &Data, numerator: &str, denominator: &str) -> Series {
    let parts = [numerator, denominator].map(|name| data.get(name).cloned().unwrap_or_default());
    let mut missing: Vec<Missing> = parts.iter().flat_map(|part| part.missing.clone()).collect();
    let warnings = parts.iter().flat_map(|part| part.warnings.clone()).collect();
    let series = match Comparison::new(&parts[0].points, &parts[1].points) {
        Ok(comparison) => Series::new(comparison.points, missing),
        Err(reason) => {
            missing.push(Missing { x: None, reason });
            Series::new(Vec::new(), missing)
        }
    };
    Series { warnings, ..series }
}

fn product_of(data: &Data, product: &ProductInput) -> Series {
    let of = data.get(&product.of).cloned().unwrap_or_default();
    let scaled = |p: &Point| {
        let scale = product.factor * p.x.powf(product.power);
        // The error of x reaches the product through its power.
        let through_x = if product.power == 0.0 { 0.0 } else { product.power * p.y / p.x * p.x_error };
        Point { y: p.y * scale, y_error: scale.abs() * p.y_error.hypot(through_x), ..*p }
    };
    Series { points: of.points.iter().map(scaled).collect(), ..of }
}

fn as_printed(published: &PublishedInput) -> Series {
    let error = |k: usize| published.y_error.get(k).copied().unwrap_or(0.0);
    let numbers = published.x.iter().zip(&published.y).enumerate();
    let points = numbers.map(|(k, (&x, &y))| Point { x, x_error: 0.0, y, y_error: error(k) });
    Series::new(points.collect(), Vec::new())
}
