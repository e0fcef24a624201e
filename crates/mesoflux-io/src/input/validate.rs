//! What an input must fulfil beyond its form; each fault with the path, the value and the requirement.

use super::Input;
use mesoflux_core::integrate::{Langevin, Thermostat};
use mesoflux_core::potential::Requirement;
use std::fmt::Display;
use std::ops::Range;

/// A value that can't be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Invalid {
    /// Where the value stands: the dotted path of its key.
    pub path: String,
    /// The value, as a reader would write it; empty where it is missing.
    pub value: String,
    /// What is required.
    pub requirement: String,
    /// What might help.
    pub help: Option<String>,
    /// Which bytes of a text in quotes are at fault, and how to show them where the file writes it otherwise.
    pub within: Option<Box<(Range<usize>, String)>>,
}

impl Invalid {
    /// A fault of the value at a path.
    pub fn new(path: impl Into<String>, value: impl Display, requirement: impl Display) -> Self {
        Self {
            path: path.into(),
            value: value.to_string(),
            requirement: requirement.to_string(),
            help: None,
            within: None,
        }
    }

    /// The fault of a part of a text.
    pub(super) fn within(mut self, range: Range<usize>, shown: Option<String>) -> Self {
        self.within = shown.map(|shown| Box::new((range, shown)));
        self
    }

    /// The fault with what might help.
    pub(super) fn helped(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

impl Display for Invalid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.value.as_str() {
            "" => write!(f, "{}: {}", self.path, self.requirement),
            value => write!(f, "{} = {value}: {}", self.path, self.requirement),
        }
    }
}

/// A number that must meet a requirement.
pub(super) fn number(path: &str, value: f64, requirement: Requirement) -> Result<(), Invalid> {
    if requirement.holds(value) { Ok(()) } else { Err(Invalid::new(path, written(value), requirement)) }
}

/// A number as an input file writes it: `-1.0`, `1e30`, `nan`.
pub(super) fn written(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1e7 { format!("{value:e}") } else { format!("{value:?}").to_lowercase() }
}

/// A number to six digits, for reading.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A bound to six digits that is not below the exact one, but for the rounding of the last bits.
fn rounded_up(value: f64) -> f64 {
    let up = rounded(value);
    if up < value * (1.0 - 1e-12) { rounded(value * (1.0 + 5e-6)) } else { up }
}

/// Thirty years: what a clock can hold, and nobody waits for.
const LONGEST_WALL_SECONDS: f64 = 1e9;

impl Input {
    /// Checks everything that the form alone doesn't guarantee.
    pub(super) fn validate(&self) -> Result<(), Invalid> {
        self.validate_molecules()?;
        self.validate_species()?;
        self.validate_system()?;
        self.validate_beads()?;
        self.validate_molecules_of_start()?;
        self.validate_pairs()?;
        self.validate_dynamics()?;
        self.validate_run()?;
        self.validate_fields()?;
        if self.check.time_step.is_some() {
            self.at_half_time_step().validate_run()?;
        }
        self.measure.iter().try_for_each(|(name, measure)| self.validate_measure(&format!("measure.{name}"), measure))
    }

    fn validate_dynamics(&self) -> Result<(), Invalid> {
        let dynamics = &self.dynamics;
        number("dynamics.temperature", dynamics.temperature, Requirement::Positive)?;
        number("dynamics.time_step", dynamics.time_step, Requirement::Positive)?;
        if let Thermostat::Langevin(Langevin { friction }) = dynamics.thermostat {
            number("dynamics.thermostat.langevin.friction", friction, Requirement::Positive)?;
        }
        let other = dynamics.velocity_verlet.as_ref().map(|_| "velocity_verlet");
        let other = other.or_else(|| dynamics.explicit.as_ref().map(|_| "explicit"));
        if let Some(scheme) = other {
            return self.validate_scheme_without_letters(scheme);
        }
        if dynamics.word.is_none() && dynamics.thermostat == Thermostat::None {
            return Err(Invalid::new(
                "dynamics.thermostat",
                "\"none\"",
                "needs a word without the letter O, e.g. word = \"BAB\" for constant energy",
            ));
        }
        self.validate_pair_thermostat()?;
        self.integrator().map_err(|error| Invalid::new("dynamics.word", format!("{:?}", dynamics.word()), error))?;
        self.validate_unused_friction()
    }

    /// Velocity Verlet or the explicit scheme, without anything that only letters have.
    fn validate_scheme_without_letters(&self, scheme: &str) -> Result<(), Invalid> {
        let dynamics = &self.dynamics;
        if let Some(word) = &dynamics.word {
            let requirement = format!("must be left out where {scheme} is given");
            return Err(Invalid::new("dynamics.word", format!("{word:?}"), requirement));
        }
        if scheme != "explicit" && dynamics.explicit.is_some() {
            return Err(Invalid::new("dynamics.explicit", "", format!("must be left out where {scheme} is given")));
        }
        if matches!(dynamics.thermostat, Thermostat::Langevin(_)) {
            let requirement =
                format!("must be left out where {scheme} is given: friction and noise of pairs are its thermostat");
            return Err(Invalid::new("dynamics.thermostat.langevin", "", requirement));
        }
        match &dynamics.velocity_verlet {
            Some(scheme) if !(0.0..=1.0).contains(&scheme.lambda) => {
                Err(Invalid::new("dynamics.velocity_verlet.lambda", written(scheme.lambda), "must be from 0 to 1"))
            }
            _ => Ok(()),
        }
    }

