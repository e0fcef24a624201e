//! One call of the benchmark: the parts that are wanted, in turn, each written as soon as it is done.

use crate::agreement;
use crate::comparison::compare;
use crate::failure::Failure;
use crate::kernels;
use crate::lammps::Lammps;
use crate::machine::Machine;
use crate::options::{LEAST_ROUNDS, Options};
use crate::ours;
use crate::report;
use crate::scale;
use crate::store::Results;

/// Runs what the options want.
pub fn run(options: &Options) -> Result<(), Failure> {
    let works = options.works()?;
    let lammps = Lammps::find(options.lammps().as_deref())?;
    if lammps.is_none() && !works.is_empty() {
        eprintln!("no LAMMPS: its columns stay empty (--lammps PATH, or `lmp` on the path)");
    }
    let machine = Machine::here(lammps.as_ref());
    let written = options.written();
    let mut results = match &written {
        Some(directory) => Results::read(directory)?,
        None => Results::default(),
    };
    let lammps_before = results.machine.lammps.take();
    results.machine = Machine { lammps: machine.lammps.clone().or(lammps_before), ..machine.clone() };
    let write = |results: &Results| written.iter().try_for_each(|directory| results.write(directory));
    for work in works {
        if let Some(lammps) = &lammps {
            results.agreed(agreement::check(options, work, lammps, &machine.date)?);
        }
        for &threads in options.threads() {
            results.compared(compare(options, work, threads, lammps.as_ref(), &machine)?);
        }
        write(&results)?;
    }
    if options.wants(options.ours) {
        results.ours = Some(ours::measure(options, &machine)?);
        write(&results)?;
    }
    if options.wants(options.kernels) {
        results.kernels = Some(kernels::measure(options, &machine)?);
        write(&results)?;
    }
    if options.wants(options.scale) {
        results.scale = Some(scale::measure(options, &machine)?);
        write(&results)?;
    }
    print!("{}", report::render(&results));
    match &written {
        Some(directory) => eprintln!("written to {}", directory.display()),
        None if options.small => eprintln!("nothing written: tiny systems need --output"),
        None => eprintln!("nothing written: fewer than {LEAST_ROUNDS} rounds"),
    }
    Ok(())
}
