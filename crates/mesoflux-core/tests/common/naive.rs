//! Naive references: particles in the order of their ids, all pairs, minimum image, no list.

use super::{by_id, unwrapped};
use mesoflux_core::bond::{Bond, Topology};
use mesoflux_core::domain::Workers;
use mesoflux_core::forcing::ForcingField;
use mesoflux_core::integrate::Schedule;
use mesoflux_core::interactions::Interactions;
use mesoflux_core::noise::{Draw, NoiseKey, Purpose};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO, add_scaled, dot, subtract};

/// A state without any of the engine's machinery.
#[derive(Clone)]
pub struct Naive {
    pub sides: Vector,
    pub interactions: Interactions,
    pub topology: Topology,
    /// How many bonds lie between every two particles.
    pub apart: Vec<Vec<u32>>,
    pub temperature: f64,
    pub species: Vec<u8>,
    pub mass: Vec<f64>,
    pub q: Vec<Vector>,
    pub p: Vec<Vector>,
    pub step: u64,
}

/// The number of bonds on the shortest way between every two particles (Floyd and Warshall).
fn bonds_apart(topology: &Topology, count: usize) -> Vec<Vec<u32>> {
    let mut apart = vec![vec![u32::MAX / 4; count]; count];
    for bond in topology.bonds() {
        let (i, j) = (bond.first as usize, bond.second as usize);
        (apart[i][j], apart[j][i]) = (1, 1);
    }
    if !topology.bonds().is_empty() {
        for k in 0..count {
            for i in 0..count {
                for j in 0..count {
                    apart[i][j] = apart[i][j].min(apart[i][k] + apart[k][j]);
                }
            }
        }
    }
    apart
}

impl Naive {
    pub fn of(system: &System) -> Self {
        let particles = &system.particles;
        Self {
            sides: system.region.sides(),
            interactions: system.interactions.clone(),
            topology: system.topology().clone(),
            apart: bonds_apart(system.topology(), particles.count()),
            temperature: 1.0,
            species: by_id(particles, &particles.species),
            mass: by_id(particles, &particles.inverse_mass).iter().map(|w| 1.0 / w).collect(),
            q: unwrapped(system),
            p: by_id(particles, &particles.momentum),
            step: system.step,
        }
    }

    /// r and e of a pair's nearest images.
    fn separation(&self, i: usize, j: usize) -> (f64, Vector) {
        let d = subtract(self.q[i], self.q[j]);
        let d: Vector = std::array::from_fn(|k| d[k] - self.sides[k] * (d[k] / self.sides[k]).round());
        let r = dot(d, d).sqrt();
        (r, d.map(|d| d / r))
    }

    fn strength(&self, i: usize, j: usize, r: f64) -> f64 {
        if self.apart[i][j] <= u32::from(self.topology.range().friction) {
            return 0.0;
        }
        let law = self.interactions.frictions.get(self.species[i], self.species[j]);
        law.map_or(0.0, |law| law.strength(r))
    }

    /// Conservative forces, and for each particle the sum of their magnitudes.
    pub fn forces(&self) -> (Vec<Vector>, Vec<f64>) {
        let (mut force, mut magnitude) = (vec![ZERO; self.q.len()], vec![0.0; self.q.len()]);
        for i in 0..self.q.len() {
            for j in (0..self.q.len()).filter(|&j| j != i) {
                let (r, e) = self.separation(i, j);
                let law = self.interactions.potentials.get(self.species[i], self.species[j]);
                let felt = self.apart[i][j] > u32::from(self.topology.range().potential);
                let mut f = law.as_ref().filter(|_| felt).map_or(0.0, |law| law.force(r));
                let joins = |bond: &&Bond| [(i, j), (j, i)].contains(&(bond.first as usize, bond.second as usize));
                if let Some(bond) = self.topology.bonds().iter().find(joins) {
                    f += self.topology.laws()[usize::from(bond.law)].force(r);
                }
                add_scaled(&mut force[i], f, e);
                magnitude[i] += f.abs();
            }
        }
        (force, magnitude)
    }

