//! `mesoflux check INPUT.toml`.

use super::session::Failure;
use crate::plan::Plan;
use clap::Args;
use mesoflux_io::input::{InputFile, Setting};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The input file
    #[arg(value_name = "INPUT.toml")]
    input: PathBuf,
    /// Set a key of the input, as for run; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    settings: Vec<Setting>,
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
        let pairs = expected_pairs(input);
        total += particle_steps;
        text += &format!(
            "# {runs} runs{at}: {} particles, about {pairs:.0} pairs within the cutoff, {} steps each, {particle_steps:.2e} particle-steps\n",
            input.particles(),
            point.steps(),
        );
        for run in &point.runs {
            let strength: String = run.point().iter().map(|(key, value)| format!(", {key} = {value}")).collect();
            text += &format!("#   {}{strength}, {} replicas\n", run.name(), input.run.replicas);
        }
    }
    text += &format!("# {total:.2e} particle-steps in all\n");
    std::io::stdout().lock().write_all(text.as_bytes()).map_err(Failure::Output)
}

/// N ρ/2 times the volume within the largest cutoff: the pairs of a fluid without structure.
fn expected_pairs(input: &mesoflux_io::input::Input) -> f64 {
    let particles = input.particles() as f64;
    let density = particles / input.sides().iter().product::<f64>();
    let cutoff = input.interactions().cutoff();
    0.5 * particles * density * 4.0 / 3.0 * std::f64::consts::PI * cutoff.powi(3)
}
