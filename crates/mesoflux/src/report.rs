//! The table that a run ends with.

use mesoflux_io::results::{EstimateRecord, Results};
use std::fmt::Write;

/// A value with its standard error to two digits, "0.0612(18)"; with an exponent where plain digits would be too long.
pub fn value_with_error(value: f64, error: f64) -> String {
    if !(error > 0.0) {
        return format!("{value}");
    }
    // The exponent of the error's second digit, after rounding to two digits has settled how many there are.
    let rounded: f64 = format!("{error:.1e}").parse().unwrap_or(error);
    let last = rounded.log10().floor() as i32 - 1;
    let leading = value.abs().max(rounded).log10().floor() as i32;
    if !(-4..7).contains(&leading) || last > 0 {
        let decimals = (leading - last).max(0) as usize;
        let digits = (rounded / 10f64.powi(last)).round();
        return format!("{:.decimals$}({digits})e{leading}", value / 10f64.powi(leading));
    }
    let decimals = (-last).max(0) as usize;
    let digits = (rounded * 10f64.powi(decimals as i32)).round();
    format!("{value:.decimals$}({digits})")
}

/// A large count, "4.2e8".
fn count(number: f64) -> String {
    format!("{number:.1e}")
}

/// The results as a table, with what a reader must know beneath.
pub fn table(results: &Results) -> String {
    let header = ["measurement", "method", "value (error)", "relative error", "particle-steps"].map(str::to_owned);
    let swept = !results.input.sweep.is_empty();
    let mut rows = vec![header.to_vec()];
    rows.extend(results.estimates.iter().map(row));
    if swept {
        rows[0].insert(0, "point".to_owned());
        for (row, record) in rows[1..].iter_mut().zip(&results.estimates) {
            row.insert(0, point(record, results));
        }
    }
    let mut text = String::new();
    if !results.input.title.is_empty() {
        let _ = writeln!(text, "{}\n", results.input.title);
    }
    text += &columns(&rows);
    for comparison in &results.comparisons {
        let [a, b] = comparison.methods;
        if let Some(z) = comparison.z {
            let verdict = if z.abs() <= 3.0 { "agree" } else { "DISAGREE" };
            let at: String = comparison.conditions.iter().map(|(key, value)| format!(", {key} = {value}")).collect();
            let _ = writeln!(text, "{}{at}: {a} and {b} {verdict}, z = {z:.2}", comparison.measurement);
        }
    }
    text += &time_step(results);
    text += &long_waves(results);
    for record in &results.estimates {
        for warning in &record.warnings {
            let _ = writeln!(text, "warning: {} by {}: {warning}", record.measurement, record.method);
        }
    }
    text + &remarks(results)
}

/// What each estimate owes to the time step, one line each.
fn time_step(results: &Results) -> String {
    let mut text = String::new();
    for check in &results.time_step_check {
        let at: String = check.conditions.iter().map(|(key, value)| format!(", {key} = {value}")).collect();
        let _ = write!(text, "time step: {} by {}{at}: ", check.measurement, check.method);
        let _ = match (check.bias, check.standard_error, check.z) {
            (Some(bias), Some(error), Some(z)) => {
                let verdict = if z.abs() <= 3.0 { "none seen" } else { "BIASED" };
                let extrapolated = match (check.extrapolated, check.extrapolated_standard_error) {
                    (Some(value), Some(error)) => {
                        format!("; {} at zero, if of second order", value_with_error(value, error))
                    }
                    _ => String::new(),
                };
                writeln!(
                    text,
                    "{} less at half of it, {verdict}, z = {z:.2}{extrapolated}",
                    value_with_error(bias, error)
                )
            }
            _ => writeln!(text, "cannot tell"),
        };
    }
    text
}

