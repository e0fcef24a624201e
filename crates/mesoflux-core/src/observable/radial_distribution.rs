//! The radial distribution function g(r): pairs of particles counted by their distance.
//!
//! The distances of interest are longer than the neighbor list sees, so the pairs are found in a pass of its own over cells:
//! O(N) a sample.

use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::interactions::PairTable;
use crate::potential::Potential;
use crate::state::Particles;
use crate::vector::{Vector, ZERO};
use std::ops::Range;

/// Cells within the longest distance, at most.
const CELLS_PER_DISTANCE: f64 = 4.0;
/// Particles in a cell, on average, at least.
const PARTICLES_PER_CELL: f64 = 4.0;
/// Pieces of work where there are threads.
const PARTS: usize = 64;
/// Parts of a bin over which a law is averaged.
const SUBDIVISIONS: u32 = 64;

/// Equal bins of distance from zero to a longest distance, which must not exceed half the shortest side of the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialBins {
    /// The longest distance, which belongs to no bin.
    pub longest: f64,
    /// The number of bins.
    pub count: usize,
}

impl RadialBins {
    /// The distances where a bin begins and ends.
    pub fn edges(&self, bin: usize) -> [f64; 2] {
        [bin, bin + 1].map(|edge| self.longest * edge as f64 / self.count as f64)
    }

    /// The volume of a bin, 4π/3 (r₂³ − r₁³).
    pub fn volume(&self, bin: usize) -> f64 {
        let [from, to] = self.edges(bin);
        4.0 / 3.0 * std::f64::consts::PI * (to.powi(3) - from.powi(3))
    }

    /// The mean of r f(r) over the volume of a bin: what a pair in it adds to the virial where g(r) is constant over the bin.
    pub fn mean_virial(&self, bin: usize, law: &Potential) -> f64 {
        let [from, to] = self.edges(bin);
        let step = (to - from) / f64::from(SUBDIVISIONS);
        let middles = (0..SUBDIVISIONS).map(|k| from + (f64::from(k) + 0.5) * step);
        let (virial, volume) =
            middles.fold((0.0, 0.0), |(virial, volume), r| (virial + r.powi(3) * law.force(r), volume + r * r));
        virial / volume
    }

    /// How many pairs are at the distances of each bin: all bins of the first kind of pairs of species, then those of the next,
    /// in the order of [`PairTable`].
    pub fn count_pairs(
        &self,
        particles: &Particles,
        region: &PeriodicBox,
        species: usize,
        workers: Workers,
    ) -> Vec<u64> {
        let kinds = species * (species + 1) / 2;
        let cells = Cells::new(particles, region, self.longest);
        let parts = if workers == Workers::One { 1 } else { PARTS };
        let mut counts = vec![vec![0u64; kinds * self.count]; parts];
        let total = cells.starts.len() - 1;
        workers.for_each(&mut counts, |part, counts| {
            self.count_in(&cells, total * part / parts..total * (part + 1) / parts, species == 1, counts);
        });
        let mut sum = counts.swap_remove(0);
        counts.iter().for_each(|part| sum.iter_mut().zip(part).for_each(|(sum, count)| *sum += count));
        sum
    }

    /// Counts the pairs of which the cell that comes later is in a range.
    fn count_in(&self, cells: &Cells, range: Range<usize>, single: bool, counts: &mut [u64]) {
        let (squared, inverse_width) = (self.longest * self.longest, self.count as f64 / self.longest);
        let mut near = Vec::new();
        for cell in range {
            near.clear();
            cells.earlier(cell, squared, |places| near.push(places));
            for i in cells.places(cell) {
                let own = cells.starts[cell] as usize..i;
                for places in near.iter().cloned().chain([own]) {
                    for j in places {
                        let distance_squared = cells.distance_squared(i, j);
                        if distance_squared < squared {
                            // Rounding may bring a pair just within the longest distance to the end of the last bin.
                            let bin = ((distance_squared.sqrt() * inverse_width) as usize).min(self.count - 1);
                            let kind =
                                if single { 0 } else { PairTable::<()>::kind(cells.species[i], cells.species[j]) };
                            counts[usize::from(kind) * self.count + bin] += 1;
                        }
                    }
                }
            }
        }
    }
}

