//! The Verlet list: every pair within cutoff plus skin, in the order of the sweep.
//!
//! The order follows from the positions at which the list was built and from the input: bricks by color, inside a brick the
//! pairs of cells in the grid's order, inside these the particles by id, and all that dealt out in rounds: the first pair of every
//! particle, then the second, and so on. Threads, timings and rebuild counts leave no trace.

mod grid;
mod listing;

pub use grid::Grid;

use crate::boundary::{Image, PeriodicBox};
use crate::domain::Workers;
use crate::interactions::Kind;
use crate::pair::{Contacts, InstructionSet, Kernel};
use crate::state::Particles;
use crate::vector::{Vector, dot, subtract};
use listing::{Coordinates, Listing, Scratch};
use rayon::prelude::*;

/// Two particles by their places in storage, and the image that brings them together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ListedPair {
    /// Place of the first particle.
    pub first: u32,
    /// Place of the second particle.
    pub second: u32,
    /// Offset to add to r_first − r_second.
    pub image: Image,
    /// Which laws act between them; zero where there is but one kind of pair.
    pub kind: Kind,
}

/// The pairs that one brick owns.
#[derive(Debug, Clone, Default)]
pub struct Brick {
    coordinates: [usize; 3],
    /// Pairs within the list radius when the list was built.
    pub listed: Vec<ListedPair>,
    /// Those within the cutoff now.
    pub contacts: Contacts,
}

/// A neighbor list that cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NeighborError {
    /// A pair would meet in two images at once.
    #[error(
        "the shortest side of the box is {side}: must be at least {smallest}, twice the list radius \
         (largest cutoff {cutoff} plus skin {skin}), so that no pair meets in two images"
    )]
    BoxTooSmall {
        /// The shortest side.
        side: f64,
        /// The smallest legal one.
        smallest: f64,
        /// The largest cutoff.
        cutoff: f64,
        /// The skin.
        skin: f64,
    },
    /// Not a usable skin.
    #[error("the skin is {0}: must be positive and finite")]
    Skin(f64),
}

/// The Verlet list of a system.
#[derive(Debug, Clone)]
pub struct NeighborList {
    grid: Grid,
    cutoff: f64,
    skin: f64,
    /// Bricks ordered by color.
    bricks: Vec<Brick>,
    color_starts: [usize; 9],
    coordinates: Coordinates,
    /// Positions at which the list was built, in storage order.
    reference: Vec<Vector>,
    /// For each image the offset of r_i − r_j.
    offsets: [Vector; 27],
    /// Whether there are several kinds of pairs.
    kinds: bool,
    builds: u64,
}

/// The kind of the pair of particles in two places.
pub type KindOfPair<'a> = dyn Fn(&Particles, u32, u32) -> Kind + Sync + 'a;

impl NeighborList {
    /// An empty list for a box, a largest cutoff and a number of particles.
    ///
    /// # Errors
    /// A box with a side below twice the list radius; a skin that is not positive.
    pub fn new(region: &PeriodicBox, cutoff: f64, skin: f64, particles: usize) -> Result<Self, NeighborError> {
        if !(skin > 0.0 && skin.is_finite()) {
            return Err(NeighborError::Skin(skin));
        }
        let (side, smallest) = (region.shortest_side(), 2.0 * (cutoff + skin));
        if side < smallest {
            return Err(NeighborError::BoxTooSmall { side, smallest, cutoff, skin });
        }
        let grid = Grid::new(region, cutoff + skin, particles);
        let (order, color_starts) = grid.bricks_by_color();
        let bricks = order.into_iter().map(|coordinates| Brick { coordinates, ..Brick::default() }).collect();
        Ok(Self {
            grid,
            cutoff,
            skin,
            bricks,
            color_starts,
            coordinates: Coordinates::default(),
            reference: Vec::new(),
            offsets: region.image_offsets(),
            kinds: false,
            builds: 0,
        })
    }

    /// Whether two particles have together moved so far since the last build that an unlisted pair might have come within
    /// the cutoff.
    pub fn is_spent(&self, particles: &Particles, workers: Workers) -> bool {
        let [farthest, second] = workers.two_largest(particles.count(), |k| self.displacement_squared(particles, k));
        farthest.sqrt() + second.sqrt() > self.skin
    }

    /// The longest way from the reference positions; infinite if a position isn't a number.
    pub fn largest_displacement(&self, particles: &Particles, workers: Workers) -> f64 {
        workers.two_largest(particles.count(), |k| self.displacement_squared(particles, k))[0].sqrt()
    }

    /// The squared way of the particle in place k since the last build.
    pub fn displacement_squared(&self, particles: &Particles, k: usize) -> f64 {
        let moved = subtract(particles.position[k], self.reference[k]);
        dot(moved, moved)
    }

