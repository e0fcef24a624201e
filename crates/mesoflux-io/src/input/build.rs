//! From the input's numbers to the engine's objects; defaults that follow from other numbers are derived here.

use super::{Input, SpeciesInput};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::integrate::{Explicit, Integrator, Schedule, Thermostat, VelocityVerlet, WordError};
use mesoflux_core::interactions::{Interactions, PairTable};
use mesoflux_core::vector::Vector;
use std::collections::BTreeMap;

impl Input {
    /// The species in the order of their names; one of mass 1 where none is named.
    pub fn species(&self) -> Vec<(String, SpeciesInput)> {
        if self.species.is_empty() {
            return vec![("fluid".to_owned(), SpeciesInput::default())];
        }
        self.species.iter().map(|(name, species)| (name.clone(), species.clone())).collect()
    }

    /// N, from whatever says it.
    pub fn particles(&self) -> u64 {
        let positive = |n: &u64| *n > 0;
        let by_density = || Some((self.system.density? * self.system.sides?.iter().product::<f64>()).round() as u64);
        let by_species = || self.counted().filter(positive);
        let by_molecules = || Some(self.beads().values().copied().fold(0, u64::saturating_add)).filter(positive);
        self.system.particles.or_else(by_species).or_else(by_density).or_else(by_molecules).unwrap_or(0)
    }

    /// N where the species say it: each its own number, or that of its beads in molecules.
    pub(super) fn counted(&self) -> Option<u64> {
        let beads = if self.species.len() > 1 { self.beads() } else { BTreeMap::new() };
        let count = |(name, species): (&String, &SpeciesInput)| {
            species.particles.or_else(|| beads.get(name).copied().filter(|&beads| beads > 0))
        };
        self.species.iter().map(count).try_fold(0u64, |sum, count| Some(sum.saturating_add(count?)))
    }

    /// How many particles each species has.
    pub fn species_counts(&self) -> Vec<usize> {
        let species = self.species();
        match species.as_slice() {
            [(_, only)] => vec![only.particles.unwrap_or_else(|| self.particles()) as usize],
            several => {
                let beads = self.beads();
                let count = |(name, species): &(String, SpeciesInput)| {
                    species.particles.or_else(|| beads.get(name).copied()).unwrap_or(0) as usize
                };
                several.iter().map(count).collect()
            }
        }
    }

    /// The masses in the order of the species.
    pub fn masses(&self) -> Vec<f64> {
        self.species().iter().map(|(_, species)| species.mass).collect()
    }

    /// Whether something holds the temperature.
    pub fn is_thermostatted(&self) -> bool {
        match self.dynamics.thermostat {
            Thermostat::Langevin(_) => true,
            Thermostat::PairOrnsteinUhlenbeck => self.has_friction(),
            Thermostat::None => !self.dynamics.has_word() && self.has_friction(),
        }
    }

    /// Whether some pair feels a friction.
    pub(super) fn has_friction(&self) -> bool {
        self.interactions().frictions.entries().iter().any(Option::is_some)
    }

    /// Whether the integrator leaves the total momentum as it was, but for external fields.
    pub fn integrator_conserves_momentum(&self) -> bool {
        self.integrator().is_ok_and(|integrator| integrator.conserves_momentum())
    }

    /// The sides of the box: given, or a cube of the given density.
    pub fn sides(&self) -> Vector {
        self.system.sides.unwrap_or_else(|| {
            let volume = self.particles() as f64 / self.system.density.unwrap_or(f64::NAN);
            [volume.cbrt(); 3]
        })
    }

    /// The box.
    ///
    /// # Errors
    /// A side that is not positive and finite.
    pub fn region(&self) -> Result<PeriodicBox, mesoflux_core::boundary::BoxError> {
        PeriodicBox::new(self.sides())
    }

    /// All pair laws: those of `pair.all`, overridden where a pair of species says otherwise.
    pub fn interactions(&self) -> Interactions {
        let species = self.species();
        let find = |a: usize, b: usize| {
            let named = |x: &str, y: &str| self.pair.get(&format!("{x}-{y}"));
            named(&species[a].0, &species[b].0).or_else(|| named(&species[b].0, &species[a].0))
        };
        let all = self.pair.get("all");
        Interactions {
            potentials: PairTable::from_fn(species.len(), |a, b| {
                find(a, b).and_then(|pair| pair.potential.clone()).or_else(|| all?.potential.clone()).flatten()
            }),
            frictions: PairTable::from_fn(species.len(), |a, b| {
                find(a, b).and_then(|pair| pair.friction.clone()).or_else(|| all?.friction.clone()).flatten()
            }),
            inverse_reduced_masses: PairTable::from_fn(species.len(), |a, b| {
                1.0 / species[a].1.mass + 1.0 / species[b].1.mass
            }),
        }
    }