    /// The pair thermostat needs a friction.
    fn validate_pair_thermostat(&self) -> Result<(), Invalid> {
        if self.dynamics.thermostat != Thermostat::PairOrnsteinUhlenbeck || self.has_friction() {
            return Ok(());
        }
        let requirement = "needs a friction between some pair: give pair.all.friction, or thermostat = \"none\" with a word such as \"BAB\" for constant energy";
        Err(Invalid::new("dynamics.thermostat", "\"pair_ornstein_uhlenbeck\"", requirement))
    }

    /// No friction between pairs where no letter would use it.
    fn validate_unused_friction(&self) -> Result<(), Invalid> {
        let requirement = match self.dynamics.thermostat {
            Thermostat::PairOrnsteinUhlenbeck => return Ok(()),
            Thermostat::Langevin(_) => {
                "must be left out with dynamics.thermostat.langevin, whose drag is on each particle alone: no letter would use it"
            }
            Thermostat::None => "must be left out with dynamics.thermostat = \"none\": no letter would use it",
        };
        let given = self.pair.iter().find(|(_, pair)| pair.friction.as_ref().is_some_and(Option::is_some));
        given.map_or(Ok(()), |(name, _)| Err(Invalid::new(format!("pair.{name}.friction"), "", requirement)))
    }

    fn validate_run(&self) -> Result<(), Invalid> {
        let run = &self.run;
        number("run.equilibration_time", run.equilibration_time, Requirement::NotNegative)?;
        number("run.production_time", run.production_time, Requirement::Positive)?;
        if self.steps(run.production_time) == 0 {
            let requirement = format!("must be at least one time step, {}", self.dynamics.time_step);
            return Err(Invalid::new("run.production_time", written(run.production_time), requirement));
        }
        for (path, time) in
            [("run.equilibration_time", run.equilibration_time), ("run.production_time", run.production_time)]
        {
            if time / self.dynamics.time_step > 2f64.powi(47) {
                let most = rounded(2f64.powi(47) * self.dynamics.time_step);
                return Err(Invalid::new(path, written(time), format!("must be at most 2^47 time steps, {most:e}")));
            }
        }
        number("run.checkpoint_wall_seconds", run.checkpoint_wall_seconds, Requirement::Positive)?;
        if run.checkpoint_wall_seconds > LONGEST_WALL_SECONDS {
            let requirement = format!("must be at most {LONGEST_WALL_SECONDS:e}");
            return Err(Invalid::new("run.checkpoint_wall_seconds", written(run.checkpoint_wall_seconds), requirement));
        }
        let counts = [("run.replicas", Some(run.replicas)), ("run.sample_interval", Some(run.sample_interval))];
        for (path, value) in counts.into_iter().chain([("run.checkpoint_interval", run.checkpoint_interval)]) {
            if let Some(value @ 0) = value {
                return Err(Invalid::new(path, value, "must be at least 1"));
            }
        }
        if let Some(skin) = run.skin {
            number("run.skin", skin, Requirement::Positive)?;
        }
        self.validate_box()
    }

    /// No pair may meet in two images.
    pub(super) fn validate_box(&self) -> Result<(), Invalid> {
        let region = self.region().map_err(|error| Invalid::new("system", "", error))?;
        let (cutoff, skin, side) = (self.interactions().cutoff(), self.skin(), region.shortest_side());
        let smallest = 2.0 * (cutoff + skin);
        if side >= smallest {
            return Ok(());
        }
        let reason = format!("twice the list radius (largest cutoff {cutoff} plus skin {})", rounded(skin));
        if self.run.skin.is_some() && side >= 2.1 * cutoff {
            let room = rounded(0.5 * side - cutoff);
            let requirement =
                format!("must be below {room}, or the box of side {} is narrower than {reason}", rounded(side));
            return Err(Invalid::new("run.skin", written(skin), requirement));
        }
        let requirement = format!(
            "the shortest side of the box is {}, must be at least {}: {reason}, so that no pair meets in two images",
            rounded(side),
            rounded_up(smallest)
        );
        if self.system.sides.is_some() {
            return Err(Invalid::new("system.box", "", requirement));
        }
        let density = self.system.density.unwrap_or(f64::NAN);
        let particles = (density * smallest.powi(3)).ceil();
        let help = format!("at density {density} that takes at least {particles} particles");
        Err(Invalid::new("system", "", requirement).helped(Some(help)))
    }
}
