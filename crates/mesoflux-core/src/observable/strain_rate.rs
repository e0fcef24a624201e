//! The velocity gradient around every particle, from its neighbors: the local rate of strain, its mean, its profile.

use crate::boundary::PeriodicBox;
use crate::elementary::power;
use crate::state::Particles;
use crate::system::System;
use crate::tensor::{AXES, SymmetricTensor};
use crate::vector::{Vector, dot, subtract};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::ops::AddAssign;
use std::sync::{Mutex, PoisonError};

/// G_ab = ∂_a v_b: row a is the direction of the derivative, column b the component of the velocity.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VelocityGradient(pub [Vector; 3]);

impl VelocityGradient {
    /// D_ab = ½(∂_a v_b + ∂_b v_a), the rate of strain.
    pub fn symmetric(&self) -> SymmetricTensor {
        SymmetricTensor(AXES.map(|[a, b]| 0.5 * (self.0[a][b] + self.0[b][a])))
    }

    /// ∇ × v, twice the angular velocity: the antisymmetric part.
    pub fn vorticity(&self) -> Vector {
        let [[_, xy, xz], [yx, _, yz], [zx, zy, _]] = self.0;
        [yz - zy, zx - xz, xy - yx]
    }

    /// ∇ · v.
    pub fn divergence(&self) -> f64 {
        self.symmetric().trace()
    }

    /// γ̇ = √(2 D':D') with D' the traceless part of D: the invariant that is |∂_y v_x| in a shear flow v_x(y).
    ///
    /// It never averages to zero: thermal motion alone gives each particle one (`book/src/strain-rate.md`).
    pub fn shear_rate(&self) -> f64 {
        let squares: f64 = self.symmetric().shear().into_iter().map(|component| component * component).sum();
        2.0 * squares.sqrt()
    }
}

impl AddAssign for VelocityGradient {
    fn add_assign(&mut self, other: Self) {
        for (sum, term) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *sum += term;
        }
    }
}

/// By what the first moment of the neighbors' momenta is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Normalization {
    /// By what their masses would have as second moment, were they spread evenly in all directions and distances: the paper's form,
    /// G_i = Σ_j r (p_j − m_j v_i) ω/(C Σ_j m_j ω) with 3C = ∫ω r² dV/∫ω dV.
    ///
    /// The mean is right where neighbors lie anywhere alike (g(r) = 1) and ω is the step function; with another ω it is off by a
    /// term that falls with the number of neighbors.
    Isotropic,
    /// By the second moment that they have, M_i = Σ_j m_j r r ω: G_i = M_i⁻¹ Σ_j r (p_j − m_j v_i) ω.
    ///
    /// A uniform gradient is found exactly by every particle, whatever its neighbors, their masses and ω; they must not all lie in
    /// one plane with it.
    #[default]
    Local,
}

/// An estimator that can't be had.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StrainRateError {
    /// Not a usable parameter.
    #[error("the {name} of the local strain rate is {value}: must be {requirement}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// Some neighbors are not known.
    #[error(
        "the cutoff of the local strain rate is {cutoff}: must be at most {longest}, the largest cutoff of any pair law, because \
         only neighbors within that are known"
    )]
    CutoffTooLong {
        /// The estimator's.
        cutoff: f64,
        /// The list's.
        longest: f64,
    },
}

/// The local velocity gradient from the neighbors of each particle, weighted by ω(r) = (1 − r/r_c)^s (Naseri et al., eqs 19–26).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainRate {
    cutoff: f64,
    exponent: f64,
    normalization: Normalization,
}

/// A relative second moment's determinant below which neighbors count as lying in one plane.
const FLAT: f64 = 1e-9;

