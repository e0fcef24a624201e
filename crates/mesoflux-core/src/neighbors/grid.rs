//! The global grid: bricks that own pairs, and the cells inside them that find pairs.
//!
//! The grid follows from the box and the list radius alone. Bricks are at least one list radius wide and their count along each
//! axis is even, so that bricks of equal parity along every axis (one of eight colors) touch no common particle when each
//! works on the pairs it owns. A pair belongs to the componentwise smallest of its particles' bricks.

use crate::boundary::{Image, PeriodicBox};
use crate::vector::Vector;

/// Cells are at least a list radius wide: neighbors are in the same or the next cell.
const REACH: usize = 1;

/// Most cells for each particle, on average.
const CELLS_PER_PARTICLE: f64 = 8.0;

/// Most cells along a brick's edge.
const LARGEST_BRICK: usize = 8;

/// Geometry of bricks and cells.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Bricks along each axis; even.
    pub bricks: [usize; 3],
    /// Cells along each edge of a brick.
    pub cells: [usize; 3],
    inverse_edge: Vector,
    cell_pairs: Vec<[u32; 2]>,
}

/// A cell as a brick sees it: which cell it is, and in which copy of the box.
#[derive(Debug, Clone, Copy)]
pub struct SeenCell {
    /// Index of the cell in the global, brick-major order.
    pub cell: usize,
    copies: [i32; 3],
}

impl SeenCell {
    /// The image by which r_i − r_j is offset when i is here and j in `other`.
    pub fn image_to(&self, other: &Self) -> Image {
        PeriodicBox::image_index(std::array::from_fn(|axis| self.copies[axis] - other.copies[axis]))
    }
}

impl Grid {
    /// The grid for a list radius of at most half the shortest side.
    pub fn new(region: &PeriodicBox, list_radius: f64, particles: usize) -> Self {
        let mut most = region.sides().map(|side| side / list_radius * REACH as f64);
        // A nearly empty box needs no more cells than a few for each particle. An axis that has the fewest cells already leaves
        // the rest of the saving to the others, so three passes are enough.
        let fewest = 2.0 * REACH as f64;
        for _ in 0..3 {
            let excess = most.iter().product::<f64>() / (CELLS_PER_PARTICLE * particles as f64 + 64.0);
            let wide = most.iter().filter(|&&cells| cells > fewest).count();
            if excess > 1.0 && wide > 0 {
                let factor = excess.powf(1.0 / wide as f64);
                most = most.map(|cells| if cells > fewest { (cells / factor).max(fewest) } else { cells });
            }
        }
        let mut bricks = [2; 3];
        let mut cells = [REACH; 3];
        for axis in 0..3 {
            // As many cells as fit, in an even number of bricks; among equals the brick nearest to four cells.
            let most = most[axis].floor() as usize;
            let candidates =
                (REACH..=LARGEST_BRICK).map(|edge| (2 * (most / (2 * edge)), edge)).filter(|&(n, _)| n >= 2);
            if let Some((n, edge)) =
                candidates.max_by_key(|&(n, edge)| (n * edge, std::cmp::Reverse(edge.abs_diff(4)), edge))
            {
                (bricks[axis], cells[axis]) = (n, edge);
            }
        }
        let edges: Vector = std::array::from_fn(|axis| region.sides()[axis] / (bricks[axis] * cells[axis]) as f64);
        Self { bricks, cells, inverse_edge: edges.map(|edge| 1.0 / edge), cell_pairs: cell_pairs(cells) }
    }

    /// The number of cells.
    pub fn cell_count(&self) -> usize {
        (0..3).map(|axis| self.bricks[axis] * self.cells[axis]).product()
    }

    /// The cell of a position inside the box.
    pub fn cell_of(&self, position: Vector) -> usize {
        self.index(std::array::from_fn(|axis| {
            ((position[axis] * self.inverse_edge[axis]) as usize).min(self.bricks[axis] * self.cells[axis] - 1)
        }))
    }

