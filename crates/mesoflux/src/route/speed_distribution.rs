//! The probability density of the particles' speeds, by counting them in bins, against Maxwell's.

use super::correlation::friction_integral;
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cells};
use crate::figure::{Axis, Figure, Layer, Panel, Point, Style};
use mesoflux_analysis::{
    AnalysisError, Blocking, ChiSquared, Estimate, Histogram, HistogramBin, chi_squared_test, maxwell_speed_cdf,
};
use mesoflux_core::integrate::{Langevin, Thermostat};
use mesoflux_core::run::{Moment, Recorder};
use mesoflux_io::input::{Input, SpeedHistogramInput};
use mesoflux_io::results::{Conditions, Table};
use mesoflux_io::stream;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::io::{self, Write};

/// So many correlation times of a velocity lie between two snapshots, for counts that are as good as independent.
const APART: f64 = 5.0;
/// Below this chance the speeds are said not to be Maxwell's.
const UNLIKELY: f64 = 0.001;

/// Density of |v| over all particles of one mass, a distribution for each species where masses differ.
///
/// With the total momentum fixed, each component of a velocity is normal with the variance kT/m (1 − m/M), M being the total mass.
/// χ² over the bins, what is faster than the last one counting as a bin, is told twice: against Maxwell's density at kT, and at the
/// temperature that these speeds have (`shape`). `kurtosis` is that of a component, 9⟨v⁴⟩/(5⟨v²⟩²): 3 of Maxwell's at any temperature.
pub(super) struct SpeedHistogram {
    pub parameters: SpeedHistogramInput,
}

/// Particles that share one distribution.
struct Group {
    /// The species, where there are several masses.
    name: Option<String>,
    count: usize,
    mass: f64,
    /// 1 − m/M with the total momentum fixed, 1 else.
    freedom: f64,
}

/// The groups, and to which of them each species belongs.
fn groups(input: &Input) -> (Vec<Group>, Vec<usize>) {
    let (masses, counts) = (input.masses(), input.species_counts());
    let total: f64 = masses.iter().zip(&counts).map(|(mass, &count)| mass * count as f64).sum();
    let freedom = |mass: f64| if input.integrator_conserves_momentum() { 1.0 - mass / total } else { 1.0 };
    if masses.windows(2).all(|pair| pair[0] == pair[1]) {
        let (count, mass) = (counts.iter().sum(), masses[0]);
        return (vec![Group { name: None, count, mass, freedom: freedom(mass) }], vec![0; masses.len()]);
    }
    let names = input.species().into_iter().map(|(name, _)| Some(name));
    let each = names.zip(masses).zip(&counts);
    let groups: Vec<Group> =
        each.map(|((name, mass), &count)| Group { name, count, mass, freedom: freedom(mass) }).collect();
    let places = (0..groups.len()).collect();
    (groups, places)
}

/// Steps between two snapshots: [`APART`] times 1/a of the species that friction slows down least, a = (4π/3m) Σ ρ_b ∫Γ(r) r² dr
/// by friction at rest, or γ/m by the Langevin thermostat.
fn interval(input: &Input, given: Option<u64>) -> u64 {
    if let Some(interval) = given {
        return interval;
    }
    let frictions = input.interactions().frictions;
    let volume: f64 = input.sides().iter().product();
    let counts = input.species_counts();
    let rate = |(a, mass): (usize, f64)| match input.dynamics.thermostat {
        Thermostat::Langevin(Langevin { friction }) => friction / mass,
        Thermostat::PairOrnsteinUhlenbeck | Thermostat::None => {
            let by = |(b, &count): (usize, &usize)| {
                let law = frictions.get(a as u8, b as u8).as_ref();
                count as f64 / volume * law.map_or(0.0, friction_integral)
            };
            4.0 * PI / (3.0 * mass) * counts.iter().enumerate().map(by).sum::<f64>()
        }
    };
    let slowest = input.masses().into_iter().enumerate().map(rate).fold(f64::INFINITY, f64::min);
    // What no friction slows down is looked at as seldom as the run allows.
    let most = (input.steps(input.run.production_time) / 100).max(1);
    ((APART / (slowest * input.dynamics.time_step)).ceil() as u64).clamp(1, most)
}

/// Counts of speeds, and the means of v² and v⁴ at every snapshot.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SpeedRecord {
    /// By group.
    histograms: Vec<Histogram>,
    /// ⟨v²⟩ and ⟨v⁴⟩ of each group, one after the other.
    moments: Blocking,
}