thread_local! {
    /// One more than where a brick's sums hold that of the particle in each place; zero where they don't.
    static NUMBERS: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

impl StrainRate {
    /// An estimator with a cutoff r_c and an exponent s; s = 0 is the paper's step function θ(r_c − r).
    ///
    /// # Errors
    /// A cutoff that isn't positive, an exponent that is negative.
    pub fn new(cutoff: f64, exponent: f64, normalization: Normalization) -> Result<Self, StrainRateError> {
        let refused = |name, value, requirement| Err(StrainRateError::Parameter { name, value, requirement });
        if !(cutoff > 0.0 && cutoff.is_finite()) {
            return refused("cutoff", cutoff, "positive and finite");
        }
        if !(exponent >= 0.0 && exponent.is_finite()) {
            return refused("exponent", exponent, "at least 0 and finite");
        }
        Ok(Self { cutoff, exponent, normalization })
    }

    /// C = ∫ω r² dV/(3∫ω dV) = 4 r_c²/((s + 4)(s + 5)), by ∫₀¹ xⁿ(1 − x)^s dx = n! s!/(n + s + 1)!.
    pub fn constant(&self) -> f64 {
        4.0 * self.cutoff * self.cutoff / ((self.exponent + 4.0) * (self.exponent + 5.0))
    }

    /// Reads a system at its present positions and momenta; the same bits for any number of threads.
    ///
    /// # Errors
    /// A cutoff beyond that of all pair laws.
    pub fn of(&self, system: &mut System) -> Result<LocalGradients, StrainRateError> {
        let longest = system.interactions.cutoff();
        if self.cutoff > longest {
            return Err(StrainRateError::CutoffTooLong { cutoff: self.cutoff, longest });
        }
        let moments = self.moments(system);
        Ok(LocalGradients(moments.iter().map(|moments| self.gradient(moments)).collect()))
    }

    /// ω(r).
    fn weight(&self, r: f64) -> f64 {
        if self.exponent == 0.0 { 1.0 } else { power(1.0 - r / self.cutoff, self.exponent) }
    }

    /// The sums over the neighbors of every particle, in storage order.
    fn moments(&self, system: &mut System) -> Vec<Moments> {
        let workers = system.workers;
        let (list, _, particles) = system.with_contacts();
        let (particles, region) = (&*particles, list.region());
        let total = Mutex::new(vec![Moments::default(); particles.count()]);
        list.sweep(false, workers, |contacts| {
            NUMBERS.with_borrow_mut(|numbers| {
                numbers.resize(particles.count().max(numbers.len()), 0);
                let mut sums: Vec<(usize, Moments)> = Vec::new();
                for k in 0..contacts.count() {
                    let [i, j] = contacts.pair(k);
                    let d = region.nearest_image(subtract(particles.position[j], particles.position[i]));
                    let r = dot(d, d).sqrt();
                    if r < self.cutoff {
                        let velocity = subtract(particles.velocity(j), particles.velocity(i));
                        // Even in the exchange of i and j: what j adds to i is what i adds to j but for the mass.
                        let pair = Moments::of(self.weight(r), d, velocity);
                        for (place, other) in [(i, j), (j, i)] {
                            if numbers[place] == 0 {
                                sums.push((place, Moments::default()));
                                numbers[place] = sums.len() as u32;
                            }
                            sums[numbers[place] as usize - 1].1.add(1.0 / particles.inverse_mass[other], &pair);
                        }
                    }
                }
                // Bricks of one color share no particle and colors come one after the other: each particle's terms come in one order.
                let mut total = total.lock().unwrap_or_else(PoisonError::into_inner);
                for (place, sum) in sums {
                    total[place].add(1.0, &sum);
                    numbers[place] = 0;
                }
            });
        });
        total.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// The gradient from a particle's sums, if they tell it.
    fn gradient(&self, Moments { flow, second, mass }: &Moments) -> Option<VelocityGradient> {
        match self.normalization {
            Normalization::Isotropic => {
                let divisor = self.constant() * mass;
                (*mass > 0.0).then(|| VelocityGradient(flow.map(|row| row.map(|entry| entry / divisor))))
            }
            Normalization::Local => {
                let inverse = inverse(second)?;
                let entry = |a, b| (0..3).map(|c| inverse.component(a, c) * flow[c][b]).sum();
                Some(VelocityGradient([0, 1, 2].map(|a| [0, 1, 2].map(|b| entry(a, b)))))
            }
        }
    }
}

/// Sums over a particle's neighbors, with r from the particle to its neighbor and v the neighbor's velocity relative to it.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    /// Σ m r_a v_b ω.
    flow: [Vector; 3],
    /// Σ m r_a r_b ω.
    second: SymmetricTensor,
    /// Σ m ω.
    mass: f64,
}

impl Moments {
    /// Those of one neighbor of mass one.
    fn of(weight: f64, d: Vector, velocity: Vector) -> Self {
        let flow = d.map(|d| velocity.map(|v| weight * d * v));
        Self { flow, second: weight * SymmetricTensor::square(d), mass: weight }
    }

    fn add(&mut self, factor: f64, other: &Self) {
        for (sum, term) in self.flow.as_flattened_mut().iter_mut().zip(other.flow.as_flattened()) {
            *sum += factor * term;
        }
        self.second += factor * other.second;
        self.mass += factor * other.mass;
    }
}

/// The inverse of a positive definite tensor by its cofactors; none where it is flat.
fn inverse(tensor: &SymmetricTensor) -> Option<SymmetricTensor> {
    let [xx, yy, zz, xy, xz, yz] = tensor.0;
    let cofactors = SymmetricTensor([
        yy * zz - yz * yz,
        xx * zz - xz * xz,
        xx * yy - xy * xy,
        xz * yz - xy * zz,
        xy * yz - xz * yy,
        xy * xz - yz * xx,
    ]);
    let determinant = xx * cofactors.0[0] + xy * cofactors.0[3] + xz * cofactors.0[4];
    let mean = tensor.trace() / 3.0;
    (determinant > FLAT * mean * mean * mean).then(|| (1.0 / determinant) * cofactors)
}

/// The gradients of all particles in storage order; none where the neighbors are too few to tell.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalGradients(pub Vec<Option<VelocityGradient>>);

impl LocalGradients {
    /// The sum over all particles.
    pub fn sum(&self) -> GradientSum {
        let mut sum = GradientSum::default();
        self.0.iter().flatten().for_each(|gradient| sum.record(gradient));
        sum
    }

    /// The sums over the particles in layers of equal thickness across the box, as the particles are placed now: the field.
    ///
    /// # Panics
    /// No layer, or an axis beyond 2.
    pub fn profile(&self, particles: &Particles, region: &PeriodicBox, axis: usize, count: usize) -> Vec<GradientSum> {
        assert!(axis < 3 && count > 0, "a profile needs an axis below 3 and at least one layer");
        let side = region.sides()[axis];
        let mut layers = vec![GradientSum::default(); count];
        for (position, gradient) in particles.position.iter().zip(&self.0) {
            if let Some(gradient) = gradient {
                let layer = ((position[axis] / side).rem_euclid(1.0) * count as f64) as usize;
                layers[layer.min(count - 1)].record(gradient);
            }
        }
        layers
    }
}

/// A sum of local gradients over particles, or over samples too.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GradientSum {
    /// How many there are in the sum.
    pub count: u64,
    /// Their sum.
    pub gradient: VelocityGradient,
}

