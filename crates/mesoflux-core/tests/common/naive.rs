//! Naive references: particles in the order of their ids, all pairs, minimum image, no list.

use super::{by_id, unwrapped};
use mesoflux_core::bond::{Bond, Topology};
use mesoflux_core::domain::Workers;
use mesoflux_core::forcing::ForcingField;
use mesoflux_core::friction::Motion;
use mesoflux_core::friction::fluctuation_dissipation::Correction;
use mesoflux_core::integrate::Schedule;
use mesoflux_core::interactions::Interactions;
use mesoflux_core::noise::{Draw, NoiseKey, Purpose};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{Vector, ZERO, add_scaled, dot, subtract};

/// A tensor of second rank.
pub type Matrix = [[f64; 3]; 3];

/// Momentum flux, its parts apart.
#[derive(Clone, Default, Debug)]
pub struct Flux {
    pub kinetic: Matrix,
    pub conservative: Matrix,
    pub dissipative: Matrix,
    pub random: Matrix,
    /// Σ Γ r² e_a² e_b².
    pub friction: Matrix,
}

/// target += factor v_a v_b
pub fn add_square(target: &mut Matrix, factor: f64, v: Vector) {
    for a in 0..3 {
        for b in 0..3 {
            target[a][b] += factor * v[a] * v[b];
        }
    }
}

