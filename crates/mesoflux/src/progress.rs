//! How far a job is: a bar on a terminal, nothing anywhere else.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mesoflux_core::system::System;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps between two looks at the temperature.
const LOOK: u64 = 200;

/// Counts steps of all runs; safe to share between threads.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    steps: AtomicU64,
}

impl Progress {
    /// A bar for `steps` steps; invisible if `quiet` or if standard error is no terminal.
    pub fn new(steps: u64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(steps), target);
        let template = "{bar:30} {percent:>3} %  {elapsed} elapsed, {eta} left  {msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
        }
        Self { bar, steps: AtomicU64::new(0) }
    }

    /// One step of one run was done.
    pub fn step(&self, system: &System) {
        let done = self.steps.fetch_add(1, Ordering::Relaxed) + 1;
        if system.step.is_multiple_of(LOOK) {
            self.bar.set_position(done);
            if !self.bar.is_hidden() {
                self.bar.set_message(format!("kT = {:.3}", system.kinetic_temperature()));
            }
        }
    }

    /// Steps that an earlier session did.
    pub fn skip(&self, steps: u64) {
        self.steps.fetch_add(steps, Ordering::Relaxed);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
