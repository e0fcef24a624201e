//! The neighbor list: particles sorted by rows of cells, and the contacts found in them.
//!
//! Particles are sorted anew when some two of them may have moved by the skin together. With a thick skin a search of the near
//! cells finds the pairs within the cutoff at every new position: there is no list of pairs to build and to keep. With a thin
//! one, of which particles take many steps to cross, the pairs within cutoff plus skin are found when the particles are sorted,
//! and kept: those few of them that are beyond the cutoff feel nothing.
//!
//! The order of pairs follows from the positions at the last sorting, the order of storage before it, and the input alone:
//! bricks by color, inside a brick row by row, each with its near rows, particle by particle in storage order; `Contacts` says
//! in which order these are visited. Threads, timings and how often the particles were sorted leave no trace.

mod grid;
mod packed;
mod rows;
mod search;

pub use grid::Grid;

use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::interactions::Kind;
use crate::lanes::{InstructionSet, Row};
use crate::pair::Contacts;
use crate::state::{Particles, SpareColumns};
use crate::vector::{Vector, dot, subtract};
use packed::Packed;
use rows::{SearchRow, search_radius_squared};
use search::Search;
use std::cell::RefCell;

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

/// Of the cutoff: the thickest skin that is thin. Beyond it too many pairs would be kept that feel nothing.
const THIN: f64 = 0.05;

/// A brick: the pairs of neighbors that one thread works on at a time.
#[derive(Debug, Clone)]
struct Brick {
    coordinates: [usize; 2],
    contacts: Contacts,
}

thread_local! {
    /// Where a thread packs the particles of two rows.
    static PACKED: RefCell<[Packed; 2]> = RefCell::default();
    /// Where a thread puts contacts that are forgotten right after.
    static CONTACTS: RefCell<Contacts> = RefCell::default();
}

/// The kind of the pair of particles in two places.
pub type KindOfPair<'a> = dyn Fn(&Particles, u32, u32) -> Kind + Sync + 'a;

/// What a sorting needs room for.
#[derive(Debug, Clone, Default)]
struct Sorting {
    /// The cell of each particle.
    cell: Vec<u32>,
    /// Where each cell begins, and where the last one ends.
    starts: Vec<u32>,
    /// Where the next particle of each cell goes.
    next: Vec<u32>,
    /// The old place of each particle.
    order: Vec<u32>,
    spare: SpareColumns,
}