/// A state without any of the engine's machinery.
#[derive(Clone)]
pub struct Naive {
    pub sides: Vector,
    pub interactions: Interactions,
    pub topology: Topology,
    /// How many bonds lie between every two particles.
    pub apart: Vec<Vec<u32>>,
    pub temperature: f64,
    /// kT of the noise in observables, none without an integrator.
    pub bath: f64,
    pub species: Vec<u8>,
    pub mass: Vec<f64>,
    pub q: Vec<Vector>,
    pub p: Vec<Vector>,
    pub step: u64,
    /// The time integral of the momentum flux since the beginning.
    pub flux: Flux,
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
            bath: system.bath_temperature(),
            species: by_id(particles, &particles.species),
            mass: by_id(particles, &particles.inverse_mass).iter().map(|w| 1.0 / w).collect(),
            q: unwrapped(system),
            p: by_id(particles, &particles.momentum),
            step: system.step,
            flux: Flux::default(),
        }
    }

    /// r and e of a pair's nearest images.
    fn separation(&self, i: usize, j: usize) -> (f64, Vector) {
        let d = subtract(self.q[i], self.q[j]);
        let d: Vector = std::array::from_fn(|k| d[k] - self.sides[k] * (d[k] / self.sides[k]).round());
        let r = dot(d, d).sqrt();
        (r, d.map(|d| d / r))
    }

    /// Γ and ∂Γ/∂u of two particles whose velocities differ by v.
    fn friction(&self, i: usize, j: usize, r: f64, e: Vector, v: Vector) -> [f64; 2] {
        if self.apart[i][j] <= u32::from(self.topology.range().friction) {
            return [0.0; 2];
        }
        let motion = Motion { distance: r, radial: dot(e, v), transverse_squared: dot(v, v) - dot(e, v).powi(2) };
        let law = self.interactions.frictions.get(self.species[i], self.species[j]);
        law.as_ref().map_or([0.0; 2], |law| [law.strength(motion), law.slope(motion)])
    }

    fn inverse_reduced_mass(&self, i: usize, j: usize) -> f64 {
        1.0 / self.mass[i] + 1.0 / self.mass[j]
    }

    /// The conservative force between two particles, positive where it repels.
    fn conservative_force(&self, i: usize, j: usize, r: f64) -> f64 {
        let law = self.interactions.potentials.get(self.species[i], self.species[j]);
        let felt = self.apart[i][j] > u32::from(self.topology.range().potential);
        let joins = |bond: &&Bond| [(i, j), (j, i)].contains(&(bond.first as usize, bond.second as usize));
        let bond = if self.apart[i][j] == 1 { self.topology.bonds().iter().find(joins) } else { None };
        law.as_ref().filter(|_| felt).map_or(0.0, |law| law.force(r))
            + bond.map_or(0.0, |bond| self.topology.laws()[usize::from(bond.law)].force(r))
    }

    /// The momentum flux of this state for the given velocities of the pairs.
    pub fn stress(&self, velocity: &[Vector]) -> Flux {
        let mut flux = Flux::default();
        for i in 0..self.q.len() {
            add_square(&mut flux.kinetic, 1.0 / self.mass[i], self.p[i]);
            for j in 0..i {
                let (r, e) = self.separation(i, j);
                let v = subtract(velocity[i], velocity[j]);
                let (force, [strength, slope]) = (self.conservative_force(i, j, r), self.friction(i, j, r, e, v));
                if force != 0.0 || strength != 0.0 {
                    let correction = self.bath * self.inverse_reduced_mass(i, j) * slope;
                    add_square(&mut flux.conservative, r * force, e);
                    add_square(&mut flux.dissipative, r * (correction - strength * dot(e, v)), e);
                    add_square(&mut flux.friction, strength * r * r, e.map(|e| e * e));
                }
            }
        }
        flux
    }

    /// Conservative forces, and for each particle the sum of their magnitudes.
    pub fn forces(&self) -> (Vec<Vector>, Vec<f64>) {
        let (mut force, mut magnitude) = (vec![ZERO; self.q.len()], vec![0.0; self.q.len()]);
        self.for_each_force(|[i, j], f, _, e| {
            for (k, sign) in [(i, 1.0), (j, -1.0)] {
                add_scaled(&mut force[k], sign * f, e);
                magnitude[k] += f.abs();
            }
        });
        (force, magnitude)
    }

    /// Calls `visit(pair, f, r, e)` for every pair, the conservative force on its first particle being f e.
    fn for_each_force(&self, mut visit: impl FnMut([usize; 2], f64, f64, Vector)) {
        for i in 0..self.q.len() {
            for j in 0..i {
                let (r, e) = self.separation(i, j);
                visit([i, j], self.conservative_force(i, j, r), r, e);
            }
        }
    }

    /// All pairs closer than any law reaches, the smaller id first.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        let all = (0..self.q.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        all.filter(|&(i, j)| self.separation(i, j).0 < self.interactions.cutoff()).collect()
    }

    pub fn drift(&mut self, t: f64) {
        for i in 0..self.q.len() {
            add_square(&mut self.flux.kinetic, t / self.mass[i], self.p[i]);
            add_scaled(&mut self.q[i], t / self.mass[i], self.p[i]);
        }
    }

    pub fn kick(&mut self, t: f64) {
        let force = self.booked_forces(t);
        for (p, f) in self.p.iter_mut().zip(force) {
            add_scaled(p, t, f);
        }
    }

    /// The conservative forces; books their r F e e over a time.
    fn booked_forces(&mut self, t: f64) -> Vec<Vector> {
        let (mut force, mut flux) = (vec![ZERO; self.q.len()], self.flux.conservative);
        self.for_each_force(|[i, j], f, r, e| {
            add_scaled(&mut force[i], f, e);
            add_scaled(&mut force[j], -f, e);
            add_square(&mut flux, t * r * f, e);
        });
        self.flux.conservative = flux;
        force
    }

    /// Eqs 27–29 for the pairs in the given order; returns Δp^D of eqs 60–61.
    pub fn thermostat(&mut self, t: f64, order: &[(usize, usize)], draw: Draw, acceptance: Draw) -> Vec<Vector> {
        let mut dissipative = vec![ZERO; self.p.len()];
        for &(i, j) in order {
            let (r, e) = self.separation(i, j);
            let reduced = self.mass[i] * self.mass[j] / (self.mass[i] + self.mass[j]);
            let v: Vector = std::array::from_fn(|k| self.p[i][k] / self.mass[i] - self.p[j][k] / self.mass[j]);
            let (u, variance) = (dot(e, v), self.temperature / reduced);
            // c − 1, S and D of the step with the friction at a radial velocity; w is what no impulse along e changes.
            let step = |radial: f64| {
                let moving = std::array::from_fn(|k| v[k] + (radial - u) * e[k]);
                let [strength, slope] = self.friction(i, j, r, e, moving);
                let x = strength / reduced * t;
                let c = (-x).exp();
                ((-x).exp_m1(), (variance * -(-2.0 * x).exp_m1()).sqrt(), variance / reduced * t * c * c * slope)
            };
            let (xi, (lost, s, d)) = (draw.pair_gaussian(i as u64, j as u64), step(u));
            let mut change = lost * u + s * xi + 0.5 * d * (1.0 + xi * xi);
            let after = u + change;
            let (lost_back, s_back, d_back) = step(u + change);
            if d != 0.0 || d_back != 0.0 {
                let q = change + lost_back * after + 0.5 * d_back;
                let root = (s_back * s_back - 2.0 * d_back * q).sqrt();
                let xi_back = -2.0 * q / (s_back + root);
                let weight = |u: f64, xi: f64| (-0.5 * (u * u / variance + xi * xi)).exp();
                let ratio = (s + d * xi) / root * weight(after, xi_back) / weight(u, xi);
                if !(s + d * xi > 0.0 && acceptance.pair_uniform(i as u64, j as u64) < ratio) {
                    change = 0.0;
                }
            }
            let dv = lost * u + d;
            let dv_random = change - dv;
            add_square(&mut self.flux.dissipative, r * reduced * dv, e);
            add_square(&mut self.flux.random, r * reduced * dv_random, e);
            for (k, sign) in [(i, 1.0), (j, -1.0)] {
                add_scaled(&mut self.p[k], sign * reduced * (dv + dv_random), e);
                add_scaled(&mut dissipative[k], sign * reduced * dv, e);
            }
        }
        dissipative
    }

    /// Groot and Warren's total force at the given velocities, with the noise of `step`; books its stress over `times` Δt.
    fn total_force(
        &mut self,
        velocity: &[Vector],
        dt: f64,
        (noise, correction): (NoiseKey, Correction),
        step: u64,
        times: f64,
    ) -> Vec<Vector> {
        let draw = noise.draw(Purpose::Pair, step, 0);
        let mut force = self.booked_forces(times * dt);
        for (i, j) in self.pairs() {
            let (r, e) = self.separation(i, j);
            let v = subtract(velocity[i], velocity[j]);
            let ([strength, slope], u) = (self.friction(i, j, r, e, v), dot(e, v));
            let (xi, w) = (draw.pair_gaussian(i as u64, j as u64), self.inverse_reduced_mass(i, j));
            let amplitude = |strength: f64| (2.0 * strength * self.temperature / dt).sqrt();
            let lambda = self.temperature * w * slope;
            let random = match correction {
                Correction::Derivative => amplitude(strength) * xi + lambda * xi * xi,
                Correction::TwoStep => {
                    let moved = std::array::from_fn(|k| v[k] + w * dt * amplitude(strength) * xi * e[k]);
                    amplitude(self.friction(i, j, r, e, moved)[0]) * xi
                }
            };
            add_square(&mut self.flux.dissipative, times * dt * r * (lambda - strength * u), e);
            add_square(&mut self.flux.random, times * dt * r * (random - lambda), e);
            add_scaled(&mut force[i], random - strength * u, e);
            add_scaled(&mut force[j], strength * u - random, e);
        }
        force
    }

    /// Steps of Naseri et al.'s eqs 4–5.
    pub fn explicit(&mut self, steps: u64, dt: f64, noise: (NoiseKey, Correction)) {
        for _ in 0..steps {
            let velocity: Vec<Vector> = self.p.iter().zip(&self.mass).map(|(p, m)| p.map(|p| p / m)).collect();
            let force = self.total_force(&velocity, dt, noise, self.step, 1.0);
            for i in 0..self.q.len() {
                add_square(&mut self.flux.kinetic, dt / self.mass[i], self.p[i]);
                add_scaled(&mut self.q[i], dt, velocity[i]);
                add_scaled(&mut self.p[i], dt, force[i]);
            }
            self.step += 1;
        }
    }

    /// Steps of Groot and Warren's eq. 17.
    pub fn velocity_verlet(&mut self, steps: u64, dt: f64, lambda: f64, noise: (NoiseKey, Correction)) {
        let over_mass =
            |p: &[Vector], mass: &[f64]| -> Vec<Vector> { p.iter().zip(mass).map(|(p, m)| p.map(|p| p / m)).collect() };
        let mut force = self.total_force(&over_mass(&self.p, &self.mass), dt, noise, self.step, 0.5);
        for step in 1..=steps {
            let mut predicted = self.p.clone();
            for i in 0..self.q.len() {
                add_scaled(&mut self.q[i], dt / self.mass[i], self.p[i]);
                add_scaled(&mut self.q[i], 0.5 * dt * dt / self.mass[i], force[i]);
                add_scaled(&mut predicted[i], lambda * dt, force[i]);
                add_scaled(&mut self.p[i], 0.5 * dt, force[i]);
                // The way of the step is Δt times the momentum between its two kicks.
                add_square(&mut self.flux.kinetic, dt / self.mass[i], self.p[i]);
            }
            self.step += 1;
            // The force of the last step has kicked only once so far.
            let times = if step == steps { 0.5 } else { 1.0 };
            force = self.total_force(&over_mass(&predicted, &self.mass), dt, noise, self.step, times);
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
                    let draw = |purpose| noise.draw(purpose, self.step, place as u64);
                    let (noise, acceptance) = (draw(Purpose::Pair), draw(Purpose::Acceptance));
                    dissipative = self.thermostat(t, &order(place, self), noise, acceptance);
                }
            }
            after(self, letter.symbol(), t, &dissipative);
        }
        self.step += 1;
    }
}
