//! Pair friction laws: one file each, their registry, and the owner of the fluctuation–dissipation balance.

pub mod fluctuation_dissipation;
pub mod linear;

use crate::lanes::{BlockNumbers, Lanes, Real};
use crate::pair::PairLaw;
use crate::potential::Requirement;
use serde::{Deserialize, Serialize};

/// A friction along the line of centers with strength Γ(r) = γ ω(r): the dissipative force on i is −Γ (e·v_ij) e.
///
/// `strength` is called for 0 < r < cutoff only.
pub trait PairFriction: Copy + Send + Sync {
    /// r_c: no friction at and beyond.
    fn cutoff(&self) -> f64;
    /// Γ(r).
    fn strength<R: Real>(&self, r: R) -> R;
    /// Name, value and requirement of every number that a user gives.
    fn parameters(&self) -> Vec<(&'static str, f64, Requirement)>;
}

/// Any of the known friction laws, by its name in the input file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Friction {
    /// Linear in the relative velocity.
    Linear(linear::Linear),
}

/// Evaluates `$body` with the concrete law, so that a loop inside is compiled for that law alone.
macro_rules! with_law {
    ($friction:expr, $law:ident => $body:expr) => {
        match $friction {
            Friction::Linear(law) if law.exponent == 2.0 => {
                let $law = &law.quadratic();
                $body
            }
            Friction::Linear($law) => $body,
        }
    };
}

impl Friction {
    /// r_c.
    pub fn cutoff(&self) -> f64 {
        with_law!(self, law => law.cutoff())
    }

    /// Γ(r), zero at and beyond the cutoff.
    #[inline(always)]
    pub fn strength<R: Real>(&self, r: R) -> R {
        with_law!(self, law => R::select(r.below(R::splat(law.cutoff())), law.strength(r), R::splat(0.0)))
    }

    /// Name, value and requirement of every number that a user gives.
    pub fn parameters(&self) -> Vec<(&'static str, f64, Requirement)> {
        with_law!(self, law => law.parameters())
    }
}

impl PairLaw for Friction {
    #[inline(always)]
    fn fill<L: Lanes>(&self, streams: usize, distance: &BlockNumbers, values: &mut BlockNumbers) {
        with_law!(self, law => {
            for s in 0..streams {
                let r = L::load(&distance[s]);
                L::select(r.below(L::splat(law.cutoff())), law.strength(r), L::splat(0.0)).store(&mut values[s]);
            }
        });
    }
}
