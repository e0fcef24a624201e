//! What species, system and pairs must fulfil.

use super::Input;
use super::field::wrong_expression;
use super::validate::{Invalid, number, rounded, written};
use mesoflux_core::integrate::Thermostat;
use mesoflux_core::potential::Requirement;

/// The most particles a system may have: places in a list are 32-bit numbers.
pub(super) const MOST_PARTICLES: u64 = u32::MAX as u64;

impl Input {
    /// Names that pairs can be made of, masses, counts.
    pub(super) fn validate_species(&self) -> Result<(), Invalid> {
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
            if self.species.len() > 1 && species.particles.is_none() && !self.beads().contains_key(name) {
                return Err(Invalid::new(
                    path,
                    "",
                    "particles is missing: with several species each must say how many it has, unless molecules are made of it",
                ));
            }
        }
        if self.species.len() > 255 {
            return Err(Invalid::new("species", self.species.len(), "must be at most 255 species"));
        }
        Ok(())
    }

    /// Particles, density and box that fit together.
    pub(super) fn validate_system(&self) -> Result<(), Invalid> {
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
        let counted = self.counted().unwrap_or(0);
        if let Some(particles) = system.particles.filter(|&particles| counted > 0 && particles != counted) {
            let requirement = format!("must be the sum of the species' particles, {counted}");
            return Err(Invalid::new("system.particles", particles, requirement));
        }
        let known = [
            self.system.particles.is_some() || counted > 0 || !self.molecule.is_empty(),
            system.density.is_some(),
            system.sides.is_some(),
        ];
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
            (Some(density), Some(sides)) if system.particles.is_some() || counted > 0 => {
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

    /// Pairs of known species, each once, with parameters that can be.
    pub(super) fn validate_pairs(&self) -> Result<(), Invalid> {
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
            let potential = pair.potential.as_ref().and_then(Option::as_ref);
            let fault = potential.and_then(|law| Some(("potential", law_name(law), "energy", law.fault()?)));
            let friction = pair.friction.as_ref().and_then(Option::as_ref);
            let fault =
                fault.or_else(|| friction.and_then(|law| Some(("friction", law_name(law), "friction", law.fault()?))));
            let potential = potential.map(|law| ("potential", law_name(law), law.parameters()));
            let friction = friction.map(|law| ("friction", law_name(law), law.parameters()));
            for (role, law, parameters) in potential.into_iter().chain(friction) {
                for (parameter, value, requirement) in parameters {
                    number(&format!("{path}.{role}.{law}.{parameter}"), value, requirement)?;
                }
            }
            if let Some((role, law, key, fault)) = fault {
                return Err(wrong_expression(&format!("{path}.{role}.{law}"), key, fault));
            }
        }
        if self.interactions().cutoff() == 0.0 {
            let frictions = self.dynamics.thermostat == Thermostat::PairOrnsteinUhlenbeck;
            let laws = if frictions { "potential or friction" } else { "potential" };
            return Err(Invalid::new("pair", "", format!("must give at least one {laws}, e.g. in [pair.all]")));
        }
        Ok(())
    }
}

/// The name of a law in the input file.
fn law_name(law: &impl serde::Serialize) -> String {
    match toml::Value::try_from(law) {
        Ok(toml::Value::Table(table)) => table.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}
