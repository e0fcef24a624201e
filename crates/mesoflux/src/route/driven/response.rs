//! Tables of a driven route: the response at every strength, its memory, its spread.

use super::{DrivenRecord, Way, cells};
use crate::route::{Outcome, RouteError};
use mesoflux_analysis::{Estimate, Quadrature};
use mesoflux_io::input::CorrelationInput;
use mesoflux_io::results::Table;

/// One row for every strength: the mean answer, how it fluctuates, and what that makes of the estimator of α.
///
/// Variance, correlation time Θ and asymptotic variance 2∫C dt = 2 Var Θ (Wu & Shang, eqs 90 to 93) are those of the answer averaged
/// over the sample interval: the asymptotic variance is the same for any interval, the variance of the answer itself that of samples
/// taken at every step.
pub(super) fn table<W: Way>(
    strengths: &[f64],
    records: &[&DrivenRecord],
    spacing: f64,
    checks_observable: bool,
) -> Result<Table, RouteError> {
    let unit = W::ANSWER.unit;
    let mut header = vec![
        W::IMPOSED.header(),
        W::ANSWER.header(),
        format!("standard_error [{unit}]"),
        "kinetic_temperature [e]".to_owned(),
        format!("variance [{unit}^2]"),
        format!("standard_error [{unit}^2]"),
        "correlation_time [t]".to_owned(),
        "standard_error [t]".to_owned(),
        format!("response_asymptotic_variance [{unit}^2 t]"),
        format!("standard_error [{unit}^2 t]"),
        "asymptotic_variance [v^2 t/f^2]".to_owned(),
        "standard_error [v^2 t/f^2]".to_owned(),
    ];
    if checks_observable {
        header
            .extend(["forcing_observable [f]", "booked_minus_observable [f]", "standard_error [f]"].map(str::to_owned));
    }
    let mut rows = Vec::new();
    for (&strength, record) in strengths.iter().zip(records) {
        let series = &record.series;
        let mut unit = vec![0.0; series.components()];
        unit[W::PLACE] = 1.0;
        let answer = series.component(W::PLACE);
        let memory = series.autocorrelation_time(&unit, spacing)?;
        let asymptotic = told(memory.asymptotic_variance);
        let mut row = vec![strength];
        row.extend(cells(&answer));
        row.push(cells(&series.component(DrivenRecord::TEMPERATURE))[0]);
        row.extend(cells(&told(variance::<W>(record))));
        row.extend(cells(&told(memory.time)));
        row.extend(cells(&asymptotic));
        let estimator = W::asymptotic_variance(strength, &answer, &asymptotic);
        row.extend(cells(&if strength == 0.0 { Estimate::default() } else { estimator }));
        if checks_observable {
            // The difference of the two series has its own, smaller error: both see the same trajectory.
            let mut difference = vec![0.0; series.components()];
            (difference[DrivenRecord::FORCING], difference[DrivenRecord::OBSERVABLE]) = (1.0, -1.0);
            row.push(cells(&series.component(DrivenRecord::OBSERVABLE))[0]);
            row.extend(cells(&series.linear(&difference)));
        }
        rows.push(row);
    }
    Ok(Table::new(header, rows))
}

/// An estimate without reserve, or none: what is too short for the series' memory gives no more than a bound.
fn told(estimate: Estimate) -> Estimate {
    if estimate.warnings.is_empty() { estimate } else { Estimate::default() }
}

/// ⟨x²⟩ − ⟨x⟩² of the answer, increased by the squared error of ⟨x⟩, by which it is too small on average.
fn variance<W: Way>(record: &DrivenRecord) -> Estimate {
    let error = record.series.component(W::PLACE).standard_error.unwrap_or(0.0);
    record.series.function(
        |mean| mean[DrivenRecord::SQUARE] - mean[W::PLACE].powi(2) + error * error,
        |mean| {
            let mut gradient = vec![0.0; mean.len()];
            gradient[DrivenRecord::SQUARE] = 1.0;
            gradient[W::PLACE] = -2.0 * mean[W::PLACE];
            gradient
        },
    )
}

/// The autocorrelation of the answer's deviation from its mean, at every strength.
pub(super) fn autocorrelation<W: Way>(strengths: &[f64], records: &[&DrivenRecord], asked: CorrelationInput) -> Table {
    let longest = asked.longest_lag.unwrap_or(f64::INFINITY);
    let mut rows = Vec::new();
    for (&strength, record) in strengths.iter().zip(records) {
        let points = record.autocorrelation.iter().flat_map(|correlator| correlator.table(Quadrature::Summed));
        rows.extend(points.take_while(|point| point.time <= longest).map(|point| {
            let [value, error] = cells(&point.correlation);
            let [normalized, normalized_error] = cells(&point.normalized);
            vec![strength, point.time, value, error, normalized, normalized_error]
        }));
    }
    let unit = W::ANSWER.unit;
    let header = [
        W::IMPOSED.header(),
        "time [t]".to_owned(),
        format!("autocorrelation [{unit}^2]"),
        format!("standard_error [{unit}^2]"),
        "normalized_autocorrelation [1]".to_owned(),
        "standard_error [1]".to_owned(),
    ];
    Table::new(header, rows)
}

/// Adds the probability density of the answer at every strength, and how much of it the range missed.
pub(super) fn histogram<W: Way>(outcome: &mut Outcome, strengths: &[f64], records: &[&DrivenRecord]) {
    let mut rows = Vec::new();
    let mut missed = 0.0f64;
    for (&strength, record) in strengths.iter().zip(records) {
        let Some(histogram) = &record.histogram else { continue };
        let outside = histogram.underflow() + histogram.overflow();
        missed = missed.max(outside as f64 / histogram.count().max(1) as f64);
        rows.extend(histogram.bins().iter().map(|bin| {
            let [density, error] = cells(&bin.density);
            vec![strength, 0.5 * (bin.low + bin.high), density, error]
        }));
    }
    outcome.conditions.insert("histogram_share_outside".to_owned(), missed.into());
    let unit = W::ANSWER.unit;
    let header = [
        W::IMPOSED.header(),
        format!("value [{unit}]"),
        format!("probability_density [1/{unit}]"),
        format!("standard_error [1/{unit}]"),
    ];
    outcome.tables.push(("histogram", Table::new(header, rows)));
}
