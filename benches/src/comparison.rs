//! mesoflux and LAMMPS in turn on the same work: the median over the rounds of the ratio in each round.

use crate::failure::Failure;
use crate::lammps::{Lammps, Run, Variant};
use crate::machine::Machine;
use crate::options::Options;
use crate::statistics::{Spread, median};
use crate::task::{Task, steps_for};
use crate::work::{Scheme, Split, Work};
use serde::{Deserialize, Serialize};

/// One line of `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The work.
    pub work: String,
    /// Our integrator.
    pub integrator: String,
    /// The precision of our numbers.
    pub precision: String,
    /// Threads of each program.
    pub threads: usize,
    /// Particles of one system.
    pub particles: u64,
    /// How many systems side by side, all of whose steps count.
    pub replicas: usize,
    /// Ours, the median over the rounds.
    pub particle_steps_per_second: f64,
    /// The median of LAMMPS' best variant.
    pub lammps_particle_steps_per_second: Option<f64>,
    /// The median over the rounds of ours over LAMMPS' best in that round.
    pub ratio: Option<f64>,
    /// The smallest of these.
    pub ratio_smallest: Option<f64>,
    /// The largest.
    pub ratio_largest: Option<f64>,
    /// LAMMPS' variant that was best in the median.
    pub lammps_variant: Option<String>,
    /// How often both were timed.
    pub rounds: usize,
    /// The machine in one line.
    pub machine: String,
    /// When.
    pub date: String,
}

impl Comparison {
    /// Whether the other is the same measurement, perhaps of another day.
    pub fn replaces(&self, other: &Self) -> bool {
        (&self.work, &self.integrator, self.threads) == (&other.work, &other.integrator, other.threads)
    }
}

/// A program with what it is told, and its particle-steps per second in each round.
struct Contestant<'a> {
    how: How<'a>,
    rates: Vec<f64>,
}

enum How<'a> {
    Ours(Scheme, Task),
    Lammps(&'a Lammps, Variant, Run),
}

impl Contestant<'_> {
    /// Runs the contestant with so many steps; returns its rate and the particles of all its systems.
    fn rate(&self, steps: u64) -> Result<(f64, u64), Failure> {
        match &self.how {
            How::Ours(_, task) => {
                let outcome = task.with_steps(steps).perform()?;
                Ok((outcome.rate(), outcome.particles))
            }
            How::Lammps(lammps, variant, run) => {
                let timing = lammps.run(*variant, &Run { steps, ..run.clone() })?;
                let systems = if *variant == Variant::Replicas { run.threads as u64 } else { 1 };
                Ok((timing.rate, timing.particles * systems))
            }
        }
    }
}

/// Times a work on so many threads; one comparison for each of our schemes.
pub fn compare(
    options: &Options,
    work: &Work,
    threads: usize,
    lammps: Option<&Lammps>,
    machine: &Machine,
) -> Result<Vec<Comparison>, Failure> {
    let mut contestants = contestants(options, work, threads, lammps);
    let mut steps = Vec::new();
    let mut particles = 0;
    for contestant in &contestants {
        let seconds_for = |steps: u64| {
            let (rate, moved) = contestant.rate(steps)?;
            if matches!(contestant.how, How::Ours(..)) {
                particles = moved;
            }
            Ok(moved as f64 * steps as f64 / rate)
        };
        steps.push(steps_for(options.seconds, options.first_steps(work), seconds_for)?);
    }
    for round in 1..=options.rounds {
        for (contestant, &steps) in contestants.iter_mut().zip(&steps) {
            let (rate, _) = contestant.rate(steps)?;
            contestant.rates.push(rate);
        }
        let rates = contestants.iter().map(|contestant| contestant.rates.last().copied().unwrap_or(f64::NAN));
        let shown: Vec<String> = rates.map(|rate| format!("{:.3}", rate * 1e-6)).collect();
        let shown = shown.join(", ");
        eprintln!("{}, threads {threads}, round {round}: {shown} million particle-steps/s", work.name);
    }
    let replicas = if work.split == Split::Replicas { threads } else { 1 };
    let best = best(&contestants);
    let row = |contestant: &Contestant| -> Option<Comparison> {
        let How::Ours(scheme, _) = &contestant.how else { return None };
        let ratio = best.as_ref().map(|best| {
            Spread::of(&contestant.rates.iter().zip(&best.by_round).map(|(ours, best)| ours / best).collect::<Vec<_>>())
        });
        Some(Comparison {
            work: work.name.to_owned(),
            integrator: scheme.name().to_owned(),
            precision: "double".to_owned(),
            threads,
            particles: particles / replicas as u64,
            replicas,
            particle_steps_per_second: median(&contestant.rates),
            lammps_particle_steps_per_second: best.as_ref().map(|best| best.median),
            ratio: ratio.map(|ratio| ratio.median),
            ratio_smallest: ratio.map(|ratio| ratio.smallest),
            ratio_largest: ratio.map(|ratio| ratio.largest),
            lammps_variant: best.as_ref().map(|best| best.variant.name().to_owned()),
            rounds: options.rounds,
            machine: machine.in_one_line(),
            date: machine.date.clone(),
        })
    };
    Ok(contestants.iter().filter_map(row).collect())
}

/// Our schemes and LAMMPS' variants, in turn.
fn contestants<'a>(options: &Options, work: &Work, threads: usize, lammps: Option<&'a Lammps>) -> Vec<Contestant<'a>> {
    let ours = |&scheme: &Scheme| {
        let task = Task { threads, split: work.split, ..options.task(work, scheme) };
        How::Ours(scheme, task)
    };
    let mut ours = work.schemes.iter().map(ours);
    let mut theirs = lammps.into_iter().flat_map(|lammps| {
        let run = options.lammps_run(work, threads);
        let variants = lammps.variants(threads, work.split).into_iter();
        variants.map(move |variant| How::Lammps(lammps, variant, run.clone()))
    });
    let mut turns = Vec::new();
    loop {
        let pair = [ours.next(), theirs.next()];
        if pair.iter().all(Option::is_none) {
            return turns;
        }
        turns.extend(pair.into_iter().flatten().map(|how| Contestant { how, rates: Vec::new() }));
    }
}

/// LAMMPS at its best.
struct Best {
    /// The best of its variants in each round.
    by_round: Vec<f64>,
    /// The variant with the largest median.
    variant: Variant,
    /// That median.
    median: f64,
}

fn best(contestants: &[Contestant]) -> Option<Best> {
    let theirs: Vec<(Variant, &[f64])> = contestants
        .iter()
        .filter_map(|contestant| match &contestant.how {
            How::Lammps(_, variant, _) => Some((*variant, contestant.rates.as_slice())),
            How::Ours(..) => None,
        })
        .collect();
    let medians = theirs.iter().map(|(variant, rates)| (*variant, median(rates)));
    let (variant, median) = medians.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let rounds = theirs.iter().map(|(_, rates)| rates.len()).min()?;
    let best_in = |round: usize| theirs.iter().map(|(_, rates)| rates[round]).fold(0.0, f64::max);
    Some(Best { by_round: (0..rounds).map(best_in).collect(), variant, median })
}
