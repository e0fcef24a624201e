//! The stress of pairs, its conservative, dissipative and random parts apart.

use super::contacts::Contacts;
use super::dissipation::{Dissipation, PairNoise};
use super::separations::Separations;
use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, InstructionSet, Kernel, Lanes, Row};
use crate::neighbors::NeighborList;
use crate::tensor::SymmetricTensor;
use serde::{Deserialize, Serialize};
use std::ops::Add;

/// Sums over all pairs of r F e_a e_b for the parts of the force F e on the first particle; extensive, not divided by V.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PairStress {
    /// Σ r f(r) e_a e_b.
    pub conservative: SymmetricTensor,
    /// Σ r (−Γ u + Λ) e_a e_b with u = e·v_ij: what friction and the mean of the noise give (Λ = kT (1/m_i + 1/m_j) ∂Γ/∂u).
    pub dissipative: SymmetricTensor,
    /// Σ r (F^R − Λ) e_a e_b with the random force F^R, where there is noise.
    pub random: SymmetricTensor,
    /// Σ Γ r² e_a² e_b².
    pub friction: SymmetricTensor,
}

impl Add for PairStress {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            conservative: self.conservative + other.conservative,
            dissipative: self.dissipative + other.dissipative,
            random: self.random + other.random,
            friction: self.friction + other.friction,
        }
    }
}

/// The stress of the pairs at the positions of the contacts.
///
/// Without velocities (in storage order) the conservative part alone; with them, the dissipative part too, and with noise the
/// random force of one step. The same bits for any number of threads.
pub fn pair_stress(
    list: &NeighborList,
    interactions: &Interactions,
    velocity: Option<&[Row]>,
    temperature: f64,
    noise: Option<&PairNoise>,
    workers: Workers,
) -> PairStress {
    let (region, points) = (list.region(), list.points());
    let instructions = InstructionSet::detect();
    let parts = list.sweep(false, workers, |contacts| {
        instructions.run(BrickStress { contacts, interactions, points, region, velocity, temperature, noise })
    });
    parts.into_iter().fold(PairStress::default(), PairStress::add)
}

/// The pairs of one brick.
struct BrickStress<'a> {
    contacts: &'a Contacts,
    interactions: &'a Interactions,
    points: &'a [Row],
    region: &'a PeriodicBox,
    velocity: Option<&'a [Row]>,
    temperature: f64,
    noise: Option<&'a PairNoise>,
}

/// A sum of symmetric tensors, eight at a time.
#[derive(Clone, Copy)]
pub(super) struct TensorLanes<L>([L; 6]);

impl<L: Lanes> TensorLanes<L> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self([L::splat(0.0); 6])
    }

    /// v_a v_b
    #[inline(always)]
    pub fn square([x, y, z]: [L; 3]) -> Self {
        Self([x * x, y * y, z * z, x * y, x * z, y * z])
    }

    /// self += factor · tensor
    #[inline(always)]
    pub fn add_scaled(&mut self, factor: L, tensor: &Self) {
        for k in 0..6 {
            self.0[k] = factor.mul_add(tensor.0[k], self.0[k]);
        }
    }

    #[inline(always)]
    pub fn sum(&self) -> SymmetricTensor {
        let mut sums = [0.0; 6];
        for k in 0..6 {
            sums[k] = self.0[k].sum();
        }
        SymmetricTensor(sums)
    }
}

impl Kernel for BrickStress<'_> {
    type Output = PairStress;

    #[inline(always)]
    fn run<L: Lanes>(self) -> PairStress {
        match (self.velocity, self.noise) {
            (None, _) => self.sums::<L, false, false>(&[]),
            (Some(velocity), None) => self.sums::<L, true, false>(velocity),
            (Some(velocity), Some(_)) => self.sums::<L, true, true>(velocity),
        }
    }
}

impl BrickStress<'_> {
    /// The sums, with or without the parts that need velocities or noise.
    #[inline(always)]
    fn sums<L: Lanes, const MOVING: bool, const RANDOM: bool>(&self, velocity: &[Row]) -> PairStress {
        let Self { contacts, interactions, points, region, temperature, noise, .. } = self;
        let (mut pairs, mut dissipation) = (Separations::default(), Dissipation::new(interactions));
        let (mut force, mut conservative) = (BlockNumbers::default(), TensorLanes::<L>::zero());
        let (mut dissipative, mut random, mut friction) = (conservative, conservative, conservative);
        for block in contacts.blocks(false) {
            pairs.update::<L>(contacts, &block, points, region);
            contacts.by_kind::<L, _>(&block, &interactions.potentials, &pairs.distance, &mut force);
            if MOVING {
                dissipation.update::<L>(contacts, &block, interactions, &pairs, velocity);
            }
            if let (true, Some(noise)) = (RANDOM, noise) {
                dissipation.draw::<L>(&block, interactions, &pairs, noise);
            }
            for s in 0..block.streams {
                // What stands behind the last contact of a stream belongs to another.
                force[s][block.depth..].fill(0.0);
                let (r, e) = (L::load(&pairs.distance[s]), pairs.direction(s));
                let direction = TensorLanes::square(e);
                conservative.add_scaled(r * L::load(&force[s]), &direction);
                if MOVING {
                    dissipation.forget_beyond(s, block.depth);
                    let arm = r * L::load(&dissipation.strength[s]);
                    let correction = dissipation.correction::<L>(interactions, *temperature, s);
                    dissipative.add_scaled(r.mul_add(correction, -(arm * dissipation.radial(s))), &direction);
                    let [xx, yy, zz, ..] = direction.0;
                    friction.add_scaled(arm * r, &TensorLanes::square([xx, yy, zz]));
                    if RANDOM {
                        random.add_scaled(r * (L::load(&dissipation.random[s]) - correction), &direction);
                    }
                }
            }
        }
        PairStress {
            conservative: conservative.sum(),
            dissipative: dissipative.sum(),
            random: random.sum(),
            friction: friction.sum(),
        }
    }
}