    /// Brick-major index of a cell given by its coordinates.
    fn index(&self, coordinates: [usize; 3]) -> usize {
        let flat = |place: [usize; 3], counts: [usize; 3]| (place[2] * counts[1] + place[1]) * counts[0] + place[0];
        let brick = flat(std::array::from_fn(|axis| coordinates[axis] / self.cells[axis]), self.bricks);
        let local = flat(std::array::from_fn(|axis| coordinates[axis] % self.cells[axis]), self.cells);
        brick * self.cells.iter().product::<usize>() + local
    }

    /// All bricks by their coordinates, ordered by color, and where each of the eight colors begins.
    pub fn bricks_by_color(&self) -> (Vec<[usize; 3]>, [usize; 9]) {
        let mut ordered = Vec::new();
        let mut starts = [0; 9];
        for color in 0..8 {
            let parity = [color & 1, color >> 1 & 1, color >> 2 & 1];
            for z in (parity[2]..self.bricks[2]).step_by(2) {
                for y in (parity[1]..self.bricks[1]).step_by(2) {
                    for x in (parity[0]..self.bricks[0]).step_by(2) {
                        ordered.push([x, y, z]);
                    }
                }
            }
            starts[color + 1] = ordered.len();
        }
        (ordered, starts)
    }

    /// The cells that a brick sees: its own and, on its upper faces, the nearest layers of the next bricks.
    pub fn region(&self, brick: [usize; 3], region: &mut Vec<SeenCell>) {
        region.clear();
        for_each_place(self.cells.map(|cells| cells + REACH), |place| region.push(self.seen(brick, place)));
    }

    /// The pairs of near cells that every brick owns, as places in its region, in the sweep's order; a cell with itself too.
    pub fn cell_pairs(&self) -> &[[u32; 2]] {
        &self.cell_pairs
    }

    fn seen(&self, brick: [usize; 3], local: [usize; 3]) -> SeenCell {
        let mut copies = [0; 3];
        let coordinates = std::array::from_fn(|axis| {
            let count = self.bricks[axis] * self.cells[axis];
            let coordinate = brick[axis] * self.cells[axis] + local[axis];
            if coordinate < count {
                coordinate
            } else {
                copies[axis] = 1;
                coordinate - count
            }
        });
        SeenCell { cell: self.index(coordinates), copies }
    }
}

/// Calls `visit` for every place of a block of cells, x running fastest.
fn for_each_place(extent: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    for z in 0..extent[2] {
        for y in 0..extent[1] {
            for x in 0..extent[0] {
                visit([x, y, z]);
            }
        }
    }
}

/// The pairs of cells that a brick owns: each of its cells with itself, and neighbors of which along every axis one is its own.
fn cell_pairs(cells: [usize; 3]) -> Vec<[u32; 2]> {
    let extent = cells.map(|cells| cells + REACH);
    let flat = |place: [usize; 3]| ((place[2] * extent[1] + place[1]) * extent[0] + place[0]) as u32;
    let own = |place: [usize; 3]| -> [bool; 3] { std::array::from_fn(|axis| place[axis] < cells[axis]) };
    let mut pairs = Vec::new();
    for_each_place(extent, |here| {
        if own(here) == [true; 3] {
            pairs.push([flat(here), flat(here)]);
        }
        for offset in later_neighbors() {
            // A place below zero wraps around to a large number, which is outside as well.
            let there: [usize; 3] = std::array::from_fn(|axis| here[axis].wrapping_add_signed(offset[axis]));
            let inside = (0..3).all(|axis| there[axis] < extent[axis]);
            if inside && (0..3).all(|axis| own(here)[axis] || own(there)[axis]) {
                pairs.push([flat(here), flat(there)]);
            }
        }
    });
    pairs
}

/// The later half of the offsets to the surrounding cells.
fn later_neighbors() -> impl Iterator<Item = [isize; 3]> {
    let reach = REACH as isize;
    let offsets = (-reach..=reach)
        .flat_map(move |z| (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y, z])));
    offsets.filter(|&[x, y, z]| (z, y, x) > (0, 0, 0))
}