    /// How far the neighbor list sees beyond the largest cutoff `r_c`.
    ///
    /// If not given, it follows from the input alone, never from timings. A thin skin, where pairs are kept from one sorting of
    /// the particles to the next, costs 3 s/r_c of the work on the pairs; sorting and searching cost about as much as 0.4 times
    /// that work, every s/d steps, where d = 9 Δt √(kT/m) is how far the two fastest particles fly in a step. The sum is least
    /// at s² = 0.14 d r_c. Where that is not thin, pairs are searched at every step, and the skin is what a thermal particle
    /// flies in forty steps, kept within a tenth and three tenths of r_c, and no more than the box allows as long as a
    /// twentieth of r_c is left.
    pub fn skin(&self) -> f64 {
        self.run.skin.unwrap_or_else(|| {
            let cutoff = self.interactions().cutoff();
            let lightest = self.masses().into_iter().fold(f64::INFINITY, f64::min);
            let flight = self.dynamics.time_step * (self.dynamics.temperature / lightest).sqrt();
            let room = 0.5 * self.sides().into_iter().fold(f64::INFINITY, f64::min) - cutoff;
            let thin = (0.14 * 9.0 * flight * cutoff).sqrt().max(0.002 * cutoff);
            if thin <= 0.05 * cutoff {
                return thin.min((1.0 - 1e-12) * room).max(0.002 * cutoff);
            }
            let thick = (40.0 * flight).clamp(0.1 * cutoff, 0.3 * cutoff);
            // A whisker below what fits, so that rounding can't make the box too small for its own skin.
            thick.min((1.0 - 1e-12) * room).max(0.05 * cutoff)
        })
    }

    /// N ρ/2 times the volume within the largest cutoff: the pairs of a fluid without structure.
    pub fn expected_pairs(&self) -> f64 {
        let particles = self.particles() as f64;
        let density = particles / self.sides().iter().product::<f64>();
        0.5 * particles * density * 4.0 / 3.0 * std::f64::consts::PI * self.interactions().cutoff().powi(3)
    }

    /// The integrator that the input names.
    ///
    /// # Errors
    /// A word that is none.
    pub fn integrator(&self) -> Result<Integrator, WordError> {
        let dynamics = &self.dynamics;
        let temperature = dynamics.temperature;
        Ok(match (&dynamics.velocity_verlet, &dynamics.explicit) {
            (Some(scheme), _) => {
                Integrator::VelocityVerlet(VelocityVerlet::new(temperature, scheme.lambda, scheme.correction))
            }
            (None, Some(scheme)) => Integrator::Explicit(Explicit::new(temperature, scheme.correction)),
            (None, None) => Integrator::Splitting(Schedule::new(
                dynamics.word(),
                dynamics.thermostat,
                dynamics.temperature,
                dynamics.sweep,
            )?),
        })
    }

    /// The number of steps nearest to a time.
    pub fn steps(&self, time: f64) -> u64 {
        (time / self.dynamics.time_step).round() as u64
    }

    /// The input with everything it left open filled in; what the points of a sweep may each decide otherwise stays open.
    #[must_use]
    pub fn with_defaults(&self) -> Self {
        let mut input = self.clone();
        input.species = self.species().into_iter().collect();
        if input.dynamics.has_word() {
            input.dynamics.word = Some(self.dynamics.word().to_owned());
        }
        for measure in input.measure.values_mut() {
            measure.routes = measure.quantity.default_routes(&measure.routes);
            measure.fill_forcing();
            measure.fill_momentum_exchange();
        }
        if self.sweep.is_empty() {
            input.derive();
        }
        input
    }

    /// Fills in what follows from other numbers.
    fn derive(&mut self) {
        let (particles, sides, counts, skin) = (self.particles(), self.sides(), self.species_counts(), self.skin());
        self.system.particles = Some(particles);
        self.system.sides = Some(sides);
        self.system.density = Some(particles as f64 / sides.iter().product::<f64>());
        for (species, count) in self.species.values_mut().zip(counts) {
            species.particles = Some(count as u64);
        }
        self.run.skin = Some(skin);
        for msd in self.measure.values_mut().filter_map(|measure| measure.routes.msd.as_mut()) {
            msd.longest_lag = Some(msd.longest_lag(self.run.production_time));
        }
        let asked = self.clone();
        for routes in self.measure.values_mut().map(|measure| &mut measure.routes) {
            if let Some(histogram) = &mut routes.histogram {
                histogram.longest_distance = Some(asked.longest_distance(histogram));
            }
            if let Some(fluctuation) = &mut routes.fluctuation {
                fluctuation.largest_wave_number = Some(asked.largest_wave_number(fluctuation));
            }
        }
    }
}