/// The neighbor list of a system.
#[derive(Debug, Clone)]
pub struct NeighborList {
    region: PeriodicBox,
    grid: Grid,
    cutoff: f64,
    skin: f64,
    /// Bricks ordered by color.
    bricks: Vec<Brick>,
    color_starts: [usize; 5],
    rows: Vec<SearchRow>,
    /// Present positions and ids, in storage order.
    points: Vec<Row>,
    /// Positions at the last sorting, in storage order.
    reference: Vec<Vector>,
    sorting: Sorting,
    /// Whether contacts are kept from one sorting to the next.
    keeps_contacts: bool,
    builds: u64,
}

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
        let brick = |coordinates| Brick { coordinates, contacts: Contacts::default() };
        Ok(Self {
            region: *region,
            rows: vec![SearchRow::default(); grid.row_count()],
            grid,
            cutoff,
            skin,
            bricks: order.into_iter().map(brick).collect(),
            color_starts,
            points: Vec::new(),
            reference: Vec::new(),
            sorting: Sorting::default(),
            keeps_contacts: skin <= THIN * cutoff,
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
    #[inline(always)]
    pub fn displacement_squared(&self, particles: &Particles, k: usize) -> f64 {
        let moved = subtract(particles.position[k], self.reference[k]);
        dot(moved, moved)
    }

    /// Wraps the positions and sorts the particles by cell; those of one cell keep their order.
    ///
    /// Positions must be finite. `kind` gives the kind of the pair of particles in two places where there are several.
    pub fn build(&mut self, particles: &mut Particles, kind: Option<&KindOfPair>, workers: Workers) {
        let region = self.region;
        workers.for_each_chunk_of_two(&mut particles.position, &mut particles.crossings, |_, positions, crossings| {
            for (position, crossings) in positions.iter_mut().zip(crossings) {
                region.wrap(position, crossings);
            }
        });
        self.sort_by_cell(particles, workers);
        let (grid, cells, starts) = (&self.grid, self.grid.cells, &self.sorting.starts);
        workers.for_each(&mut self.rows, |number, row| row.sort(grid, &starts[number * cells..=(number + 1) * cells]));
        self.reference.clone_from(&particles.position);
        self.builds += 1;
        if self.keeps_contacts {
            self.find_contacts(particles, self.cutoff + self.skin, kind, workers);
        }
    }

    /// Sorts the particles by cell.
    fn sort_by_cell(&mut self, particles: &mut Particles, workers: Workers) {
        let (grid, Sorting { cell, starts, next, order, spare }) = (&self.grid, &mut self.sorting);
        cell.resize(particles.count(), 0);
        workers.for_each_chunk(cell, |offset, cells| {
            for (cell, position) in cells.iter_mut().zip(&particles.position[offset..]) {
                *cell = grid.cell_of(position) as u32;
            }
        });
        starts.clear();
        starts.resize(grid.cell_count() + 1, 0);
        cell.iter().for_each(|&c| starts[c as usize + 1] += 1);
        for c in 0..grid.cell_count() {
            starts[c + 1] += starts[c];
        }
        next.clone_from(starts);
        order.resize(particles.count(), 0);
        for (k, &c) in cell.iter().enumerate() {
            let place = &mut next[c as usize];
            order[*place as usize] = k as u32;
            *place += 1;
        }
        particles.reorder(order, spare, workers);
    }

    /// Brings the contacts up to date with the present positions; `kind` as for `build`.
    pub fn update_contacts(&mut self, particles: &Particles, kind: Option<&KindOfPair>, workers: Workers) {
        self.follow(particles, workers);
        if !self.keeps_contacts {
            self.find_contacts(particles, self.cutoff, kind, workers);
        }
    }

    /// Takes over the present positions.
    pub(crate) fn follow(&mut self, particles: &Particles, workers: Workers) {
        self.points.resize(particles.count(), Row::default());
        workers.for_each_chunk(&mut self.points, |offset, points| {
            let columns = particles.position[offset..].iter().zip(&particles.id[offset..]);
            for (point, (&position, &id)) in points.iter_mut().zip(columns) {
                *point = Row::new(position, f64::from_bits(id));
            }
        });
    }

    /// Finds the pairs within a radius.
    fn find_contacts(&mut self, particles: &Particles, radius: f64, kind: Option<&KindOfPair>, workers: Workers) {
        self.follow_rows(particles, workers);
        let mut bricks = std::mem::take(&mut self.bricks);
        workers.for_each(&mut bricks, |_, brick| {
            self.find(brick.coordinates, particles, radius, kind, &mut brick.contacts);
        });
        self.bricks = bricks;
    }

    /// Brings the rows up to date with the present positions.
    fn follow_rows(&mut self, particles: &Particles, workers: Workers) {
        let (grid, region) = (&self.grid, &self.region);
        workers.for_each(&mut self.rows, |_, row| row.update(grid, region, &particles.position));
    }

    /// Finds one brick's pairs within a radius, the rows being up to date.
    fn find(
        &self,
        brick: [usize; 2],
        particles: &Particles,
        radius: f64,
        kind: Option<&KindOfPair>,
        contacts: &mut Contacts,
    ) {
        let Self { grid, region, rows, .. } = self;
        let squared = search_radius_squared(radius, region);
        PACKED.with_borrow_mut(|packed| {
            InstructionSet::detect().run(Search { grid, region, rows, brick, squared, packed, contacts });
        });
        if let Some(kind) = kind {
            contacts.set_kinds(|i, j| kind(particles, i, j));
        }
    }

    /// Calls `work` with the contacts of every brick at the present positions, found just before and then forgotten: nothing
    /// leaves the nearest cache. Color after color, as `sweep` does.
    pub(crate) fn sweep_once(
        &mut self,
        particles: &Particles,
        kind: Option<&KindOfPair>,
        workers: Workers,
        work: impl Fn(&Self, &Contacts) + Sync,
    ) {
        self.follow(particles, workers);
        if self.keeps_contacts {
            self.sweep(false, workers, |contacts| work(self, contacts));
            return;
        }
        self.follow_rows(particles, workers);
        let list = &*self;
        for color in self.color_starts.windows(2) {
            workers.for_each_shared(&list.bricks[color[0]..color[1]], |brick| {
                CONTACTS.with_borrow_mut(|contacts| {
                    list.find(brick.coordinates, particles, list.cutoff, kind, contacts);
                    work(list, contacts);
                });
            });
        }
    }

    /// Calls `work` with the contacts of every brick, color after color; bricks that are visited at the same time touch no
    /// common particle.
    ///
    /// Returns what `work` returned, in the order of the bricks.
    pub(crate) fn sweep<T: Send>(
        &self,
        backward: bool,
        workers: Workers,
        work: impl Fn(&Contacts) -> T + Sync,
    ) -> Vec<T> {
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(self.bricks.len(), || None);
        for step in 0..4 {
            let color = if backward { 3 - step } else { step };
            let range = self.color_starts[color]..self.color_starts[color + 1];
            let bricks = &self.bricks[range.clone()];
            workers.for_each(&mut results[range], |k, result| *result = Some(work(&bricks[k].contacts)));
        }
        results.into_iter().flatten().collect()
    }

    /// The contacts of each brick, the bricks in the forward order of the sweep.
    pub fn contacts(&self) -> impl Iterator<Item = &Contacts> {
        self.bricks.iter().map(|brick| &brick.contacts)
    }

    /// Positions and, as bits, ids at the time when the contacts were found, in storage order.
    pub(crate) fn points(&self) -> &[Row] {
        &self.points
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

    /// The box.
    pub fn region(&self) -> &PeriodicBox {
        &self.region
    }
}

#[cfg(test)]
mod tests;