impl SpeedRecord {
    /// Adds the record of another replica.
    ///
    /// # Errors
    /// Records of other groups.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        for (mine, theirs) in self.histograms.iter_mut().zip(&other.histograms) {
            mine.merge(theirs)?;
        }
        Ok(self.moments.merge(&other.moments)?)
    }

    fn accepts(&self, state: &Self) -> bool {
        self.histograms.len() == state.histograms.len()
            && self.histograms.iter().zip(&state.histograms).all(|(mine, theirs)| mine.accepts(theirs))
            && self.moments.accepts(&state.moments)
    }
}

impl Route for SpeedHistogram {
    fn method(&self) -> &'static str {
        "speed_histogram"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let (groups, places) = groups(input);
        let largest = input.largest_speed(&self.parameters);
        let histogram = Histogram::new(0.0, largest, self.parameters.bins as usize)?;
        let histograms = vec![histogram; groups.len()];
        let record = SpeedRecord { histograms, moments: Blocking::new(2 * groups.len())? };
        let counts = groups.iter().map(|group| group.count as f64).collect();
        let interval = interval(input, self.parameters.sample_interval);
        Ok(Box::new(SpeedRecorder { interval, places, counts, record, failure: None }))
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let [Record::Speeds(record)] = records else {
            return Err(RouteError::WrongRecord);
        };
        let (groups, _) = groups(input);
        let kinetic = groups.iter().flat_map(|group| [group.count as f64 * group.mass, 0.0]);
        let degrees: f64 = groups.iter().map(|group| 3.0 * group.count as f64 * group.freedom).sum();
        let weights: Vec<f64> = kinetic.map(|weight| weight / degrees).collect();
        let mut outcome = Outcome::of(record.moments.linear(&weights));
        let interval = interval(input, self.parameters.sample_interval);
        outcome.conditions.insert("sample_interval".to_owned(), interval.into());
        let mut panels = Vec::new();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut header = vec!["speed [v]".to_owned()];
        for (place, (group, histogram)) in groups.iter().zip(&record.histograms).enumerate() {
            if histogram.count() == 0 {
                continue;
            }
            let bins = histogram.bins();
            let variance = input.dynamics.temperature / group.mass * group.freedom;
            let suffix = group.name.as_ref().map_or_else(String::new, |name| format!("_{name}"));
            let columns =
                [format!("density{suffix} [1/v]"), "standard_error [1/v]".into(), format!("maxwell{suffix} [1/v]")];
            header.extend(columns);
            rows.resize(bins.len(), Vec::new());
            for (bin, row) in bins.iter().zip(&mut rows) {
                if row.is_empty() {
                    row.push(0.5 * (bin.low + bin.high));
                }
                row.extend(cells(&bin.density));
                row.push(share(bin, variance) / (bin.high - bin.low));
            }
            panels.push(panel(group, &bins, variance));
            judge(&mut outcome, input, &suffix, histogram, variance, &moments(&record.moments, place));
        }
        outcome.tables.push(("", Table::new(header, rows)));
        outcome.figures.push(("", Figure { title: String::new(), columns: 2, panels }));
        Ok(outcome)
    }
}

/// Maxwell's share of all speeds in a bin.
fn share(bin: &HistogramBin, variance: f64) -> f64 {
    maxwell_speed_cdf(bin.high, variance) - maxwell_speed_cdf(bin.low, variance)
}

/// ⟨v²⟩ of a group, and its kurtosis.
fn moments(moments: &Blocking, place: usize) -> [Estimate; 2] {
    let (second, fourth) = (2 * place, 2 * place + 1);
    let kurtosis = moments.function(
        |mean| 1.8 * mean[fourth] / mean[second].powi(2),
        |mean| {
            let mut gradient = vec![0.0; mean.len()];
            gradient[second] = -3.6 * mean[fourth] / mean[second].powi(3);
            gradient[fourth] = 1.8 / mean[second].powi(2);
            gradient
        },
    );
    [moments.component(second), kurtosis]
}

