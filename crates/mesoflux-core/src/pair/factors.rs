//! What velocities make of the frictions of a block's pairs, each by its kind.

use super::contacts::{Block, Contacts};
use crate::friction::{Factor, Factors, Friction, Motions};
use crate::interactions::{Kind, PairTable};
use crate::lanes::{BlockOf, InstructionSet, Kernel, Lanes};

/// The kind of each pair of a block.
#[derive(Debug, Clone, Default)]
pub(super) struct Kinds(pub BlockOf<Kind>);

impl Kinds {
    /// Takes them over; all are zero where there is but one.
    #[inline(always)]
    pub fn update(&mut self, contacts: &Contacts, block: &Block) {
        for s in 0..block.streams {
            if let Some(kinds) = contacts.kinds(block.stream(s)) {
                self.0[s] = *kinds;
            }
        }
    }
}

/// The factors of so many rows of pairs, whose kinds are those of a block's rows from one on.
#[inline(always)]
pub(super) fn fill_factors<L: Lanes>(
    frictions: &PairTable<Option<Friction>>,
    kinds: &Kinds,
    from: usize,
    rows: usize,
    motions: &Motions,
    factors: &mut Factors,
) {
    if let [Some(law)] = frictions.entries() {
        law.fill_factors::<L>(rows, motions, factors);
        return;
    }
    let mut of_law = Factors::default();
    for (kind, law) in frictions.entries().iter().enumerate() {
        if let Some(law) = law {
            law.fill_factors::<L>(rows, motions, &mut of_law);
            for row in 0..rows {
                let chosen = L::of_kind(&kinds.0[from + row], kind as Kind);
                let value = L::select(chosen, L::load(&of_law.value[row]), L::load(&factors.value[row]));
                let slope = L::select(chosen, L::load(&of_law.slope[row]), L::load(&factors.slope[row]));
                value.store(&mut factors.value[row]);
                slope.store(&mut factors.slope[row]);
            }
        }
    }
}

/// The same as a call and not a part of the caller: one copy of all laws for each set of instructions is enough.
pub(super) struct FillFactors<'a> {
    pub frictions: &'a PairTable<Option<Friction>>,
    pub kinds: &'a Kinds,
    pub rows: usize,
    pub motions: &'a Motions,
    pub factors: &'a mut Factors,
}

impl FillFactors<'_> {
    #[inline(never)]
    pub fn call(self) {
        InstructionSet::detect().run(self);
    }
}

impl Kernel for FillFactors<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        fill_factors::<L>(self.frictions, self.kinds, 0, self.rows, self.motions, self.factors);
    }
}

/// A number that belongs to the kind of each of eight pairs.
#[inline(always)]
pub(super) fn by_kind<L: Lanes>(table: &PairTable<f64>, kinds: &Kinds, row: usize) -> L {
    let mut chosen = L::splat(table.entries()[0]);
    for (kind, &number) in table.entries().iter().enumerate().skip(1) {
        chosen = L::select(L::of_kind(&kinds.0[row], kind as Kind), L::splat(number), chosen);
    }
    chosen
}

/// Γ and ∂Γ/∂u: amplitude times factor, zero where there is no friction, whatever the factor is there.
#[inline(always)]
pub(super) fn friction<L: Lanes>(amplitude: L, factor: Factor<L>) -> [L; 2] {
    let zero = L::splat(0.0);
    let felt = zero.below(amplitude);
    [L::select(felt, amplitude * factor.value, zero), L::select(felt, amplitude * factor.slope, zero)]
}
