//! Every kernel alone: nanoseconds and cycles a pair; and the share of each phase of a step.

mod bench;
mod clock;

use crate::failure::Failure;
use crate::machine::Machine;
use crate::options::Options;
use crate::setup;
use crate::statistics::{Spread, median};
use crate::task::Drive;
use crate::work::{Scheme, WORKS, Work};
use bench::{Bench, Kernel};
use mesoflux_core::domain::Workers;
use mesoflux_core::simulation::Simulation;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// `kernels.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kernels {
    /// The machine in one line.
    pub machine: String,
    /// When.
    pub date: String,
    /// The fluids.
    pub works: Vec<WorkKernels>,
}

/// The kernels on one fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorkKernels {
    /// The fluid.
    pub work: String,
    /// N.
    pub particles: u64,
    /// Pairs within the cutoff.
    pub pairs: u64,
    /// What each kernel takes.
    pub kernels: Vec<KernelTime>,
    /// What steps are made of.
    pub profiles: Vec<Profile>,
}

/// The time of a kernel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KernelTime {
    /// Its name.
    pub kernel: String,
    /// Time over the number of pairs within the cutoff.
    pub nanoseconds_per_pair: Spread,
    /// The same in cycles of the core, whose frequency was measured beside it.
    pub cycles_per_pair: Spread,
}

/// What a step is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// The integrator.
    pub integrator: String,
    /// A whole step.
    pub nanoseconds_per_particle_step: Spread,
    /// How often the list is built.
    pub lists_per_step: f64,
    /// The parts; what no kernel explains is the last.
    pub phases: Vec<Phase>,
}

/// One part of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Its name.
    pub phase: String,
    /// Its part of the step's time: what the kernel takes alone, times its calls a step.
    pub share: f64,
}

/// The fluids on which kernels are timed: a large one and a small one.
const TIMED: [usize; 2] = [0, 3];

/// Times every kernel on every fluid, on one thread.
pub fn measure(options: &Options, machine: &Machine) -> Result<Kernels, Failure> {
    let works = TIMED.iter().map(|&place| one_work(options, &WORKS[place])).collect::<Result<_, _>>()?;
    Ok(Kernels { machine: machine.in_one_line(), date: machine.date.clone(), works })
}

fn one_work(options: &Options, work: &Work) -> Result<WorkKernels, Failure> {
    let schemes = [Scheme::VelocityVerlet, Scheme::Aboba];
    let mut runs = schemes.iter().map(|&scheme| Run::new(options, work, scheme)).collect::<Result<Vec<_>, _>>()?;
    let mut bench = Bench::new(runs[0].simulation.system.clone());
    // Eight things are timed in turn in every round.
    let each = options.seconds / (Kernel::ALL.len() + runs.len()) as f64;
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); Kernel::ALL.len()];
    let mut cycles = times.clone();
    for _ in 0..options.rounds {
        for (place, kernel) in Kernel::ALL.into_iter().enumerate() {
            bench.prepare();
            let gigahertz = clock::gigahertz();
            let nanoseconds = 1e9 * seconds_a_call(each, || bench.call(kernel)) / bench.pairs() as f64;
            times[place].push(nanoseconds);
            cycles[place].push(nanoseconds * gigahertz);
        }
        runs.iter_mut().try_for_each(|run| run.time(each))?;
    }
    let kernel = |(place, kernel): (usize, Kernel)| KernelTime {
        kernel: kernel.name().to_owned(),
        nanoseconds_per_pair: Spread::of(&times[place]),
        cycles_per_pair: Spread::of(&cycles[place]),
    };
    let seconds_of = |kernel: Kernel| 1e-9 * median(&times[kernel as usize]) * bench.pairs() as f64;
    let particles = runs[0].simulation.system.particles.count();
    let result = WorkKernels {
        work: work.name.to_owned(),
        particles: particles as u64,
        pairs: bench.pairs() as u64,
        kernels: Kernel::ALL.into_iter().enumerate().map(kernel).collect(),
        profiles: runs.iter().map(|run| run.profile(particles, seconds_of)).collect(),
    };
    let shown = result.kernels.iter().map(|row| format!("{} {:.2}", row.kernel, row.nanoseconds_per_pair.median));
    eprintln!("{}, ns a pair: {}", work.name, shown.collect::<Vec<_>>().join(", "));
    Ok(result)
}

/// The time of a call, from as many as fit into the time given.
fn seconds_a_call(given: f64, mut call: impl FnMut()) -> f64 {
    let mut calls = 1;
    loop {
        let begin = Instant::now();
        (0..calls).for_each(|_| call());
        let taken = begin.elapsed().as_secs_f64();
        if taken > 0.5 * given {
            return taken / f64::from(calls);
        }
        calls = (f64::from(calls) * (0.9 * given / taken.max(1e-7)).clamp(1.1, 20.0)).ceil() as i32;
    }
}

/// A simulation whose whole steps are timed.
struct Run {
    scheme: Scheme,
    simulation: Simulation,
    /// Seconds a step in each round.
    seconds: Vec<f64>,
    steps: u64,
    lists: u64,
}

impl Run {
    fn new(options: &Options, work: &Work, scheme: Scheme) -> Result<Self, Failure> {
        let task = options.task(work, scheme);
        let input = setup::read(&task.input, &task.settings)?;
        let mut simulation = setup::simulation(&input, Drive::None, 0, Workers::One)?;
        for _ in 0..task.warm_up {
            simulation.step().map_err(Failure::simulation)?;
        }
        Ok(Self { scheme, simulation, seconds: Vec::new(), steps: 0, lists: 0 })
    }

    /// Steps for about so long, and at least until some lists were built.
    fn time(&mut self, given: f64) -> Result<(), Failure> {
        let (begin, lists) = (Instant::now(), self.simulation.system.list().builds());
        let mut steps = 0;
        while steps < 16 || begin.elapsed().as_secs_f64() < given {
            self.simulation.step().map_err(Failure::simulation)?;
            steps += 1;
        }
        self.seconds.push(begin.elapsed().as_secs_f64() / steps as f64);
        self.steps += steps;
        self.lists += self.simulation.system.list().builds() - lists;
        Ok(())
    }

    fn profile(&self, particles: usize, seconds_of: impl Fn(Kernel) -> f64) -> Profile {
        let lists_per_step = self.lists as f64 / self.steps as f64;
        let step = median(&self.seconds);
        let calls: &[(Kernel, f64)] = match self.scheme {
            Scheme::VelocityVerlet => &[(Kernel::List, lists_per_step), (Kernel::FusedForces, 1.0)],
            Scheme::Aboba => &[
                (Kernel::List, lists_per_step),
                (Kernel::Contacts, 1.0),
                (Kernel::ConservativeForces, 1.0),
                (Kernel::Sweep, 1.0),
            ],
        };
        let phase = |&(kernel, calls): &(Kernel, f64)| Phase {
            phase: kernel.name().to_owned(),
            share: calls * seconds_of(kernel) / step,
        };
        let mut phases: Vec<Phase> = calls.iter().map(phase).collect();
        let rest = 1.0 - phases.iter().map(|phase| phase.share).sum::<f64>();
        phases.push(Phase { phase: "everything else".to_owned(), share: rest });
        let nanoseconds: Vec<f64> = self.seconds.iter().map(|seconds| 1e9 * seconds / particles as f64).collect();
        Profile {
            integrator: self.scheme.name().to_owned(),
            nanoseconds_per_particle_step: Spread::of(&nanoseconds),
            lists_per_step,
            phases,
        }
    }
}
