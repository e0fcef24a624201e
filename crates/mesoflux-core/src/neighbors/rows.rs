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
    /// The smallest rectangle across the rows in which they are.
    rectangle: Rectangle,
}

/// A rectangle across the rows, by its lowest and highest coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rectangle {
    pub low: [f32; 2],
    pub high: [f32; 2],
}

impl Rectangle {
    /// The rectangle moved.
    #[inline(always)]
    pub fn shifted(&self, shift: [f32; 2]) -> Self {
        let Self { low: [a, b], high: [c, d] } = *self;
        Self { low: [a + shift[0], b + shift[1]], high: [c + shift[0], d + shift[1]] }
    }
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
        for axis in 0..2 {
            let (low, high) = (&mut self.rectangle.low[axis], &mut self.rectangle.high[axis]);
            (*low, *high) = (f32::INFINITY, f32::NEG_INFINITY);
            for &coordinate in &self.coordinates[1 + axis][lower..upper] {
                *low = if coordinate < *low { coordinate } else { *low };
                *high = if coordinate > *high { coordinate } else { *high };
            }
        }
    }

    /// The row's entries, all columns of one length.
    #[inline(always)]
    pub fn entries(&self) -> Entries<'_> {
        let (length, [x, y, z]) = (self.place.len(), &self.coordinates);
        Entries { place: &self.place, x: &x[..length], y: &y[..length], z: &z[..length] }
    }

    /// The entries of the row's own particles.
    #[inline(always)]
    pub fn own(&self, grid: &Grid) -> Range<usize> {
        self.starts[grid.reach] as usize..self.starts[grid.reach + grid.cells] as usize
    }

    /// All entries.
    #[inline(always)]
    pub fn all(&self) -> Range<usize> {
        0..self.starts[self.starts.len() - 1] as usize
    }

    /// The rectangle across the rows in which the row's own particles are.
    #[inline(always)]
    pub fn rectangle(&self) -> &Rectangle {
        &self.rectangle
    }

    /// The entries of another row that may be near to one of the own particles from place `first` to `last`.
    #[inline(always)]
    pub fn window(&self, first: u32, last: u32, grid: &Grid, other: &Self) -> Range<usize> {
        let cell = |place: u32| usize::from(self.cell[(place - self.own.start + self.starts[grid.reach]) as usize]);
        other.starts[cell(first) - grid.reach] as usize..other.starts[cell(last) + grid.reach + 1] as usize
    }
}

/// Particles in the order of their row, for a search.
#[derive(Debug, Clone, Copy)]
pub struct Entries<'a> {
    pub place: &'a [u32],
    pub x: &'a [f32],
    pub y: &'a [f32],
    pub z: &'a [f32],
}

impl Entries<'_> {
    /// Places and coordinates of the entries of a cluster, moved across the rows; beyond its end stands nobody.
    #[inline(always)]
    pub fn cluster(&self, cluster: Range<usize>, shift: [f32; 2]) -> ([u32; CLUSTER], [[f32; 3]; CLUSTER]) {
        let (mut places, mut points) = ([0; CLUSTER], [[f32::NAN; 3]; CLUSTER]);
        let entries = cluster.start..cluster.start + CLUSTER;
        let (place, x) = (&self.place[entries.clone()], &self.x[entries.clone()]);
        let (y, z) = (&self.y[entries.clone()], &self.z[entries.clone()]);
        for k in 0..CLUSTER {
            places[k] = place[k];
            let inside = cluster.start + k < cluster.end;
            points[k] = [if inside { x[k] } else { f32::NAN }, y[k] + shift[0], z[k] + shift[1]];
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
