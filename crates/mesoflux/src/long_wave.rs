//! Viscosities at several wavenumbers, and what they tend to for long waves: η(k) = η(0)(1 − bk²).

use mesoflux_analysis::{AnalysisError, Estimate, polynomial_functionals};
use mesoflux_io::results::{EstimateRecord, LongWaveLimit};

/// The viscosity at one wavenumber.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// k.
    pub wavenumber: f64,
    /// η(k).
    pub viscosity: f64,
    /// Its standard error.
    pub error: f64,
    /// In the fit.
    pub weight: f64,
    /// Independent samples behind the error.
    pub effective_samples: f64,
}

/// The value at k = 0 of the line in k² through points; a single point as it is, with a warning.
///
/// # Errors
/// Points that determine no line.
pub fn at_zero(points: &[Point]) -> Result<Estimate, AnalysisError> {
    let samples = points.iter().map(|point| point.effective_samples).fold(f64::INFINITY, f64::min);
    if let [Point { wavenumber, viscosity, error, .. }] = *points {
        let warning = format!("at the wavenumber {wavenumber:.4}, not at zero: one wavenumber can't be extrapolated");
        return Ok(Estimate::new(viscosity, error, samples).with_warning(warning));
    }
    let squares: Vec<f64> = points.iter().map(|point| point.wavenumber.powi(2)).collect();
    let weights: Vec<f64> = points.iter().map(|point| point.weight).collect();
    let line = polynomial_functionals(&squares, &weights, 2)?;
    let sum = |of: &[f64], number: fn(&Point) -> f64| of.iter().zip(points).map(|(c, point)| c * number(point)).sum();
    let (value, slope): (f64, f64) = (sum(&line[0], |point| point.viscosity), sum(&line[1], |point| point.viscosity));
    let error = line[0].iter().zip(points).map(|(c, point)| (c * point.error).powi(2)).sum::<f64>().sqrt();
    let residual = |(point, square): (&Point, &f64)| ((point.viscosity - value - slope * square) / point.error).powi(2);
    let misfit: f64 = points.iter().zip(&squares).map(residual).sum();
    let estimate = Estimate::new(value, error, samples);
    let freedom = points.len() as f64 - 2.0;
    // Three standard deviations of a χ² distribution.
    if freedom > 0.0 && misfit > freedom + 3.0 * (2.0 * freedom).sqrt() {
        let warning = format!(
            "the viscosity isn't linear in k² at these wavenumbers (χ² = {misfit:.1} with {freedom} degrees of freedom): \
             take fewer wavenumbers, or a longer box"
        );
        return Ok(estimate.with_warning(warning));
    }
    Ok(estimate)
}

/// The long-wave limit of every viscosity that a sweep over boxes or waves has measured at several wavenumbers; points that
/// differ in anything else belong to limits of their own.
///
/// # Errors
/// None that can be met.
pub fn limits(estimates: &[EstimateRecord]) -> Result<Vec<LongWaveLimit>, AnalysisError> {
    let mut limits: Vec<(LongWaveLimit, Vec<Point>)> = Vec::new();
    for record in estimates {
        let wavenumber = record.conditions.get("wavenumber").and_then(serde_json::Value::as_f64);
        let (Some(wavenumber), Some(viscosity), Some(error)) = (wavenumber, record.value, record.standard_error) else {
            continue;
        };
        // Swept keys have dots in their paths; what a route has added has none.
        let waves = |path: &str| path.rsplit('.').next() == Some("waves");
        let other = |path: &str| path.contains('.') && !path.starts_with("system.") && !waves(path);
        let conditions = record.conditions.iter().filter(|(path, _)| other(path));
        let conditions = conditions.map(|(path, value)| (path.clone(), value.clone())).collect();
        let point =
            Point { wavenumber, viscosity, error, weight: error.powi(-2), effective_samples: record.effective_samples };
        let belongs = |limit: &LongWaveLimit| {
            limit.measurement == record.measurement && limit.method == record.method && limit.conditions == conditions
        };
        match limits.iter_mut().find(|(limit, _)| belongs(limit)) {
            Some((_, points)) => points.push(point),
            None => limits.push((LongWaveLimit::new(record, conditions), vec![point])),
        }
    }
    let mut found = Vec::new();
    for (mut limit, points) in limits {
        limit.wavenumbers = points.iter().map(|point| point.wavenumber).collect();
        limit.wavenumbers.sort_by(f64::total_cmp);
        limit.wavenumbers.dedup();
        if limit.wavenumbers.len() > 1 {
            limit.take(&at_zero(&points)?);
            found.push(limit);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(law: impl Fn(f64) -> f64) -> Vec<Point> {
        let at = |wavenumber: f64| Point {
            wavenumber,
            viscosity: law(wavenumber),
            error: 0.02,
            weight: 2500.0,
            effective_samples: 30.0,
        };
        [0.2, 0.4, 0.6, 0.8].map(at).to_vec()
    }

    #[test]
    fn a_line_in_the_square_is_extrapolated_with_its_error() {
        let found = at_zero(&points(|k| 3.0 * (1.0 - 0.2 * k * k))).unwrap();
        assert!((found.value.unwrap() - 3.0).abs() < 1e-12 && found.warnings.is_empty());
        // By hand: k² = 0.04, 0.16, 0.36, 0.64 with mean 0.3 and Σ(k² − 0.3)² = 0.2064: s²(1/4 + 0.09/0.2064).
        assert!((found.standard_error.unwrap() - 0.02 * (0.25 + 0.09 / 0.2064f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn points_that_differ_in_more_than_the_wave_have_limits_of_their_own() {
        let record = |method, particles: u64, friction: f64, wavenumber: f64, value: f64| EstimateRecord {
            measurement: "viscosity".to_owned(),
            quantity: "shear_viscosity",
            method,
            value: Some(value),
            standard_error: Some(0.1),
            effective_samples: 30.0,
            particle_steps: 0.0,
            conditions: [
                ("system.particles".to_owned(), particles.into()),
                ("pair.all.friction.linear.coefficient".to_owned(), friction.into()),
                ("wavenumber".to_owned(), wavenumber.into()),
            ]
            .into(),
            warnings: Vec::new(),
            table: None,
        };
        let mut estimates = Vec::new();
        for (method, friction, limit) in [("nemd", 4.5, 3.0), ("norton", 4.5, 3.1), ("nemd", 40.5, 29.0)] {
            for (particles, wavenumber) in [(500, 0.75), (4000, 0.375)] {
                estimates.push(record(method, particles, friction, wavenumber, limit - wavenumber * wavenumber));
            }
        }
        // One wavenumber alone tells no limit, nor does a route without any.
        estimates.push(record("norton", 500, 40.5, 0.75, 20.0));
        let found = limits(&estimates).unwrap();
        let values: Vec<f64> = found.iter().map(|limit| limit.value.unwrap()).collect();
        assert_eq!(values.len(), 3, "{found:?}");
        for (value, expected) in values.into_iter().zip([3.0, 3.1, 29.0]) {
            assert!((value - expected).abs() < 1e-12);
        }
        assert_eq!(found[0].wavenumbers, [0.375, 0.75]);
        assert_eq!(found[2].conditions["pair.all.friction.linear.coefficient"], 40.5);
    }

    #[test]
    fn a_curve_is_told_from_a_line() {
        let found = at_zero(&points(|k| 3.0 - 2.0 * k.powi(4))).unwrap();
        assert!(found.warnings[0].contains("isn't linear in k²"), "{found:?}");
    }
}
