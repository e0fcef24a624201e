//! The radial distribution function from pairs counted by distance, and the pressure that follows from it.

use super::average::StateRecorder;
use super::profile::ProfileRecorder;
use super::{Outcome, Record, Route, RouteError, RouteRecorder, cell};
use mesoflux_analysis::{Blocking, Estimate};
use mesoflux_core::observable::{RadialBins, pairs_of_species};
use mesoflux_core::potential::Potential;
use mesoflux_io::input::{DistributionInput, Input};
use mesoflux_io::results::{Conditions, Table};

/// Below so many pairs in all samples, a bin's error is no smaller than that of independent counts.
const FEW_PAIRS: f64 = 50.0;

/// g(r) = n(r)/(pairs · v(r)/V): the mean number of pairs in a bin over that of independent particles, v being the bin's volume.
///
/// One column for all pairs and, in a mixture, one for each pair of species; bonded pairs count like all others. The estimate's
/// value is the highest g(r) of all pairs: being the highest of many it reads a little high, by a fraction of its error.
pub(super) struct Histogram {
    pub parameters: DistributionInput,
}

impl Histogram {
    fn bins(&self, input: &Input) -> RadialBins {
        RadialBins { longest: input.longest_distance(&self.parameters), count: self.parameters.bins as usize }
    }

    /// The distributions: their columns' names, and the numbers of pairs of which each is one.
    fn distributions(input: &Input) -> Vec<(String, f64)> {
        let pairs = pairs_of_species(&input.species_counts());
        let species = input.species();
        let mut distributions = vec![("g".to_owned(), pairs.iter().sum())];
        if species.len() > 1 {
            let named = (0..species.len()).flat_map(|b| (0..=b).map(move |a| [a, b])).zip(pairs);
            distributions.extend(named.map(|([a, b], pairs)| (format!("g_{}-{}", species[a].0, species[b].0), pairs)));
        }
        distributions
    }
}

impl Route for Histogram {
    fn method(&self) -> &'static str {
        "histogram"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let (bins, species) = (self.bins(input), input.species().len());
        let numbers = Self::distributions(input).len() * bins.count;
        ProfileRecorder::boxed(input, numbers, move |system| {
            let counts = bins.count_pairs(&system.particles, &system.region, species, system.workers);
            let all = (0..bins.count).map(|bin| counts[bin..].iter().step_by(bins.count).sum::<u64>());
            let each = counts.iter().copied().take(if species > 1 { counts.len() } else { 0 });
            all.chain(each).map(|count| count as f64).collect()
        })
    }

    fn estimate(&self, input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        let [Record::Profile(series)] = records else {
            return Err(RouteError::WrongRecord);
        };
        let (bins, volume) = (self.bins(input), input.sides().iter().product::<f64>());
        let mut header = vec!["distance [l]".to_owned()];
        let mut rows: Vec<Vec<f64>> =
            (0..bins.count).map(|bin| vec![0.5 * bins.edges(bin).iter().sum::<f64>()]).collect();
        let mut highest: Option<(f64, Estimate)> = None;
        for ((name, pairs), series) in Self::distributions(input).into_iter().zip(series.chunks(bins.count)) {
            // Two species of one particle each: no pair of the first alone.
            if pairs == 0.0 {
                continue;
            }
            header.extend([format!("{name} [1]"), "standard_error [1]".into(), "effective_samples [1]".into()]);
            for (bin, (row, series)) in rows.iter_mut().zip(series).enumerate() {
                let g = distribution(series, pairs * bins.volume(bin) / volume);
                let numbers = [g.value, g.standard_error, Some(g.effective_samples)];
                row.extend(numbers.map(cell));
                if name == "g" && highest.as_ref().is_none_or(|(_, highest)| highest.value < g.value) {
                    highest = Some((row[0], g));
                }
            }
        }
        let (distance, estimate) = highest.ok_or(RouteError::WrongRecord)?;
        let conditions = Conditions::from([("distance".to_owned(), distance.into())]);
        Ok(Outcome { conditions, tables: vec![("", Table::new(header, rows))], ..Outcome::of(estimate) })
    }
}

/// g of one bin from the series of its counts, `expected` being their mean for independent particles.
///
/// A bin in which pairs are rare, or none was seen, is not known as well as its scatter says. Where M pairs were seen in all, the
/// error is at least √(M + 2) of them: so 95 % intervals of independent counts hold a true mean of 3 to 50 in 94 to 98 % of cases,
/// of less than 3 in all.
fn distribution(series: &Blocking, expected: f64) -> Estimate {
    let mut count = series.estimate();
    let samples = series.count() as f64;
    if let (Some(mean), Some(error)) = (count.value, count.standard_error) {
        let pairs = mean * samples;
        if pairs < FEW_PAIRS {
            count.standard_error = Some(error.max((pairs + 2.0).sqrt() / samples));
        }
    }
    count.scaled(expected.recip())
}

/// P = ρ kT − (2π/3) ρ² ∫ r³ u'(r) g(r) dr, summed over pairs of species in a mixture.
///
/// The integral is taken over the bins of g(r), the law averaged over each bin. That is the virial but for how g(r) varies within a
/// bin: an error of the order of ∫ (Δ²/12) (r f)' g' 4πr² dr for bins of width Δ, below 1e-4 of the pressure with these many. kT is the
/// kinetic temperature, as in the virial.
pub(super) struct PressureFromDistribution;

/// Bins up to the longest cutoff.
const BINS: usize = 2000;

impl Route for PressureFromDistribution {
    fn method(&self) -> &'static str {
        "radial_distribution"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        let laws = input.interactions();
        let bins = RadialBins { longest: laws.cutoff(), count: BINS };
        let by_bin = |law: &Option<Potential>| {
            (0..BINS).map(|bin| law.as_ref().map_or(0.0, |law| bins.mean_virial(bin, law))).collect::<Vec<_>>()
        };
        let virial: Vec<f64> = laws.potentials.entries().iter().flat_map(by_bin).collect();
        let species = laws.potentials.species();
        StateRecorder::boxed(input, 1, move |system| {
            let counts = bins.count_pairs(&system.particles, &system.region, species, system.workers);
            let pairs = counts.iter().zip(&virial).filter(|&(&count, _)| count > 0);
            let sum: f64 = pairs.map(|(&count, virial)| count as f64 * virial).sum();
            let (volume, particles) = (system.region.volume(), system.particles.count() as f64);
            vec![particles / volume * system.kinetic_temperature() + sum / (3.0 * volume)]
        })
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        Ok(Outcome::of(records[0].series()?.estimate()))
    }
}