    /// All pairs closer than any law reaches, the smaller id first.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        let all = (0..self.q.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        all.filter(|&(i, j)| self.separation(i, j).0 < self.interactions.cutoff()).collect()
    }

    pub fn drift(&mut self, t: f64) {
        for i in 0..self.q.len() {
            add_scaled(&mut self.q[i], t / self.mass[i], self.p[i]);
        }
    }

    pub fn kick(&mut self, t: f64) {
        let force = self.forces().0;
        for (p, f) in self.p.iter_mut().zip(force) {
            add_scaled(p, t, f);
        }
    }

    /// Eqs 27–29 for the pairs in the given order; returns Δp^D of eqs 60–61.
    pub fn thermostat(&mut self, t: f64, order: &[(usize, usize)], draw: Draw) -> Vec<Vector> {
        let mut dissipative = vec![ZERO; self.p.len()];
        for &(i, j) in order {
            let (r, e) = self.separation(i, j);
            let reduced = self.mass[i] * self.mass[j] / (self.mass[i] + self.mass[j]);
            let tau = self.strength(i, j, r) / reduced;
            let u = dot(e, self.p[i]) / self.mass[i] - dot(e, self.p[j]) / self.mass[j];
            let dv = u * (-tau * t).exp_m1();
            let noise = (self.temperature / reduced * -(-2.0 * tau * t).exp_m1()).sqrt();
            let dv_random = noise * draw.pair_gaussian(i as u64, j as u64);
            for (k, sign) in [(i, 1.0), (j, -1.0)] {
                add_scaled(&mut self.p[k], sign * reduced * (dv + dv_random), e);
                add_scaled(&mut dissipative[k], sign * reduced * dv, e);
            }
        }
        dissipative
    }

    /// Groot and Warren's total force at the given velocities, with the noise of `step`.
    fn total_force(&self, velocity: &[Vector], dt: f64, noise: NoiseKey, step: u64) -> Vec<Vector> {
        let draw = noise.draw(Purpose::Pair, step, 0);
        let mut force = self.forces().0;
        for (i, j) in self.pairs() {
            let (r, e) = self.separation(i, j);
            let strength = self.strength(i, j, r);
            let u = dot(e, subtract(velocity[i], velocity[j]));
            let random = (2.0 * strength * self.temperature / dt).sqrt() * draw.pair_gaussian(i as u64, j as u64);
            add_scaled(&mut force[i], random - strength * u, e);
            add_scaled(&mut force[j], strength * u - random, e);
        }
        force
    }

    /// Steps of Groot and Warren's eq. 17.
    pub fn velocity_verlet(&mut self, steps: u64, dt: f64, lambda: f64, noise: NoiseKey) {
        let over_mass =
            |p: &[Vector], mass: &[f64]| -> Vec<Vector> { p.iter().zip(mass).map(|(p, m)| p.map(|p| p / m)).collect() };
        let mut force = self.total_force(&over_mass(&self.p, &self.mass), dt, noise, self.step);
        for _ in 0..steps {
            let mut predicted = self.p.clone();
            for i in 0..self.q.len() {
                add_scaled(&mut self.q[i], dt / self.mass[i], self.p[i]);
                add_scaled(&mut self.q[i], 0.5 * dt * dt / self.mass[i], force[i]);
                add_scaled(&mut predicted[i], lambda * dt, force[i]);
                add_scaled(&mut self.p[i], 0.5 * dt, force[i]);
            }
            self.step += 1;
            force = self.total_force(&over_mass(&predicted, &self.mass), dt, noise, self.step);
            for (p, &f) in self.p.iter_mut().zip(&force) {
                add_scaled(p, 0.5 * dt, f);
            }
        }
    }

    /// The particles as a forcing sees them.
    pub fn particles(&self) -> Particles {
        let mut particles = Particles::at_rest(self.q.clone(), vec![0; self.q.len()], &[1.0]);
        particles.inverse_mass = self.mass.iter().map(|m| 1.0 / m).collect();
        particles.momentum.clone_from(&self.p);
        particles
    }

    /// Brings a forcing's F, G and F·G to this state.
    fn evaluate(&self, field: &mut ForcingField) {
        field.update(&self.particles(), self.step, true, Workers::One);
    }

    /// R = G·p.
    pub fn flux(&self, field: &mut ForcingField) -> f64 {
        self.evaluate(field);
        field.response.iter().zip(&self.p).map(|(g, &p)| dot(g.vector(), p)).sum()
    }

    /// p += ξF with R = r afterwards; returns ξ (eqs 42, 45, 50).
    pub fn project(&mut self, field: &mut ForcingField, r: f64) -> f64 {
        let multiplier = (r - self.flux(field)) / field.control;
        for (p, &f) in self.p.iter_mut().zip(&field.force) {
            add_scaled(p, multiplier, f);
        }
        multiplier
    }

    /// One step of a word; `order(place, self)` gives the pairs in the order of the sweep at that place.
    ///
    /// `after(self, symbol, time, Δp^D)` acts after each letter.
    pub fn word(
        &mut self,
        schedule: &Schedule,
        dt: f64,
        noise: NoiseKey,
        mut order: impl FnMut(usize, &Self) -> Vec<(usize, usize)>,
        mut after: impl FnMut(&mut Self, char, f64, &[Vector]),
    ) {
        for (place, (letter, share)) in schedule.entries().iter().enumerate() {
            let (t, mut dissipative) = (share * dt, Vec::new());
            match letter.symbol() {
                'A' => self.drift(t),
                'B' => self.kick(t),
                _ => {
                    let draw = noise.draw(Purpose::Pair, self.step, place as u64);
                    dissipative = self.thermostat(t, &order(place, self), draw);
                }
            }
            after(self, letter.symbol(), t, &dissipative);
        }
        self.step += 1;
    }
}
