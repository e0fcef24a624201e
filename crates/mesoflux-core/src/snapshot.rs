//! The state of a system between two steps: taken without a copy, and gone on from to the same bits.

use crate::bond::Bond;
use crate::state::Particles;
use crate::system::System;
use crate::vector::Vector;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Everything that a system's future depends on beside its input: the particles, and where they were when the list was built.
///
/// The list's order is part of the state, because the thermostat's sweep follows it. A snapshot that is taken borrows the
/// system's columns, one that is read owns them; both are written alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot<'a> {
    /// Steps done.
    pub step: u64,
    /// The sides of the box.
    pub sides: Vector,
    /// The bonds.
    pub bonds: Cow<'a, [Bond]>,
    /// The particles in storage order.
    pub particles: Cow<'a, Particles>,
    /// Their positions at the last list build.
    pub reference: Cow<'a, [Vector]>,
}

/// A snapshot that does not fit the system.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SnapshotError {
    /// Wrong lengths, ids, species or masses, numbers that are none, or places where no particle can have come.
    #[error("the particles of the snapshot are not consistent")]
    Inconsistent,
    /// Another number of particles.
    #[error("the snapshot has {found} particles: must have {expected}, as the input says")]
    Count {
        /// In the snapshot.
        found: usize,
        /// In the input.
        expected: usize,
    },
    /// Another box.
    #[error("the snapshot is of a box with the sides {found:?}: must be {expected:?}, as the input says")]
    Box {
        /// In the snapshot.
        found: Vector,
        /// In the input.
        expected: Vector,
    },
    /// Other bonds.
    #[error("the bonds of the snapshot are not those of the input")]
    Bonds,
    /// The list built from the reference positions has another order.
    #[error("the neighbor list of the snapshot cannot be built again in its order: box, cutoffs or skin differ")]
    Order,
}

impl System {
    /// The state as it is.
    pub fn snapshot(&self) -> Snapshot<'_> {
        Snapshot {
            step: self.step,
            sides: self.region.sides(),
            bonds: self.topology().bonds().into(),
            particles: Cow::Borrowed(&self.particles),
            reference: self.list().reference().into(),
        }
    }

    /// Takes over a state, to go on from it to the same bits as without the interruption.
    ///
    /// # Errors
    /// A snapshot of another system, or a damaged one; this system is then no longer usable.
    pub fn restore(&mut self, snapshot: Snapshot) -> Result<(), SnapshotError> {
        let (expected, found) = (self.particles.count(), snapshot.particles.count());
        if found != expected {
            return Err(SnapshotError::Count { found, expected });
        }
        let sides = self.region.sides();
        if snapshot.sides != sides {
            return Err(SnapshotError::Box { found: snapshot.sides, expected: sides });
        }
        if snapshot.bonds != self.topology().bonds() {
            return Err(SnapshotError::Bonds);
        }
        // The list was built from wrapped positions: others would be wrapped again, and none may be wrapped twice.
        let inside = |x: &Vector| x.iter().zip(sides).all(|(x, side)| (0.0..side).contains(x));
        let species = self.interactions.potentials.species();
        if snapshot.reference.len() != expected
            || !snapshot.reference.iter().all(inside)
            || !snapshot.particles.is_consistent(species)
            || !snapshot.particles.are_the_same_as(&self.particles)
        {
            return Err(SnapshotError::Inconsistent);
        }
        // Built where it was built before, the list is the same to the last pair; then everybody goes where they have come since.
        // Inside the box nobody is wrapped; in the same order of the ids, the positions kept aside belong to whom they did.
        self.particles = snapshot.particles.into_owned();
        let position = std::mem::replace(&mut self.particles.position, snapshot.reference.into_owned());
        let order = self.particles.id.clone();
        self.rebuild();
        if self.particles.id != order {
            return Err(SnapshotError::Order);
        }
        self.particles.position = position;
        if self.list().is_spent(&self.particles, self.workers) {
            return Err(SnapshotError::Inconsistent);
        }
        self.step = snapshot.step;
        Ok(())
    }
}
