//! The particles as a search sees them: row by row, in single precision, with copies of those beyond both ends.
//!
//! Single precision halves what must be loaded and compared. A search takes a radius that is larger by more than rounding can
//! amount to, so that it misses nobody; those few that it finds too far away feel nothing, because every law ends at its cutoff.

use super::grid::Grid;
use crate::boundary::PeriodicBox;
use crate::lanes::SEARCH_WIDTH;
use crate::vector::Vector;
use std::ops::Range;

/// Neighbors in a row that look for their contacts together.
pub const CLUSTER: usize = 4;

/// Of the longest side: more than sixteen roundings of a coordinate that lies at most one and a half sides away.
const ROUNDING: f64 = 32.0 / (1 << 24) as f64;

/// The squared distance below which a search looks for particles nearer than a cutoff.
pub fn search_radius_squared(cutoff: f64, region: &PeriodicBox) -> f32 {
    let longest = region.sides().into_iter().fold(0.0, f64::max);
    let radius = cutoff * (1.0 + 1e-5) + ROUNDING * longest;
    (radius * radius) as f32
}

/// One row.
#[derive(Debug, Clone, Default)]
pub struct SearchRow {
    /// Where each cell begins, those beyond the lower end first, and where the last one ends.
    starts: Vec<u32>,
    /// The cell of each entry.
    cell: Vec<u16>,
    /// Its place in storage.
    place: Vec<u32>,
    /// Coordinates along the row and across it.
    coordinates: [Vec<f32>; 3],
    /// The places in storage of the row's own particles.
    own: Range<u32>,
}

impl SearchRow {
    /// Takes over where the cells of a row begin in storage (and where the last one ends) after the particles were sorted.
    pub fn sort(&mut self, grid: &Grid, cell_starts: &[u32]) {
        let (cells, reach) = (grid.cells, grid.reach);
        self.own = cell_starts[0]..cell_starts[cells];
        self.starts.clear();
        self.place.clear();
        self.cell.clear();
        self.starts.push(0);
        for cell in (cells - reach..cells).chain(0..cells).chain(0..reach) {
            self.place.extend(cell_starts[cell]..cell_starts[cell + 1]);
            self.cell.resize(self.place.len(), self.starts.len() as u16 - 1);
            self.starts.push(self.place.len() as u32);
        }
        // A search loads whole groups: behind the last particle stand some that are near to nobody.
        let length = self.place.len() + SEARCH_WIDTH;
        self.place.resize(length, self.own.start);
        self.cell.resize(length, 0);
        for column in &mut self.coordinates {
            column.clear();
            column.resize(length, f32::NAN);
        }
    }

    /// Brings the coordinates up to date.
    pub fn update(&mut self, grid: &Grid, region: &PeriodicBox, positions: &[Vector]) {
        let side = region.sides()[grid.axes[0]];
        let (own, [along, first, second]) = (self.own.start as usize..self.own.end as usize, &mut self.coordinates);
        let lower = self.starts[grid.reach] as usize;
        let upper = self.starts[grid.reach + grid.cells] as usize;
        let end = self.starts[self.starts.len() - 1] as usize;
        let mut copy = |to: Range<usize>, from: &[Vector], shift: f64| {
            let to = along[to.clone()].iter_mut().zip(&mut first[to.clone()]).zip(&mut second[to]);
            for (((x, y), z), position) in to.zip(from) {
                *x = (position[grid.axes[0]] + shift) as f32;
                *y = position[grid.axes[1]] as f32;
                *z = position[grid.axes[2]] as f32;
            }
        };
        let positions = &positions[own];
        copy(0..lower, &positions[positions.len() - lower..], -side);
        copy(lower..upper, positions, 0.0);
        copy(upper..end, positions, side);
    }

    /// The row's columns, all of one length.
    #[inline(always)]
    pub fn columns(&self) -> Columns<'_> {
        let (length, [x, y, z]) = (self.place.len(), &self.coordinates);
        let cell = &self.cell[..length];
        Columns { starts: &self.starts, cell, place: &self.place, x: &x[..length], y: &y[..length], z: &z[..length] }
    }
}

/// The columns of a row, borrowed for a search.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    starts: &'a [u32],
    cell: &'a [u16],
    place: &'a [u32],
    x: &'a [f32],
    y: &'a [f32],
    z: &'a [f32],
}

impl Columns<'_> {
    /// The entries of the row's own particles.
    #[inline(always)]
    pub fn own(&self, grid: &Grid) -> Range<usize> {
        self.starts[grid.reach] as usize..self.starts[grid.reach + grid.cells] as usize
    }

    /// The entries of another row that may be near to one of the own entries from `first` to `last`.
    #[inline(always)]
    pub fn window(&self, first: usize, last: usize, grid: &Grid, other: &Self) -> Range<usize> {
        let (lower, upper) = (usize::from(self.cell[first]), usize::from(self.cell[last]));
        other.starts[lower - grid.reach] as usize..other.starts[upper + grid.reach + 1] as usize
    }

    /// Places and coordinates of the entries of a cluster, moved across the rows.
    #[inline(always)]
    pub fn cluster(&self, start: usize, shift: [f32; 2]) -> ([u32; CLUSTER], [[f32; 3]; CLUSTER]) {
        let (mut places, mut points) = ([0; CLUSTER], [[0.0; 3]; CLUSTER]);
        let end = start + CLUSTER;
        let columns =
            self.place[start..end].iter().zip(&self.x[start..end]).zip(&self.y[start..end]).zip(&self.z[start..end]);
        for (member, (((&place, &x), &y), &z)) in columns.enumerate() {
            places[member] = place;
            points[member] = [x, y + shift[0], z + shift[1]];
        }
        (places, points)
    }

    /// Places and coordinates of the entries from one on; `None` past the end.
    #[inline(always)]
    pub fn group(&self, entry: usize) -> Option<(&[u32; SEARCH_WIDTH], [&[f32; SEARCH_WIDTH]; 3])> {
        let (x, y) = (self.x.get(entry..)?.first_chunk()?, self.y.get(entry..)?.first_chunk()?);
        let (z, place) = (self.z.get(entry..)?.first_chunk()?, self.place.get(entry..)?.first_chunk()?);
        Some((place, [x, y, z]))
    }
}
