//! The global grid: bricks that own pairs, and the cells inside them that find pairs.
//!
//! The grid follows from the box and the list radius alone. Bricks are at least one list radius wide and their count along each
//! axis is even, so that bricks of equal parity along every axis (one of eight colors) touch no common particle when each
//! works on the pairs it owns. A pair belongs to the componentwise smallest of its particles' bricks.

use crate::boundary::{Image, PeriodicBox};
use crate::vector::Vector;

/// Cells are at least half a list radius wide: neighbors are at most two cells away.
const REACH: usize = 2;

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
    /// Offsets to those of the 124 surrounding cells that come later in the order and are near enough.
    stencil: Vec<[isize; 3]>,
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
        Self { bricks, cells, inverse_edge: edges.map(|edge| 1.0 / edge), stencil: stencil(edges, list_radius) }
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

    /// Calls `visit(a, b)` for every pair of near cells that a brick owns, `None` for a cell with itself; in the sweep's order.
    pub fn for_each_cell_pair(&self, brick: [usize; 3], mut visit: impl FnMut(SeenCell, Option<SeenCell>)) {
        // A brick sees its own cells and, on its upper faces, the nearest layers of the next bricks.
        let extent = self.cells.map(|cells| cells + REACH);
        let mut region = Vec::with_capacity(extent.iter().product());
        for_each_place(extent, |place| region.push(self.seen(brick, place)));
        let own = |place: [usize; 3]| -> [bool; 3] { std::array::from_fn(|axis| place[axis] < self.cells[axis]) };
        let mut index = 0;
        for_each_place(extent, |here| {
            let (cell, mine) = (region[index], own(here));
            index += 1;
            if mine == [true; 3] {
                visit(cell, None);
            }
            for offset in &self.stencil {
                // A place below zero wraps around to a large number, which is outside as well.
                let there: [usize; 3] = std::array::from_fn(|axis| here[axis].wrapping_add_signed(offset[axis]));
                let inside = (0..3).all(|axis| there[axis] < extent[axis]);
                if inside && (0..3).all(|axis| mine[axis] || there[axis] < self.cells[axis]) {
                    let place = (there[2] * extent[1] + there[1]) * extent[0] + there[0];
                    visit(cell, Some(region[place]));
                }
            }
        });
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

/// The later half of the offsets to cells whose nearest corners are less than a list radius apart.
fn stencil(edges: Vector, list_radius: f64) -> Vec<[isize; 3]> {
    let reach = REACH as isize;
    let mut offsets = Vec::new();
    for z in -reach..=reach {
        for y in -reach..=reach {
            for x in -reach..=reach {
                let offset = [x, y, z];
                let gap_squared: f64 =
                    (0..3).map(|axis| ((offset[axis].abs() - 1).max(0) as f64 * edges[axis]).powi(2)).sum();
                let later = (z, y, x) > (0, 0, 0);
                if later && gap_squared < list_radius * list_radius {
                    offsets.push(offset);
                }
            }
        }
    }
    offsets
}
