//! The global grid: rows of cells that find pairs, and bricks of rows that own them.
//!
//! It follows from the box, the list radius and the number of particles alone. Rows run along the shortest side of the box and
//! are at least one list radius wide, so that near particles are in the same or a neighboring row; the cells of a row are
//! narrower. A pair belongs to the brick of the componentwise smallest of the two rows. Bricks of equal parity across both
//! axes (one of four colors) touch no common particle when each works on the pairs it owns, because their count across each
//! axis is even, or one.

use crate::boundary::PeriodicBox;
use crate::vector::Vector;

/// Most cells for each particle, on average.
const CELLS_PER_PARTICLE: f64 = 4.0;

/// Cells within a list radius along a row, at most.
const CELLS_PER_RADIUS: f64 = 4.0;

/// Most cells of a row: their numbers, with those of the copies at both ends, are kept in 16 bits.
const MOST_CELLS: f64 = 30_000.0;

/// The fewest particles that are worth a brick of their own.
const PARTICLES_PER_BRICK: f64 = 100.0;

/// Bricks across an axis that are enough for many threads. Where there are more rows bricks are thicker, because the fewer
/// particles are seen by several bricks, the fewer are fetched into the cache several times.
const MANY_BRICKS: usize = 10;

/// The most rows that a brick is thick for that reason: its particles should stay in a cache.
const MOST_THICK: usize = 4;

/// Geometry of rows, cells and bricks.
#[derive(Debug, Clone)]
pub struct Grid {
    /// The axis along the rows, then those across them.
    pub axes: [usize; 3],
    /// Cells of each row.
    pub cells: usize,
    /// How many cells on either side of a particle's own its neighbors may be in.
    pub reach: usize,
    /// Rows across each axis.
    pub rows: [usize; 2],
    /// Bricks across each axis: even, or one.
    pub bricks: [usize; 2],
    /// Cells and rows per length along the three axes.
    inverse_edge: Vector,
}

/// A row as a brick sees it: which one, and in which copy of the box across each axis.
#[derive(Debug, Clone, Copy)]
pub struct SeenRow {
    /// Its index.
    pub row: usize,
    /// How many box sides away.
    pub copies: [i32; 2],
}

/// The pairs of near rows of which a row is the componentwise smallest, as offsets from it.
pub const ROW_PAIRS: [[[usize; 2]; 2]; 5] =
    [[[0, 0], [0, 0]], [[0, 0], [1, 0]], [[0, 0], [0, 1]], [[0, 0], [1, 1]], [[1, 0], [0, 1]]];

impl Grid {
    /// The grid for a list radius of at most half the shortest side.
    pub fn new(region: &PeriodicBox, list_radius: f64, particles: usize) -> Self {
        let sides = region.sides();
        let shortest = (1..3).fold(0, |best, axis| if sides[axis] < sides[best] { axis } else { best });
        let axes = [shortest, (shortest + 1) % 3, (shortest + 2) % 3];
        let [along, first, second] = axes.map(|axis| sides[axis]);
        // A nearly empty box needs no more rows than a few for each particle.
        let most = CELLS_PER_PARTICLE * particles as f64 + 64.0;
        let mut across = [first / list_radius, second / list_radius];
        for k in [0, 1, 0] {
            let excess = (across[0] * across[1] / most).max(1.0);
            across[k] = (across[k] / if k == 0 { excess.sqrt() } else { excess }).max(2.0);
        }
        let rows = across.map(|rows| rows.floor() as usize);
        let population = particles as f64 / (rows[0] * rows[1]) as f64;
        // Cells as narrow as is of use, but not much narrower than it takes to hold a particle.
        let narrowest = (CELLS_PER_RADIUS * along / list_radius).floor();
        let cells =
            narrowest.min((along / list_radius).max(population).min(CELLS_PER_PARTICLE * population + 2.0).floor());
        let cells = cells.clamp(2.0, MOST_CELLS) as usize;
        let reach = (list_radius * cells as f64 / along).ceil() as usize;
        let worthwhile = (PARTICLES_PER_BRICK / population).sqrt().ceil() as usize;
        let thickness = rows.map(|rows| (rows / MANY_BRICKS).clamp(1, MOST_THICK).max(worthwhile));
        let bricks = [0, 1].map(|k| (rows[k] / thickness[k] / 2 * 2).max(1));
        let inverse_edge = [cells as f64 / along, rows[0] as f64 / first, rows[1] as f64 / second];
        Self { axes, cells, reach, rows, bricks, inverse_edge }
    }

    /// The number of rows.
    pub fn row_count(&self) -> usize {
        self.rows[0] * self.rows[1]
    }

    /// The number of cells.
    pub fn cell_count(&self) -> usize {
        self.row_count() * self.cells
    }

    /// The cell of a position inside the box: those of one row follow each other.
    #[inline(always)]
    pub fn cell_of(&self, position: &Vector) -> usize {
        let place = |k: usize, count: usize| ((position[self.axes[k]] * self.inverse_edge[k]) as usize).min(count - 1);
        (place(2, self.rows[1]) * self.rows[0] + place(1, self.rows[0])) * self.cells + place(0, self.cells)
    }

    /// The row at an offset from the row with the given coordinates.
    pub fn seen(&self, coordinates: [usize; 2], offset: [usize; 2]) -> SeenRow {
        let mut copies = [0; 2];
        let place: [usize; 2] = std::array::from_fn(|k| {
            let place = coordinates[k] + offset[k];
            if place < self.rows[k] {
                return place;
            }
            copies[k] = 1;
            place - self.rows[k]
        });
        SeenRow { row: place[1] * self.rows[0] + place[0], copies }
    }

    /// The coordinates of the rows of a brick.
    pub fn rows_of(&self, brick: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
        let [first, second] = std::array::from_fn(|k| {
            let (rows, bricks) = (self.rows[k], self.bricks[k]);
            brick[k] * rows / bricks..(brick[k] + 1) * rows / bricks
        });
        second.flat_map(move |b| first.clone().map(move |a| [a, b]))
    }

    /// All bricks by their coordinates, ordered by color, and where each of the four colors begins.
    pub fn bricks_by_color(&self) -> (Vec<[usize; 2]>, [usize; 5]) {
        let mut ordered = Vec::new();
        let mut starts = [0; 5];
        for color in 0..4 {
            for b in (color >> 1..self.bricks[1]).step_by(2) {
                ordered.extend((color & 1..self.bricks[0]).step_by(2).map(|a| [a, b]));
            }
            starts[color + 1] = ordered.len();
        }
        (ordered, starts)
    }
}