/// The long-wave limits, one line each.
fn long_waves(results: &Results) -> String {
    let mut text = String::new();
    for limit in &results.long_wave_limits {
        let at: String = limit.conditions.iter().map(|(key, value)| format!(", {key} = {value}")).collect();
        let value = match (limit.value, limit.standard_error) {
            (Some(value), Some(error)) => value_with_error(value, error),
            _ => "cannot tell".to_owned(),
        };
        let (measurement, method, count) = (&limit.measurement, limit.method, limit.wavenumbers.len());
        let _ = writeln!(text, "{measurement} by {method}{at}: {value} at k → 0, from {count} wavenumbers");
        for warning in &limit.warnings {
            let _ = writeln!(text, "warning: {measurement} by {method}{at} at k → 0: {warning}");
        }
    }
    text
}

/// What a reader must know of how the runs went, one warning a line.
pub fn remarks(results: &Results) -> String {
    let mut text = String::new();
    let in_every_run =
        |remark: &String| results.runs.len() > 1 && results.runs.iter().all(|run| run.remarks.contains(remark));
    for remark in results.runs.first().iter().flat_map(|run| &run.remarks).filter(|remark| in_every_run(remark)) {
        let _ = writeln!(text, "warning: every run: {remark}");
    }
    for run in &results.runs {
        let point: String = run.point.iter().map(|(key, value)| format!(", {key} = {value}")).collect();
        for remark in run.remarks.iter().filter(|remark| !in_every_run(remark)) {
            let _ = writeln!(text, "warning: {} run{point}, replica {}: {remark}", run.route, run.replica);
        }
    }
    text
}

fn row(record: &EstimateRecord) -> Vec<String> {
    let (value, relative) = match (record.value, record.standard_error) {
        (Some(value), Some(error)) => {
            (value_with_error(value, error), format!("{:.1} %", 100.0 * (error / value).abs()))
        }
        (Some(value), None) => (format!("{value:.4} (error unknown)"), String::new()),
        _ => ("cannot tell".to_owned(), String::new()),
    };
    let quantity =
        if record.measurement == record.quantity { String::new() } else { format!(" ({})", record.quantity) };
    vec![
        record.measurement.clone() + &quantity,
        record.method.to_owned(),
        value,
        relative,
        count(record.particle_steps),
    ]
}

/// The sweep's values at a record's point.
fn point(record: &EstimateRecord, results: &Results) -> String {
    let swept = |path: &String| {
        let mut table = Some(&results.input.sweep);
        let mut keys = path.split('.').peekable();
        while let (Some(key), Some(inner)) = (keys.next(), table) {
            if keys.peek().is_none() {
                return inner.contains_key(key);
            }
            table = inner.get(key).and_then(|value| value.as_table());
        }
        false
    };
    let name = |path: &str| path.rsplit('.').next().unwrap_or(path).to_owned();
    let values = record.conditions.iter().filter(|(path, _)| swept(path));
    values.map(|(path, value)| format!("{} = {value}", name(path))).collect::<Vec<_>>().join(", ")
}

/// Columns of equal width, the header underlined.
pub(crate) fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.first().map_or(0, Vec::len);
    let widths: Vec<usize> =
        (0..count).map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let rule = widths.iter().map(|&width| "─".repeat(width)).collect::<Vec<_>>().join("  ") + "\n";
    rows.iter().enumerate().map(|(k, row)| if k == 0 { line(row) + &rule } else { line(row) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_given_with_two_digits() {
        for (value, error, expected) in [
            (0.061_234, 0.001_8, "0.0612(18)"),
            (23.635, 0.002, "23.6350(20)"),
            (1.0, 0.099_9, "1.00(10)"),
            (-0.5, 0.2, "-0.50(20)"),
            (1234.5, 12.0, "1234(12)"),
            (3.2e9, 1.2e7, "3.200(12)e9"),
            (1.5e-7, 2e-9, "1.500(20)e-7"),
            (0.001, 0.5, "0.00(50)"),
        ] {
            assert_eq!(value_with_error(value, error), expected);
        }
    }
}
