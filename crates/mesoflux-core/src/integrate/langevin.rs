//! O: the Langevin thermostat, exact particle by particle.

use super::{Change, FluxChange, Letter, Stroke};
use crate::elementary::exp_minus_one;
use crate::lanes::{InstructionSet, Kernel, Lanes, Row, WIDTH, Words};
use crate::noise::{Draw, Purpose};
use crate::system::{SimulationError, System};
use crate::vector::dot;
use serde::{Deserialize, Serialize};

/// The drag of a bath at rest on every particle: −γ M⁻¹p, with the noise that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Langevin {
    /// γ: force over velocity.
    pub friction: f64,
}

/// dp = −γ M⁻¹p dt + √(2γkT) dW for every particle alone, solved exactly over the time t:
/// p ← e^{−γt/m} p + √(m kT (1 − e^{−2γt/m})) N(0, 1) (Blassel & Stoltz, J. Stat. Phys. 191, 17 (2024)).
///
/// It leaves the Maxwell distribution invariant whatever the time step. The total momentum decays and fluctuates: hydrodynamics
/// is screened.
#[derive(Debug, Clone, Copy)]
pub struct ParticleOrnsteinUhlenbeck {
    /// kT.
    pub temperature: f64,
    /// γ.
    pub friction: f64,
}

impl Letter for ParticleOrnsteinUhlenbeck {
    fn symbol(&self) -> char {
        'O'
    }

    fn apply(&self, system: &mut System, stroke: &Stroke) -> Result<Change, SimulationError> {
        let (particles, impulse) = (&system.particles, self.friction * stroke.time);
        let expected = stroke.response.map_or(0.0, |response| {
            system.workers.sum(particles.count(), |k| {
                let change = exp_minus_one(-impulse * particles.inverse_mass[k]);
                change * dot(response[k].vector(), particles.momentum[k])
            })
        });
        let (temperature, draw) = (self.temperature, stroke.noise.draw(Purpose::Particle, system.step, stroke.place));
        let multiplier = system.change_velocities(stroke.constraint.as_ref(), |particles, offset, velocities| {
            let (ids, inverse_masses) = (&particles.id[offset..], &particles.inverse_mass[offset..]);
            InstructionSet::detect().run(Update { temperature, impulse, draw, ids, inverse_masses, velocities });
        });
        Ok(Change { flux: FluxChange::Expected(expected), multiplier })
    }

    fn conserves_momentum(&self) -> bool {
        false
    }

    fn dissipative_flux(&self, system: &mut System, response: &[Row]) -> f64 {
        let particles = &system.particles;
        let sum = system.workers.sum(particles.count(), |k| dot(response[k].vector(), particles.velocity(k)));
        -self.friction * sum
    }
}

/// The exact update of velocities, eight at a time.
struct Update<'a> {
    temperature: f64,
    /// γt.
    impulse: f64,
    draw: Draw,
    ids: &'a [u64],
    inverse_masses: &'a [f64],
    velocities: &'a mut [Row],
}

impl Kernel for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (number, velocities) in self.velocities.chunks_mut(WIDTH).enumerate() {
            let (first, count) = (number * WIDTH, velocities.len());
            let (mut ids, mut inverse_masses) = ([0.0; WIDTH], [1.0; WIDTH]);
            for k in 0..count {
                ids[k] = f64::from_bits(self.ids[first + k]);
                inverse_masses[k] = self.inverse_masses[first + k];
            }
            let (ids, inverse_mass) = (L::load(&ids).to_bits(), L::load(&inverse_masses));
            let exponent = L::splat(-self.impulse) * inverse_mass;
            let change = exp_minus_one(exponent);
            let lost = -exp_minus_one(exponent + exponent);
            let deviation = (L::splat(self.temperature) * inverse_mass * lost).sqrt();
            for axis in 0..3 {
                let mut component = [0.0; WIDTH];
                for k in 0..count {
                    component[k] = velocities[k].0[axis];
                }
                let velocity = L::load(&component);
                let normal: L = self.draw.normal(ids, L::Bits::splat(axis as u64));
                deviation.mul_add(normal, velocity.mul_add(change, velocity)).store(&mut component);
                for k in 0..count {
                    velocities[k].0[axis] = component[k];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseKey;

    /// The naive update of every particle by itself, to the bit, for numbers of particles that fill no block.
    #[test]
    fn every_instruction_set_gives_the_bits_of_the_equation() {
        let (temperature, impulse) = (0.7, 0.3);
        let draw = NoiseKey::new(&[4]).draw(Purpose::Particle, 17, 2);
        for count in [1, 8, 29] {
            let ids: Vec<u64> = (0..count).map(|k| 1_000_003 * k % 977).collect();
            let inverse_masses: Vec<f64> = (0..count).map(|k| 1.0 / (1.0 + (k % 3) as f64)).collect();
            let start: Vec<Row> =
                (0..count).map(|k| Row::new([k as f64, -0.1, 0.3 * k as f64].map(f64::sin), 0.0)).collect();
            let mut expected = start.clone();
            for (k, row) in expected.iter_mut().enumerate() {
                let exponent = -impulse * inverse_masses[k];
                let variance = temperature * inverse_masses[k] * -exp_minus_one(2.0 * exponent);
                for axis in 0..3 {
                    let (velocity, normal) = (row.0[axis], draw.gaussian(ids[k], axis as u64));
                    let decayed = velocity.mul_add(exp_minus_one(exponent), velocity);
                    row.0[axis] = variance.sqrt().mul_add(normal, decayed);
                }
            }
            for set in InstructionSet::available() {
                let mut velocities = start.clone();
                set.run(Update {
                    temperature,
                    impulse,
                    draw,
                    ids: &ids,
                    inverse_masses: &inverse_masses,
                    velocities: &mut velocities,
                });
                assert_eq!(velocities, expected, "{set:?}, {count} particles");
            }
        }
    }
}
