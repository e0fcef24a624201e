//! `mesoflux check INPUT.toml`.

use super::session::{Failure, threads};
use crate::plan::Plan;
use crate::prediction::{duty, free_memory, memory, size};
use clap::Args;
use mesoflux_io::input::{InputFile, Setting};
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The input file
    #[arg(value_name = "INPUT.toml")]
    input: PathBuf,
    /// Set a key of the input, as for run; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    settings: Vec<Setting>,
    /// Threads for which memory and time are predicted [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4096))]
    threads: Option<u64>,
}

pub(super) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let file = InputFile::read(&arguments.input, &arguments.settings)?;
    let plan = Plan::new(&file)?;
    let mut text = toml::to_string(&file.input.with_defaults()).unwrap_or_default();
    text.push('\n');
    let mut total = 0.0;
    for point in &plan.points {
        let input = &point.input;
        let at: String = point.conditions.iter().map(|(key, value)| format!(" at {key} = {value}")).collect();
        let runs = point.runs.len() as u64 * input.run.replicas;
        let particle_steps = runs as f64 * input.particles() as f64 * point.steps() as f64;
        let pairs = input.expected_pairs();
        total += particle_steps;
        text += &format!(
            "# {}{at}: {} particles, about {pairs:.0} pairs within the cutoff, {} steps each, {particle_steps:.2e} particle-steps\n",
            counted(runs, "run"),
            input.particles(),
            point.steps(),
        );
        for run in &point.runs {
            let strength: String = run.point().iter().map(|(key, value)| format!(", {key} = {value}")).collect();
            text += &format!("#   {}{strength}, {}\n", run.name(), counted(input.run.replicas, "replica"));
        }
    }
    text += &format!("# {total:.2e} particle-steps in all\n");
    text += &predicted(&plan, threads(arguments.threads))?;
    std::io::stdout().lock().write_all(text.as_bytes()).map_err(Failure::Output)
}

/// A number of things, "1 run" or "2 runs".
fn counted(count: u64, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// Memory and time on so many threads.
fn predicted(plan: &Plan, threads: usize) -> Result<String, Failure> {
    let needed = memory(plan, threads)?;
    let free = free_memory();
    let verdict = if needed.bytes < free { "" } else { ": TOO LITTLE, such a run is refused" };
    let together = if needed.runs > 1 { format!(" for {} runs side by side", needed.runs) } else { String::new() };
    let mut text = format!(
        "# memory: about {}{together}, {:.0} bytes a particle; {} are free here{verdict}\n",
        size(needed.bytes),
        needed.per_particle,
        size(free),
    );
    if verdict.is_empty() {
        let duty = duty(plan, threads)?;
        // Fractions of a second mean nothing here.
        let whole = Duration::from_secs_f64(duty.seconds.clamp(1.0, 1e12).round());
        text += &format!(
            "# time: about {} on {}, {:.2e} particle-steps a second, as measured just now\n",
            humantime::format_duration(whole),
            counted(threads as u64, "thread"),
            duty.rate,
        );
    }
    Ok(text)
}
