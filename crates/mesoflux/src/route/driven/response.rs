//! Tables of a driven route: the response at every strength, its memory, its spread.

use super::{DrivenRecord, Way, cells};
use crate::route::{Outcome, RouteError};
use mesoflux_analysis::{AutocorrelationTime, Estimate, Quadrature};
use mesoflux_io::input::CorrelationInput;
use mesoflux_io::results::Table;

/// How long the answer remembers, at every strength: by its autocorrelation where that is recorded, else by blocks.
pub(super) fn memories<W: Way>(
    records: &[&DrivenRecord],
    spacing: f64,
) -> Result<Vec<AutocorrelationTime>, RouteError> {
    let memory = |record: &&DrivenRecord| {
        if let Some(correlator) = &record.autocorrelation {
            return Ok(correlator.autocorrelation_time());
        }
        let mut unit = vec![0.0; record.series.components()];
        unit[W::PLACE] = 1.0;
        Ok(record.series.autocorrelation_time(&unit, spacing)?)
    };
    records.iter().map(memory).collect()
}

/// One row for every strength: the mean answer, how it fluctuates, and what that makes of the estimator of α.
///
/// Variance, correlation time Θ and asymptotic variance 2∫C dt = 2 Var Θ (Wu & Shang, eqs 90 to 93) are those of the answer averaged
/// over the sample interval: the asymptotic variance is the same for any interval, the variance of the answer itself that of samples
/// taken at every step.
///
/// They are integrals of the autocorrelation where that is asked for, else what blocking finds. Blocks tell less: a current that is
/// driven back by its neighbors has a negative tail of its autocorrelation, which they may miss.
pub(super) fn table<W: Way>(
    strengths: &[f64],
    records: &[&DrivenRecord],
    memories: &[AutocorrelationTime],
    checks_observable: bool,
) -> Table {
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
    for ((&strength, record), memory) in strengths.iter().zip(records).zip(memories) {
        let series = &record.series;
        let answer = series.component(W::PLACE);
        let asymptotic = told(&memory.asymptotic_variance);
        let mut row = vec![strength];
        row.extend(cells(&answer));
        row.push(cells(&series.component(DrivenRecord::TEMPERATURE))[0]);
        row.extend(cells(&told(&variance::<W>(record))));
        row.extend(cells(&told(&memory.time)));
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
    Table::new(header, rows)
}

/// Why an autocorrelation has no integral yet, strength by strength.
pub(super) fn unknown_memories<W: Way>(strengths: &[f64], memories: &[AutocorrelationTime]) -> Vec<String> {
    let reasons = strengths.iter().zip(memories).filter_map(|(strength, memory)| {
        let reason = memory.asymptotic_variance.warnings.first()?;
        Some(format!("at {} = {strength}: {reason}", W::IMPOSED.name))
    });
    reasons.collect()
}

/// An estimate without reserve, or none: what is too short for the series' memory gives no more than a bound.
fn told(estimate: &Estimate) -> Estimate {
    if estimate.warnings.is_empty() { estimate.clone() } else { Estimate::default() }
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::super::{Nemd, Norton};
    use super::*;
    use mesoflux_analysis::Blocking;

    /// A series x' = φx + √(1 − φ²) ξ about a mean, as a driven run would record it.
    fn recorded<W: Way>(mean: f64, deviation: f64, memory: f64, seed: u64) -> DrivenRecord {
        let mut series = Blocking::new(4).unwrap();
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        };
        let mut x = 0.0;
        for _ in 0..400_000 {
            let normal = (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
            x = memory * x + (1.0 - memory * memory).sqrt() * normal;
            let answer = mean + deviation * x;
            let mut sample = [0.7, 0.7, 1.0, answer * answer];
            sample[W::PLACE] = answer;
            series.record(&sample).unwrap();
        }
        DrivenRecord { series, autocorrelation: None, histogram: None, profile: Vec::new() }
    }

    /// Variance s², correlation time Δt (1 + φ)/(1 − φ)/2 and asymptotic variances of a first-order autoregressive series.
    fn check<W: Way>(strength: f64, mean: f64, estimator: impl Fn(f64) -> f64) {
        let (deviation, memory, spacing) = (0.3, 0.9, 0.02);
        let time = 0.5 * spacing * (1.0 + memory) / (1.0 - memory);
        let asymptotic = 2.0 * deviation * deviation * time;
        let mut squares = [0.0; 5];
        for seed in 0..8 {
            let record = recorded::<W>(mean, deviation, memory, seed);
            let table = table::<W>(&[strength], &[&record], &memories::<W>(&[&record], spacing).unwrap(), false);
            let row = &table.rows[0];
            let expected = [mean, deviation * deviation, time, asymptotic, estimator(asymptotic)];
            for (k, (column, expected)) in [1, 4, 6, 8, 10].into_iter().zip(expected).enumerate() {
                let z = (row[column] - expected) / row[column + 1];
                assert!(
                    z.abs() < 4.0,
                    "{}: {} ± {} for {expected}",
                    table.header[column],
                    row[column],
                    row[column + 1]
                );
                squares[k] += z * z / 8.0;
            }
        }
        // Eight squares have a mean of 1 ± 0.5; the errors of a variance by blocks have few degrees of freedom.
        assert!(squares.iter().all(|square| (0.1..3.0).contains(square)), "{squares:?}");
    }

    #[test]
    fn fluctuations_of_a_series_that_is_known() {
        // σ²/η² (eq. 90) and r²σ²/⟨λ⟩⁴ (eq. 92).
        check::<Nemd>(2.0, 1.5, |variance| variance / 4.0);
        check::<Norton>(1.5, 2.0, |variance| 1.5 * 1.5 * variance / 16.0);
    }

    #[test]
    fn what_cannot_be_told_is_no_number() {
        let mut series = Blocking::new(4).unwrap();
        [1.0, 2.0, 3.0].iter().for_each(|x| series.record(&[*x, 1.0, 1.0, x * x]).unwrap());
        let record = DrivenRecord { series, autocorrelation: None, histogram: None, profile: Vec::new() };
        let row = &table::<Nemd>(&[1.0], &[&record], &memories::<Nemd>(&[&record], 0.1).unwrap(), false).rows[0];
        assert!(row[4..].iter().all(|number| number.is_nan()) && row[1] == 2.0, "{row:?}");
    }
}