/// How many pairs each kind of pairs of species has, N_α N_β or N_α (N_α − 1)/2, in the order of [`PairTable`].
pub fn pairs_of_species(counts: &[usize]) -> Vec<f64> {
    let pairs = |a: usize, b: usize| {
        let (first, second) = (counts[a] as f64, counts[b] as f64);
        if a == b { 0.5 * first * (first - 1.0) } else { first * second }
    };
    PairTable::from_fn(counts.len(), pairs).entries().to_vec()
}

/// The particles sorted by cell.
struct Cells {
    sides: Vector,
    /// Cells along each axis.
    count: [usize; 3],
    /// How many cells away, along each axis, a particle within the longest distance may be.
    reach: [usize; 3],
    /// Where each cell begins.
    starts: Vec<u32>,
    position: Vec<Vector>,
    species: Vec<u8>,
}

impl Cells {
    fn new(particles: &Particles, region: &PeriodicBox, longest: f64) -> Self {
        let (sides, number) = (region.sides(), particles.count());
        let edge = (longest / CELLS_PER_DISTANCE).max((PARTICLES_PER_CELL * region.volume() / number as f64).cbrt());
        let count = sides.map(|side| (side / edge).max(1.0) as usize);
        // A whisker more, so that rounding at a cell's edge loses no pair.
        let reach =
            std::array::from_fn(|axis| ((1.0 + 1e-12) * longest * count[axis] as f64 / sides[axis]).ceil() as usize);
        let wrapped = |position: &Vector| {
            let mut position = *position;
            region.wrap(&mut position, &mut [0; 3]);
            position
        };
        let cell_of = |position: &Vector| {
            let place =
                |axis: usize| ((position[axis] / sides[axis] * count[axis] as f64) as usize).min(count[axis] - 1);
            (place(2) * count[1] + place(1)) * count[0] + place(0)
        };
        let positions: Vec<Vector> = particles.position.iter().map(wrapped).collect();
        let mut starts = vec![0u32; count.iter().product::<usize>() + 1];
        positions.iter().for_each(|position| starts[cell_of(position) + 1] += 1);
        (1..starts.len()).for_each(|cell| starts[cell] += starts[cell - 1]);
        let mut next = starts.clone();
        let (mut position, mut species) = (vec![ZERO; number], vec![0; number]);
        for (k, sorted) in positions.iter().enumerate() {
            let place = &mut next[cell_of(sorted)];
            (position[*place as usize], species[*place as usize]) = (*sorted, particles.species[k]);
            *place += 1;
        }
        Self { sides, count, reach, starts, position, species }
    }

    fn places(&self, cell: usize) -> Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    /// Calls `visit` with the places of every cell before this one whose particles may be nearer than the longest distance, once each.
    fn earlier(&self, cell: usize, squared: f64, mut visit: impl FnMut(Range<usize>)) {
        let own = [cell % self.count[0], cell / self.count[0] % self.count[1], cell / self.count[0] / self.count[1]];
        // The near cells along an axis, each once, with the square of the gap between them and this one.
        let near = |axis: usize| {
            let (count, reach) = (self.count[axis], self.reach[axis]);
            let cells = if 2 * reach + 1 >= count {
                0..count
            } else {
                own[axis] + count - reach..own[axis] + count + reach + 1
            };
            cells.map(move |place| {
                let place = place % count;
                let apart = place.abs_diff(own[axis]);
                let gap = apart.min(count - apart).saturating_sub(1) as f64 * self.sides[axis] / count as f64;
                (place, (1.0 - 1e-12) * gap * gap)
            })
        };
        for (z, gap_z) in near(2) {
            for (y, gap_y) in near(1) {
                for (x, gap_x) in near(0) {
                    let other = (z * self.count[1] + y) * self.count[0] + x;
                    if other < cell && gap_x + gap_y + gap_z < squared {
                        visit(self.places(other));
                    }
                }
            }
        }
    }

    /// The squared distance of the nearest images of two particles inside the box.
    #[inline(always)]
    fn distance_squared(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (&self.position[i], &self.position[j]);
        let along = |axis: usize| {
            let apart = (a[axis] - b[axis]).abs();
            apart.min(self.sides[axis] - apart)
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        x * x + y * y + z * z
    }
}
