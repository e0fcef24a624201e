//! Friction and random force of a block's pairs at given velocities: what explicit schemes and the stress need.

use super::contacts::{Block, Contacts};
use super::factors::{FillFactors, Kinds, by_kind, friction};
use super::separations::Separations;
use crate::friction::fluctuation_dissipation::{Correction, correction, predicted, random_force};
use crate::friction::{Dependence, Factors, Motions};
use crate::interactions::Interactions;
use crate::lanes::{BlockNumbers, Lanes, Row, inner_product};
use crate::noise::Draw;

/// The noise of one force evaluation.
#[derive(Debug, Clone, Copy)]
pub struct PairNoise {
    /// kT.
    pub temperature: f64,
    /// Δt, over which the random force is constant.
    pub time_step: f64,
    /// The random numbers.
    pub draw: Draw,
    /// How the noise's own effect on the friction is taken into account.
    pub correction: Correction,
}

/// Γ, u, Λ and the random force of a block's pairs.
#[derive(Debug)]
pub(super) struct Dissipation {
    /// Whether a friction depends on velocities.
    factored: bool,
    kinds: Kinds,
    motions: Motions,
    factors: Factors,
    amplitude: BlockNumbers,
    normals: BlockNumbers,
    /// Γ.
    pub strength: BlockNumbers,
    /// ∂Γ/∂u.
    slope: BlockNumbers,
    /// √(2ΓkT/Δt) ξ + Λξ², or what two steps give.
    pub random: BlockNumbers,
}

impl Dissipation {
    /// Room for a block.
    #[inline(always)]
    pub fn new(interactions: &Interactions) -> Self {
        Self {
            factored: interactions.friction_dependence() != Dependence::Distance,
            kinds: Kinds::default(),
            motions: Motions::default(),
            factors: Factors::default(),
            amplitude: BlockNumbers::default(),
            normals: BlockNumbers::default(),
            strength: BlockNumbers::default(),
            slope: BlockNumbers::default(),
            random: BlockNumbers::default(),
        }
    }

    /// u of one stream's pairs.
    #[inline(always)]
    pub fn radial<L: Lanes>(&self, stream: usize) -> L {
        L::load(&self.motions.radial[stream])
    }

    /// Nothing for what stands behind the last contact of a stream: it belongs to another.
    #[inline(always)]
    pub fn forget_beyond(&mut self, stream: usize, depth: usize) {
        self.strength[stream][depth..].fill(0.0);
        self.slope[stream][depth..].fill(0.0);
        self.random[stream][depth..].fill(0.0);
    }

    /// Λ of one stream's pairs.
    #[inline(always)]
    pub fn correction<L: Lanes>(&self, interactions: &Interactions, temperature: f64, stream: usize) -> L {
        let inverse_reduced_mass = by_kind::<L>(&interactions.inverse_reduced_masses, &self.kinds, stream);
        correction(L::load(&self.slope[stream]), inverse_reduced_mass, temperature)
    }

    /// Takes over the velocities, in storage order.
    #[inline(always)]
    pub fn update<L: Lanes>(
        &mut self,
        contacts: &Contacts,
        block: &Block,
        interactions: &Interactions,
        pairs: &Separations,
        velocity: &[Row],
    ) {
        assert!(contacts.places_below() <= velocity.len(), "contacts of other particles");
        contacts.by_kind::<L, _>(block, &interactions.frictions, &pairs.distance, &mut self.amplitude);
        for s in 0..block.streams {
            let [first, second] = contacts.places(block.stream(s));
            // SAFETY: all places of the contacts are below the number of velocities.
            let (v_i, v_j) =
                unsafe { (L::load_rows(velocity.as_ptr(), first), L::load_rows(velocity.as_ptr(), second)) };
            let v = [v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]];
            let u = inner_product(pairs.direction(s), v);
            u.store(&mut self.motions.radial[s]);
            if self.factored {
                let squared = (-u).mul_add(u, inner_product(v, v));
                let zero = L::splat(0.0);
                L::select(zero.below(squared), squared, zero).store(&mut self.motions.transverse_squared[s]);
                self.motions.distance[s] = pairs.distance[s];
            }
        }
        if self.factored {
            self.kinds.update(contacts, block);
            self.set_friction::<L>(block, interactions);
        } else {
            self.strength = self.amplitude;
        }
    }

    /// Γ and ∂Γ/∂u at the present motions.
    #[inline(always)]
    fn set_friction<L: Lanes>(&mut self, block: &Block, interactions: &Interactions) {
        let Self { kinds, motions, factors, .. } = self;
        FillFactors { frictions: &interactions.frictions, kinds, rows: block.streams, motions, factors }.call();
        for s in 0..block.streams {
            let [strength, slope] = friction(L::load(&self.amplitude[s]), self.factors.row(s));
            strength.store(&mut self.strength[s]);
            slope.store(&mut self.slope[s]);
        }
    }

    /// Draws the random forces, after the velocities have been taken over.
    #[inline(always)]
    pub fn draw<L: Lanes>(
        &mut self,
        block: &Block,
        interactions: &Interactions,
        pairs: &Separations,
        noise: &PairNoise,
    ) {
        noise.draw.pair_normals::<L>(block.streams, &pairs.ids, &mut self.normals);
        for s in 0..block.streams {
            let normal = L::load(&self.normals[s]);
            let force = random_force(L::load(&self.strength[s]), noise.temperature, noise.time_step) * normal;
            let corrected = if self.factored && noise.correction == Correction::Derivative {
                self.correction::<L>(interactions, noise.temperature, s).mul_add(normal * normal, force)
            } else {
                force
            };
            corrected.store(&mut self.random[s]);
        }
        if self.factored && noise.correction == Correction::TwoStep {
            let (radial, strength, slope) = (self.motions.radial, self.strength, self.slope);
            for s in 0..block.streams {
                let inverse_reduced_mass = by_kind::<L>(&interactions.inverse_reduced_masses, &self.kinds, s);
                let force = L::load(&self.random[s]);
                predicted(L::load(&radial[s]), force, inverse_reduced_mass, noise.time_step)
                    .store(&mut self.motions.radial[s]);
            }
            self.set_friction::<L>(block, interactions);
            for s in 0..block.streams {
                let amplitude = random_force(L::load(&self.strength[s]), noise.temperature, noise.time_step);
                (amplitude * L::load(&self.normals[s])).store(&mut self.random[s]);
            }
            (self.motions.radial, self.strength, self.slope) = (radial, strength, slope);
        }
    }
}
