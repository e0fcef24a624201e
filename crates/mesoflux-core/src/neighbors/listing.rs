//! Listing the pairs of one brick: near candidates picked out eight at a time, then dealt out in rounds.

use super::ListedPair;
use super::grid::{Grid, SeenCell};
use crate::boundary::Image;
use crate::pair::Kernel;
use crate::vector::Vector;
use std::ops::Range;

/// Candidates that are looked at together.
const LANES: usize = 8;

/// Coordinates by axis in storage order, so that consecutive particles can be loaded at once.
#[derive(Debug, Clone, Default)]
pub(super) struct Coordinates {
    axes: [Vec<f64>; 3],
}

impl Coordinates {
    /// Takes over positions. What follows the last one is near to nobody.
    pub(super) fn update(&mut self, positions: &[Vector]) {
        for (axis, column) in self.axes.iter_mut().enumerate() {
            column.clear();
            column.extend(positions.iter().map(|position| position[axis]));
            column.resize(positions.len() + LANES, f64::NAN);
        }
    }

    /// Positions `start` to `start + LANES`.
    #[inline(always)]
    fn lanes(&self, start: usize) -> [&[f64; LANES]; 3] {
        let lanes = |axis: usize| -> &[f64; LANES] {
            let column: &[f64] = &self.axes[axis][start..start + LANES];
            column.first_chunk().unwrap_or(&[f64::NAN; LANES])
        };
        [lanes(0), lanes(1), lanes(2)]
    }
}

/// Consecutive pairs in the list of candidates that share their first particle and their image.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: u32,
    /// The place of the first particle among those that the brick sees.
    seen: u32,
    count: u32,
    image: Image,
}

/// Scratch space, for one brick after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    region: Vec<SeenCell>,
    /// For each of these cells, how many particles the brick sees in those before it.
    seen: Vec<u32>,
    /// The second particles of the pairs found, run after run.
    seconds: Vec<u32>,
    runs: Vec<Run>,
    /// How many pairs of each seen particle are dealt out already.
    dealt: Vec<u32>,
    /// For each round, where its next pair goes.
    next: Vec<u32>,
}

/// Lists the pairs of one brick.
pub(super) struct Listing<'a> {
    pub grid: &'a Grid,
    pub brick: [usize; 3],
    pub starts: &'a [u32],
    pub coordinates: &'a Coordinates,
    pub offsets: &'a [Vector; 27],
    pub radius_squared: f64,
    pub scratch: &'a mut Scratch,
    pub listed: &'a mut Vec<ListedPair>,
}

impl Kernel for Listing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { grid, brick, starts, coordinates, offsets, radius_squared, scratch, listed } = self;
        scratch.seconds.clear();
        scratch.runs.clear();
        let mut found = 0;
        grid.region(brick, &mut scratch.region);
        scratch.seen.clear();
        let mut particles = 0;
        for cell in &scratch.region {
            scratch.seen.push(particles);
            particles += starts[cell.cell + 1] - starts[cell.cell];
        }
        for &[here, there] in grid.cell_pairs() {
            let itself = here == there;
            let seen = scratch.seen[here as usize];
            let (here, there) = (scratch.region[here as usize], scratch.region[there as usize]);
            let (mine, theirs) = (starts[here.cell]..starts[here.cell + 1], starts[there.cell]..starts[there.cell + 1]);
            let image = here.image_to(&there);
            let offset = offsets[usize::from(image)];
            let most = found + mine.len() * (theirs.len() + LANES);
            if scratch.seconds.len() < most {
                scratch.seconds.resize(most, 0);
            }
            for first in mine.clone() {
                let from = if itself { first + 1 } else { theirs.start };
                let [x, y, z] = coordinates.lanes(first as usize).map(|lanes| lanes[0]);
                let position = [x + offset[0], y + offset[1], z + offset[2]];
                let before = found;
                found = near(coordinates, position, from..theirs.end, radius_squared, &mut scratch.seconds, found);
                if found > before {
                    let seen = seen + (first - mine.start);
                    scratch.runs.push(Run { first, seen, count: (found - before) as u32, image });
                }
            }
        }
        scratch.seconds.truncate(found);
        scratch.deal(particles as usize, listed);
    }
}

/// Writes those of a range of particles that are within the radius of a position to `seconds`, from `count` on; returns where
/// they end.
#[inline(always)]
fn near(
    coordinates: &Coordinates,
    position: Vector,
    range: Range<u32>,
    radius_squared: f64,
    seconds: &mut [u32],
    mut count: usize,
) -> usize {
    let mut start = range.start;
    while start < range.end {
        let [x, y, z] = coordinates.lanes(start as usize);
        let mut mask = 0u32;
        for lane in 0..LANES {
            let d = [position[0] - x[lane], position[1] - y[lane], position[2] - z[lane]];
            let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            mask |= u32::from(squared < radius_squared) << lane;
        }
        let left = range.end - start;
        if left < LANES as u32 {
            mask &= (1 << left) - 1;
        }
        let order = &SET_LANES[mask as usize];
        if let Some(place) = seconds.get_mut(count..count + LANES) {
            for lane in 0..LANES {
                place[lane] = start + u32::from(order[lane]);
            }
        }
        count += mask.count_ones() as usize;
        start += LANES as u32;
    }
    count
}

/// For each set of lanes the lanes that are in it, in order.
static SET_LANES: [[u8; LANES]; 256] = {
    let mut table = [[0; LANES]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

impl Scratch {
    /// Deals the pairs out in rounds: the first pair that each particle came first in, then everybody's second, and so on.
    ///
    /// Neighbors in the list then seldom share a particle, so that the processor can work on several pairs at a time. The order
    /// follows from the order in which the pairs were found alone; pairs with the same first particle keep theirs.
    #[inline(always)]
    fn deal(&mut self, particles: usize, listed: &mut Vec<ListedPair>) {
        self.dealt.clear();
        self.dealt.resize(particles, 0);
        self.next.clear();
        for run in &self.runs {
            let dealt = &mut self.dealt[run.seen as usize];
            let rounds = (*dealt + run.count) as usize;
            if self.next.len() < rounds {
                self.next.resize(rounds, 0);
            }
            self.next[*dealt as usize..rounds].iter_mut().for_each(|count| *count += 1);
            *dealt += run.count;
        }
        let mut start = 0;
        for next in &mut self.next {
            (start, *next) = (start + *next, start);
        }
        self.dealt.fill(0);
        listed.clear();
        if listed.capacity() < self.seconds.len() {
            // A little room for the next list, but no doubling: lists are most of what a simulation holds.
            listed.reserve_exact(self.seconds.len() + self.seconds.len() / 8);
        }
        listed.resize(self.seconds.len(), ListedPair { first: 0, second: 0, image: 0, kind: 0 });
        let mut seconds = self.seconds.iter();
        for &Run { first, seen, count, image } in &self.runs {
            let dealt = &mut self.dealt[seen as usize];
            let rounds = &mut self.next[*dealt as usize..(*dealt + count) as usize];
            for (next, &second) in rounds.iter_mut().zip(&mut seconds) {
                listed[*next as usize] = ListedPair { first, second, image, kind: 0 };
                *next += 1;
            }
            *dealt += count;
        }
    }
}
