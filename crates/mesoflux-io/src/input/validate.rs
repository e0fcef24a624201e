//! What an input must fulfil beyond its form; each fault with the path, the value and the requirement.

use super::Input;
use mesoflux_core::integrate::Thermostat;
use mesoflux_core::potential::Requirement;
use std::fmt::Display;

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
}

impl Invalid {
    /// A fault of the value at a path.
    pub fn new(path: impl Into<String>, value: impl Display, requirement: impl Display) -> Self {
        Self { path: path.into(), value: value.to_string(), requirement: requirement.to_string(), help: None }
    }

    fn helped(mut self, help: Option<String>) -> Self {
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
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A bound to six digits that is not below the exact one, but for the rounding of the last bits.
fn rounded_up(value: f64) -> f64 {
    let up = rounded(value);
    if up < value * (1.0 - 1e-12) { rounded(value * (1.0 + 5e-6)) } else { up }
}

/// The most particles a system may have: places in a list are 32-bit numbers.
const MOST_PARTICLES: u64 = u32::MAX as u64;

/// Thirty years: what a clock can hold, and nobody waits for.
const LONGEST_WALL_SECONDS: f64 = 1e9;

impl Input {
    /// Checks everything that the form alone doesn't guarantee.
    pub(super) fn validate(&self) -> Result<(), Invalid> {
        self.validate_species()?;
        self.validate_system()?;
        self.validate_pairs()?;
        self.validate_dynamics()?;
        self.validate_run()?;
        self.measure.iter().try_for_each(|(name, measure)| self.validate_measure(&format!("measure.{name}"), measure))
    }

    fn validate_species(&self) -> Result<(), Invalid> {
        for (name, species) in &self.species {
            let path = format!("species.{name}");
            if name.contains('-') || name == "all" {
                return Err(Invalid::new(
                    path,
                    "",
                    "must be a name without '-' other than \"all\", so that pairs can be named",
                ));
            }
            number(&format!("{path}.mass"), species.mass, Requirement::Positive)?;
            if self.species.len() > 1 && species.particles.is_none() {
                return Err(Invalid::new(
                    path,
                    "",
                    "particles is missing: with several species each must say how many it has",
                ));
            }
        }
        if self.species.len() > 255 {
            return Err(Invalid::new("species", self.species.len(), "must be at most 255 species"));
        }
        Ok(())
    }

    fn validate_system(&self) -> Result<(), Invalid> {
        let system = &self.system;
        if let Some(density) = system.density {
            number("system.density", density, Requirement::Positive)?;
        }
        for (axis, &side) in system.sides.iter().flatten().enumerate() {
            number(&format!("system.box.{axis}"), side, Requirement::Positive)?;
        }
        for (name, species) in &self.species {
            if species.particles.is_some_and(|particles| particles > MOST_PARTICLES) {
                let path = format!("species.{name}.particles");
                let requirement = format!("must be at most {MOST_PARTICLES}");
                return Err(Invalid::new(path, species.particles.unwrap_or(0), requirement));
            }
        }
        let counted: u64 = self.species.values().filter_map(|species| species.particles).sum();
        if let Some(particles) = system.particles.filter(|&particles| counted > 0 && particles != counted) {
            let requirement = format!("must be the sum of the species' particles, {counted}");
            return Err(Invalid::new("system.particles", particles, requirement));
        }
        let known = [self.system.particles.is_some() || counted > 0, system.density.is_some(), system.sides.is_some()];
        if known.iter().filter(|&&known| known).count() < 2 {
            return Err(Invalid::new("system", "", "must give two of particles, density and box"));
        }
        let particles = self.particles();
        let requirement = format!("must be from 2 to {MOST_PARTICLES}");
        match system.particles {
            _ if (2..=MOST_PARTICLES).contains(&particles) => {}
            Some(particles) => return Err(Invalid::new("system.particles", particles, requirement)),
            None => {
                return Err(Invalid::new(
                    "system",
                    "",
                    format!("density and box give {particles} particles: {requirement}"),
                ));
            }
        }
        match (system.density, system.sides) {
            (Some(density), Some(sides)) if known[0] => {
                let decided = particles as f64 / sides.iter().product::<f64>();
                if (density - decided).abs() > 1e-9 * decided {
                    let requirement =
                        format!("must be left out: particles and box decide the density, {}", rounded(decided));
                    return Err(Invalid::new("system.density", written(density), requirement));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn validate_pairs(&self) -> Result<(), Invalid> {
        let species = self.species();
        for (name, pair) in &self.pair {
            let path = format!("pair.{name}");
            if name != "all" {
                let known = |part: &str| species.iter().any(|(name, _)| name == part);
                match name.split_once('-') {
                    Some((a, b)) if known(a) && known(b) => {
                        if a != b && self.pair.contains_key(&format!("{b}-{a}")) {
                            return Err(Invalid::new(path, "", format!("must be given once, here or as pair.{b}-{a}")));
                        }
                    }
                    _ if self.species.is_empty() => {
                        let requirement = "must be \"all\" where no species are named; name them in [species.NAME]";
                        return Err(Invalid::new(path, "", requirement));
                    }
                    _ => {
                        let names: Vec<&str> = species.iter().map(|(name, _)| name.as_str()).collect();
                        let pairs = names.iter().flat_map(|a| names.iter().map(move |b| format!("{a}-{b}")));
                        let known: Vec<String> = pairs.chain(["all".to_owned()]).collect();
                        let nearest = super::diagnostic::nearest(name, &known);
                        let requirement =
                            format!("must be \"all\" or two species joined by '-', of {}", names.join(", "));
                        return Err(Invalid::new(path, "", requirement)
                            .helped(nearest.map(|n| format!("did you mean `pair.{n}`?"))));
                    }
                }
            }
            let potential = pair.potential.flatten().map(|law| ("potential", law_name(&law), law.parameters()));
            let friction = pair.friction.flatten().map(|law| ("friction", law_name(&law), law.parameters()));
            for (role, law, parameters) in potential.into_iter().chain(friction) {
                for (parameter, value, requirement) in parameters {
                    number(&format!("{path}.{role}.{law}.{parameter}"), value, requirement)?;
                }
            }
        }
        if self.interactions().cutoff() == 0.0 {
            return Err(Invalid::new("pair", "", "must give at least one potential or friction, e.g. in [pair.all]"));
        }
        Ok(())
    }

    fn validate_dynamics(&self) -> Result<(), Invalid> {
        let dynamics = &self.dynamics;
        number("dynamics.temperature", dynamics.temperature, Requirement::Positive)?;
        number("dynamics.time_step", dynamics.time_step, Requirement::Positive)?;
        let without_friction = self.interactions().frictions.entries().iter().all(Option::is_none);
        match (&dynamics.velocity_verlet, &dynamics.word) {
            (Some(_), Some(word)) => {
                let requirement = "must be left out where velocity_verlet is given";
                return Err(Invalid::new("dynamics.word", format!("{word:?}"), requirement));
            }
            (Some(scheme), None) => {
                if !(0.0..=1.0).contains(&scheme.lambda) {
                    return Err(Invalid::new(
                        "dynamics.velocity_verlet.lambda",
                        written(scheme.lambda),
                        "must be from 0 to 1",
                    ));
                }
            }
            (None, _) => {
                if dynamics.word.is_none() && dynamics.thermostat == Thermostat::None {
                    return Err(Invalid::new(
                        "dynamics.thermostat",
                        "\"none\"",
                        "needs a word without the letter O, e.g. word = \"BAB\" for constant energy",
                    ));
                }
                if without_friction && dynamics.thermostat != Thermostat::None {
                    return Err(Invalid::new(
                        "dynamics.thermostat",
                        "\"pair_ornstein_uhlenbeck\"",
                        "needs a friction between some pair: give pair.all.friction, or thermostat = \"none\" with a word such as \"BAB\" for constant energy",
                    ));
                }
                self.integrator()
                    .map_err(|error| Invalid::new("dynamics.word", format!("{:?}", dynamics.word()), error))?;
            }
        }
        Ok(())
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
    fn validate_box(&self) -> Result<(), Invalid> {
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

/// The name of a law in the input file.
fn law_name(law: &impl serde::Serialize) -> String {
    match toml::Value::try_from(law) {
        Ok(toml::Value::Table(table)) => table.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}