/// Adds the tests of a group, with a warning where its speeds are not Maxwell's.
fn judge(
    outcome: &mut Outcome,
    input: &Input,
    suffix: &str,
    histogram: &Histogram,
    variance: f64,
    [square, kurtosis]: &[Estimate; 2],
) {
    let bins = histogram.bins();
    let mut observed: Vec<f64> = bins.iter().map(|bin| bin.count as f64).collect();
    observed.push(histogram.overflow() as f64);
    let all = histogram.count() as f64;
    let test = |variance: f64, constraints: usize| -> Result<ChiSquared, AnalysisError> {
        let mut expected: Vec<f64> = bins.iter().map(|bin| all * share(bin, variance)).collect();
        let last = bins.last().map_or(0.0, |bin| bin.high);
        expected.push(all * (1.0 - maxwell_speed_cdf(last, variance)));
        chi_squared_test(&observed, &expected, constraints)
    };
    let mut conditions = Conditions::from([(format!("samples{suffix}"), histogram.count().into())]);
    if let Ok(found) = test(variance, 1) {
        conditions.insert(format!("chi_squared{suffix}"), found.statistic.into());
        conditions.insert(format!("degrees_of_freedom{suffix}"), found.degrees_of_freedom.into());
        conditions.insert(format!("p_value{suffix}"), found.p_value.into());
        if found.p_value < UNLIKELY {
            let (kt, p) = (input.dynamics.temperature, found.p_value);
            let warning = format!("the speeds are not those of Maxwell at kT = {kt}: χ² has a chance of {p:.1e}");
            outcome.estimate.warnings.push(warning);
        }
    }
    if let Some(Ok(found)) = square.value.map(|square| test(square / 3.0, 2)) {
        conditions.insert(format!("shape_p_value{suffix}"), found.p_value.into());
    }
    for (name, number) in [("kurtosis", kurtosis.value), ("kurtosis_standard_error", kurtosis.standard_error)] {
        if let Some(number) = number {
            conditions.insert(format!("{name}{suffix}"), number.into());
        }
    }
    outcome.conditions.extend(conditions);
}

/// The density beside Maxwell's.
fn panel(group: &Group, bins: &[HistogramBin], variance: f64) -> Panel {
    let middle = |bin: &HistogramBin| 0.5 * (bin.low + bin.high);
    let points = bins.iter().map(|bin| {
        let [y, y_error] = cells(&bin.density);
        Point { x: middle(bin), y, x_error: 0.0, y_error }
    });
    let line = bins.iter().map(|bin| (middle(bin), share(bin, variance) / (bin.high - bin.low)));
    let axis = |label: &str| Axis { label: label.to_owned(), logarithmic: false, range: None };
    let layers = vec![
        Layer::Points { label: "counted".to_owned(), points: points.collect(), style: Style::nth(0) },
        Layer::Line { label: "Maxwell".to_owned(), points: line.collect(), dashed: true, style: Style::nth(1) },
    ];
    let title = group.name.clone().unwrap_or_default();
    Panel { title, x: axis("speed"), y: axis("probability density"), layers }
}

/// Counts the speeds of all particles at every snapshot.
struct SpeedRecorder {
    interval: u64,
    /// Of each species, its group.
    places: Vec<usize>,
    /// Of each group, its particles.
    counts: Vec<f64>,
    record: SpeedRecord,
    failure: Option<AnalysisError>,
}

impl SpeedRecorder {
    fn count(&mut self, moment: &Moment) -> Result<(), AnalysisError> {
        let particles = &moment.simulation.system.particles;
        let mut sums = vec![0.0; 2 * self.counts.len()];
        for (k, &species) in particles.species.iter().enumerate() {
            let place = self.places[species as usize];
            let square: f64 = particles.velocity(k).iter().map(|v| v * v).sum();
            self.record.histograms[place].record(square.sqrt())?;
            sums[2 * place] += square / self.counts[place];
            sums[2 * place + 1] += square * square / self.counts[place];
        }
        self.record.moments.record(&sums)
    }
}

impl Recorder for SpeedRecorder {
    fn observe(&mut self, moment: &mut Moment) {
        if moment.step.is_multiple_of(self.interval) && self.failure.is_none() {
            self.failure = self.count(moment).err();
        }
    }
}

impl RouteRecorder for SpeedRecorder {
    fn interval(&self) -> u64 {
        self.interval
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        stream::write(out, &(self.interval, &self.record))
    }

    fn load(&mut self, state: &[u8]) -> Result<(), RouteError> {
        let (interval, record): (u64, SpeedRecord) = postcard::from_bytes(state)?;
        if interval != self.interval || !self.record.accepts(&record) {
            return Err(RouteError::OtherState);
        }
        self.record = record;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Record, RouteError> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(Record::Speeds(Box::new(self.record))),
        }
    }
}
