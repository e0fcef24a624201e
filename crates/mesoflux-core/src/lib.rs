//! The mesoflux engine: dissipative particle dynamics in equilibrium and driven out of it.
//!
//! No files, no printing, no clocks. A [`system::System`] holds particles, box, laws and neighbor list; an
//! [`integrate::Integrator`] moves it on, letter by letter; a [`driving::Driving`] may act between the letters;
//! [`observable`]s read it. `ARCHITECTURE.md` follows a particle through one step.

pub mod bond;
pub mod boundary;
pub mod domain;
pub mod driving;
pub mod elementary;
pub mod expression;
pub mod field;
pub mod forcing;
pub mod friction;
pub mod integrate;
pub mod interactions;
pub mod lanes;
pub mod neighbors;
pub mod noise;
pub mod observable;
pub mod pair;
pub mod potential;
pub mod run;
pub mod scalar_langevin;
pub mod simulation;
pub mod snapshot;
pub mod start;
pub mod state;
pub mod system;
pub mod tensor;
pub mod vector;