impl GradientSum {
    /// Adds one.
    pub fn record(&mut self, gradient: &VelocityGradient) {
        self.count += 1;
        self.gradient += *gradient;
    }

    /// The mean of all, if there are any.
    pub fn mean(&self) -> Option<VelocityGradient> {
        let count = self.count as f64;
        (self.count > 0).then(|| VelocityGradient(self.gradient.0.map(|row| row.map(|entry| entry / count))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ω r⁴ dr/(3∫ω r² dr) by the midpoint rule.
    #[test]
    fn the_constant_is_the_ratio_of_the_weights_moments() {
        for (cutoff, exponent) in [(1.0, 0.0), (1.5, 0.0), (1.0, 0.5), (2.0, 1.0), (1.2, 2.0), (0.7, 3.5)] {
            let estimator = StrainRate::new(cutoff, exponent, Normalization::Isotropic).unwrap();
            let points = 200_000;
            let moment = |power: i32| -> f64 {
                (0..points)
                    .map(|k| cutoff * (f64::from(k) + 0.5) / f64::from(points))
                    .map(|r| estimator.weight(r) * r.powi(power))
                    .sum()
            };
            let expected = moment(4) / (3.0 * moment(2));
            assert!((estimator.constant() / expected - 1.0).abs() < 1e-7, "s = {exponent}");
        }
        let step = StrainRate::new(1.5, 0.0, Normalization::Isotropic).unwrap();
        assert!((step.constant() - 1.5 * 1.5 / 5.0).abs() < 1e-15);
    }

    #[test]
    fn invariants_of_simple_flows() {
        // v_x = 3y: only ∂_y v_x.
        let shear = VelocityGradient([[0.0; 3], [3.0, 0.0, 0.0], [0.0; 3]]);
        assert_eq!(shear.symmetric().component(0, 1), 1.5);
        assert_eq!((shear.divergence(), shear.vorticity()), (0.0, [0.0, 0.0, -3.0]));
        assert!((shear.shear_rate() - 3.0).abs() < 1e-15);
        // v = (0, 0, 2) × r = (−2y, 2x, 0).
        let rotation = VelocityGradient([[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0; 3]]);
        assert_eq!((rotation.shear_rate(), rotation.vorticity()), (0.0, [0.0, 0.0, 4.0]));
        // v = r expands without shear.
        let expansion = VelocityGradient([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!((expansion.divergence(), expansion.shear_rate()), (3.0, 0.0));
    }

    #[test]
    fn the_inverse_is_one_and_flat_tensors_have_none() {
        let vectors = [[1.0, 0.2, -0.3], [0.1, 0.7, 0.4], [-0.5, 0.3, 0.9]];
        let mut tensor = SymmetricTensor::default();
        vectors.into_iter().take(2).for_each(|v| tensor += SymmetricTensor::square(v));
        assert_eq!(inverse(&tensor), None, "two vectors lie in a plane");
        tensor += SymmetricTensor::square(vectors[2]);
        let inverse = inverse(&tensor).unwrap();
        for a in 0..3 {
            for b in 0..3 {
                let product: f64 = (0..3).map(|c| inverse.component(a, c) * tensor.component(c, b)).sum();
                assert!((product - f64::from(a == b)).abs() < 1e-13);
            }
        }
    }
}
