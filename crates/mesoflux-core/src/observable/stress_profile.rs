//! The local stress across the box: in bins along one axis, its parts apart.

use super::Stress;
use crate::domain::Workers;
use crate::friction::Motion;
use crate::friction::fluctuation_dissipation::correction;
use crate::system::System;
use crate::tensor::SymmetricTensor;
use crate::vector::{dot, subtract};

/// The stress in layers of equal thickness across the box (Wu & Shang, eq. 81b, averaged over each layer).
///
/// A particle carries its kinetic part in the layer where it is; a pair carries its part along the straight line between the two
/// (Irving and Kirkwood), each layer getting the share of the line that lies in it. The entries are extensive: divided by the
/// volume of a layer they are the local stress, and their sum is `Stress::of` the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct StressProfile {
    /// The axis across the layers, 0 to 2 for x to z.
    pub axis: usize,
    /// The layers from 0 on.
    pub layers: Vec<Stress>,
}

/// Layers along a periodic axis.
#[derive(Debug, Clone, Copy)]
struct Layers {
    axis: usize,
    count: usize,
    thickness: f64,
}

impl Layers {
    /// Calls `visit(layer, share)` for the layers that a line from `start` by `way` along the axis crosses; the shares sum to one.
    fn crossed(&self, start: f64, way: f64, mut visit: impl FnMut(usize, f64)) {
        let (a, b) = (start / self.thickness, (start + way) / self.thickness);
        let (low, high) = (a.min(b), a.max(b));
        let layer = |cell: f64| (cell.rem_euclid(self.count as f64) as usize).min(self.count - 1);
        if low.floor() == high.floor() {
            visit(layer(low.floor()), 1.0);
            return;
        }
        let mut cell = low.floor();
        while cell < high {
            let inside = high.min(cell + 1.0) - low.max(cell);
            visit(layer(cell), inside / (high - low));
            cell += 1.0;
        }
    }
}

impl StressProfile {
    /// Reads a system at its present positions and momenta.
    ///
    /// # Panics
    /// No layer, or an axis beyond 2.
    pub fn of(system: &mut System, axis: usize, count: usize) -> Self {
        assert!(axis < 3 && count > 0, "a profile needs an axis below 3 and at least one layer");
        let thickness = system.region.sides()[axis] / count as f64;
        let layers = Layers { axis, count, thickness };
        let workers = system.workers;
        let mut profile = pairs(system, layers, workers);
        let particles = &system.particles;
        for k in 0..particles.count() {
            layers.crossed(particles.position[k][axis], 0.0, |layer, _| {
                let square = SymmetricTensor::square(particles.momentum[k]);
                profile[layer].kinetic += particles.inverse_mass[k] * square;
            });
        }
        system.topology().for_each_bond(particles, &system.region, |bond, [first, _], d| {
            let r = dot(d, d).sqrt();
            if r > 0.0 {
                let force = system.topology().laws()[usize::from(bond.law)].force(r);
                let stress = (force / r) * SymmetricTensor::square(d);
                layers.crossed(particles.position[first][axis], -d[axis], |layer, share| {
                    profile[layer].conservative += share * stress;
                });
            }
        });
        Self { axis, layers: profile }
    }
}

/// What the pairs contribute; the same bits for any number of threads.
fn pairs(system: &mut System, layers: Layers, workers: Workers) -> Vec<Stress> {
    let temperature = system.bath_temperature();
    let (list, interactions, particles) = system.with_contacts();
    let (potentials, frictions) = (interactions.potentials.entries(), interactions.frictions.entries());
    let particles = &*particles;
    let bricks = list.sweep(false, workers, |contacts| {
        let mut profile = vec![Stress::default(); layers.count];
        for k in 0..contacts.count() {
            let ([i, j], kind) = (contacts.pair(k), contacts.kind(k));
            let (r, e) = contacts.separation(k, &particles.position, list.region());
            let force = potentials[kind].as_ref().map_or(0.0, |law| law.force(r));
            let motion = Motion::new(r, e, subtract(particles.velocity(i), particles.velocity(j)));
            let [strength, slope] =
                frictions[kind].as_ref().map_or([0.0; 2], |law| [law.strength(motion), law.slope(motion)]);
            if force != 0.0 || strength != 0.0 {
                let inverse_reduced_mass = particles.inverse_mass[i] + particles.inverse_mass[j];
                let dissipative = correction(slope, inverse_reduced_mass, temperature) - strength * motion.radial;
                let direction = SymmetricTensor::square(e);
                let friction = (strength * r * r) * SymmetricTensor::square(e.map(|e| e * e));
                let axis = layers.axis;
                layers.crossed(particles.position[i][axis], -r * e[axis], |layer, share| {
                    let target = &mut profile[layer];
                    target.conservative += (share * r * force) * direction;
                    target.dissipative += (share * r * dissipative) * direction;
                    target.friction += share * friction;
                });
            }
        }
        profile
    });
    let mut profile = vec![Stress::default(); layers.count];
    for brick in bricks {
        for (sum, part) in profile.iter_mut().zip(brick) {
            sum.conservative += part.conservative;
            sum.dissipative += part.dissipative;
            sum.friction += part.friction;
        }
    }
    profile
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_shared_by_the_layers_that_it_crosses() {
        let layers = Layers { axis: 1, count: 4, thickness: 0.5 };
        let shares = |start: f64, way: f64| {
            let mut shares = [0.0; 4];
            layers.crossed(start, way, |layer, share| shares[layer] += share);
            shares
        };
        assert_eq!(shares(0.1, 0.0), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(shares(0.25, 1.0), [0.25, 0.5, 0.25, 0.0]);
        assert_eq!(shares(0.25, -0.5), [0.5, 0.0, 0.0, 0.5]);
        assert_eq!(shares(1.75, 0.5), [0.5, 0.0, 0.0, 0.5]);
        assert_eq!(shares(-0.25, 0.0), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(shares(2.0, 0.0), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(shares(-1e-18, 0.0).iter().sum::<f64>(), 1.0);
    }
}
