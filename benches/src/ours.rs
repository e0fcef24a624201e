//! What our own routes cost beside each other: integrators, drivings, threads.

use crate::failure::Failure;
use crate::machine::Machine;
use crate::options::Options;
use crate::statistics::Spread;
use crate::task::{Drive, Task, steps_for};
use crate::work::{Scheme, WORKS, Work};
use serde::{Deserialize, Serialize};

/// The force and the flux of the drivings: near each other in the liquid's linear regime.
const MAGNITUDE: f64 = 20.0;
const FLUX: f64 = 0.6;

/// `ours.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ours {
    /// The machine in one line.
    pub machine: String,
    /// When.
    pub date: String,
    /// The comparisons.
    pub ratios: Vec<Relative>,
}

/// One comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Relative {
    /// What is compared with what.
    pub what: String,
    /// The fluid.
    pub work: String,
    /// N.
    pub particles: u64,
    /// Threads, where both have as many.
    pub threads: Option<usize>,
    /// Time a step of the first over that of the second, over the rounds.
    pub ratio: Spread,
    /// How often both were timed.
    pub rounds: usize,
}

/// Two tasks and what their comparison is called.
struct Pair {
    what: &'static str,
    work: &'static Work,
    particles: u64,
    threads: Option<usize>,
    tasks: [Task; 2],
}

/// Makes all comparisons.
pub fn measure(options: &Options, machine: &Machine) -> Result<Ours, Failure> {
    let ratios = pairs(options).iter().map(|pair| compare(options, pair)).collect::<Result<_, _>>()?;
    Ok(Ours { machine: machine.in_one_line(), date: machine.date.clone(), ratios })
}

fn pairs(options: &Options) -> Vec<Pair> {
    let (soft, liquid) = (&WORKS[0], &WORKS[3]);
    let task = |work: &Work, scheme: Scheme, particles: u64| {
        let mut task = options.task(work, scheme);
        task.settings.retain(|setting| !setting.starts_with("system."));
        task.settings.push(format!("system.particles={particles}"));
        task
    };
    // Sizes of the check of this program itself.
    let sized = |particles: u64| if options.small { particles.min(1000) } else { particles };
    let mut pairs = Vec::new();
    let particles = sized(81_000);
    let tasks = [task(soft, Scheme::Aboba, particles), task(soft, Scheme::VelocityVerlet, particles)];
    pairs.push(Pair { what: "ABOBA / velocity Verlet", work: soft, particles, threads: Some(1), tasks });
    for particles in [500, sized(20_000)] {
        for threads in [1, 2] {
            let driven = |drive: Drive| Task { drive, threads, ..task(liquid, Scheme::Aboba, particles) };
            let tasks = [driven(Drive::Norton(FLUX)), driven(Drive::Nemd(MAGNITUDE))];
            pairs.push(Pair { what: "Norton / NEMD", work: liquid, particles, threads: Some(threads), tasks });
        }
    }
    for (what, scheme) in [
        ("one thread / two threads, velocity Verlet", Scheme::VelocityVerlet),
        ("one thread / two threads, ABOBA", Scheme::Aboba),
    ] {
        for particles in [sized(20_000), sized(81_000)] {
            let tasks = [1, 2].map(|threads| Task { threads, ..task(soft, scheme, particles) });
            pairs.push(Pair { what, work: soft, particles, threads: None, tasks });
        }
    }
    pairs.retain(|pair| pair.tasks.iter().all(|task| options.threads().contains(&task.threads)));
    pairs
}

fn compare(options: &Options, pair: &Pair) -> Result<Relative, Failure> {
    let seconds_a_step = |task: &Task| -> Result<f64, Failure> { Ok(task.perform()?.seconds[0] / task.steps as f64) };
    let mut tasks = Vec::new();
    for task in &pair.tasks {
        let first = options.first_steps(pair.work);
        let steps = steps_for(options.seconds, first, |steps| Ok(task.with_steps(steps).perform()?.seconds[0]))?;
        tasks.push(task.with_steps(steps));
    }
    let mut ratios = Vec::new();
    for _ in 0..options.rounds {
        ratios.push(seconds_a_step(&tasks[0])? / seconds_a_step(&tasks[1])?);
    }
    let ratio = Spread::of(&ratios);
    eprintln!("{}, {} particles: {:.3}", pair.what, pair.particles, ratio.median);
    Ok(Relative {
        what: pair.what.to_owned(),
        work: pair.work.name.to_owned(),
        particles: pair.particles,
        threads: pair.threads,
        ratio,
        rounds: options.rounds,
    })
}