    /// Wraps the positions, sorts the particles by cell and id, and lists all pairs within the list radius.
    ///
    /// Positions must be finite.
    ///
    /// `kind` gives the kind of the pair of particles in two places; `None` where there is but one.
    pub fn build(
        &mut self,
        particles: &mut Particles,
        region: &PeriodicBox,
        kind: Option<&KindOfPair>,
        workers: Workers,
    ) {
        for (position, crossings) in particles.position.iter_mut().zip(&mut particles.crossings) {
            region.wrap(position, crossings);
        }
        let cell_starts = self.sort_by_cell(particles);
        self.coordinates.update(&particles.position);
        let (grid, offsets, radius) = (&self.grid, &self.offsets, self.cutoff + self.skin);
        let (particles, coordinates, starts) = (&*particles, &self.coordinates, &cell_starts);
        let instructions = InstructionSet::detect();
        // Of the pairs in a sphere of the list radius, those within the cutoff, and a little room.
        let within = 1.1 * (self.cutoff / radius).powi(3);
        let kinds = kind.is_some();
        let list = |scratch: &mut Scratch, brick: &mut Brick| {
            let Brick { coordinates: place, listed, contacts } = brick;
            let radius_squared = radius * radius;
            instructions.run(Listing {
                grid,
                brick: *place,
                starts,
                coordinates,
                offsets,
                radius_squared,
                scratch,
                listed,
            });
            contacts.reserve((within * listed.len() as f64) as usize, kinds);
            if let Some(kind) = kind {
                listed.iter_mut().for_each(|pair| pair.kind = kind(particles, pair.first, pair.second));
            }
        };
        match workers {
            Workers::One => {
                let mut scratch = Scratch::default();
                self.bricks.iter_mut().for_each(|brick| list(&mut scratch, brick));
            }
            Workers::Pool => self.bricks.par_iter_mut().for_each_init(Scratch::default, list),
        }
        self.reference.clone_from(&particles.position);
        self.kinds = kind.is_some();
        self.builds += 1;
    }

    /// Sorts the particles by (cell, id); returns where each cell begins.
    fn sort_by_cell(&self, particles: &mut Particles) -> Vec<u32> {
        let count = particles.count();
        let cell: Vec<u32> = particles.position.iter().map(|&x| self.grid.cell_of(x) as u32).collect();
        let mut starts = vec![0u32; self.grid.cell_count() + 1];
        cell.iter().for_each(|&c| starts[c as usize + 1] += 1);
        for c in 0..self.grid.cell_count() {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut order = vec![0u32; count];
        for k in 0..count {
            let place = &mut next[cell[k] as usize];
            order[*place as usize] = k as u32;
            *place += 1;
        }
        for pair in starts.windows(2) {
            order[pair[0] as usize..pair[1] as usize].sort_unstable_by_key(|&k| particles.id[k as usize]);
        }
        particles.reorder(&order);
        starts
    }

    /// Brings the contacts of every brick up to date with the positions.
    pub fn update_contacts(&mut self, particles: &Particles, workers: Workers) {
        let (offsets, cutoff, kinds) = (&self.offsets, self.cutoff, self.kinds);
        let instructions = InstructionSet::detect();
        let update = |brick: &mut Brick| instructions.run(BrickContacts { brick, particles, offsets, cutoff, kinds });
        match workers {
            Workers::One => self.bricks.iter_mut().for_each(update),
            Workers::Pool => self.bricks.par_iter_mut().for_each(update),
        }
    }

    /// Calls `work` for every brick, color after color; bricks that are visited at the same time touch no common particle.
    ///
    /// Returns what `work` returned, in the order of the bricks.
    pub(crate) fn sweep<T: Send>(&self, backward: bool, workers: Workers, work: impl Fn(&Brick) -> T + Sync) -> Vec<T> {
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(self.bricks.len(), || None);
        for step in 0..8 {
            let color = if backward { 7 - step } else { step };
            let range = self.color_starts[color]..self.color_starts[color + 1];
            let (bricks, results) = (&self.bricks[range.clone()], &mut results[range]);
            match workers {
                Workers::One => bricks.iter().zip(results).for_each(|(brick, result)| *result = Some(work(brick))),
                Workers::Pool => {
                    bricks.par_iter().zip(results).for_each(|(brick, result)| *result = Some(work(brick)));
                }
            }
        }
        results.into_iter().flatten().collect()
    }

    /// The bricks in the forward order of the sweep.
    pub fn bricks(&self) -> &[Brick] {
        &self.bricks
    }

    /// The positions at which the list was built, in storage order.
    pub fn reference(&self) -> &[Vector] {
        &self.reference
    }

    /// How many times the list was built.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// The skin.
    pub fn skin(&self) -> f64 {
        self.skin
    }
}

/// Brings one brick's contacts up to date.
struct BrickContacts<'a> {
    brick: &'a mut Brick,
    particles: &'a Particles,
    offsets: &'a [Vector; 27],
    cutoff: f64,
    kinds: bool,
}

impl Kernel for BrickContacts<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.brick.contacts.update(&self.brick.listed, self.particles, self.offsets, self.cutoff, self.kinds);
    }
}

#[cfg(test)]
mod tests;
