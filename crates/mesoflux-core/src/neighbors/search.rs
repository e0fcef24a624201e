//! Finding the contacts of one brick: sixteen candidates at a time, row by row.

use super::grid::{Grid, ROW_PAIRS};
use super::packed::Packed;
use super::rows::{CLUSTER, Entries, SearchRow};
use crate::boundary::PeriodicBox;
use crate::lanes::{Candidates, Kernel, Lanes, SEARCH_WIDTH};
use crate::pair::Contacts;
use std::ops::Range;

/// Finds the contacts of one brick in the order in which the sweep counts them: row by row, each with its near rows, four
/// particles at a time. Of two different rows only those particles are looked at that are near to the other row.
pub struct Search<'a> {
    pub grid: &'a Grid,
    pub region: &'a PeriodicBox,
    pub rows: &'a [SearchRow],
    pub brick: [usize; 2],
    pub squared: f32,
    /// Room for the particles of two rows.
    pub packed: &'a mut [Packed; 2],
    pub contacts: &'a mut Contacts,
}

impl Kernel for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { grid, region, rows, brick, squared, packed: [members, candidates], contacts } = self;
        let sides = [1, 2].map(|k| region.sides()[grid.axes[k]]);
        let mut count = 0;
        for coordinates in grid.rows_of(brick) {
            for [here, there] in ROW_PAIRS {
                let itself = here == there;
                let (here, there) = (grid.seen(coordinates, here), grid.seen(coordinates, there));
                let shift: [f32; 2] =
                    std::array::from_fn(|k| (f64::from(here.copies[k] - there.copies[k]) * sides[k]) as f32);
                let (here, there) = (&rows[here.row], &rows[there.row]);
                if itself {
                    let (row, own) = (here.entries(), here.own(grid));
                    let near = Near { members: row, candidates: row, shift, squared };
                    for start in own.clone().step_by(CLUSTER) {
                        let end = own.end.min(start + CLUSTER);
                        let window = here.window(row.place[start], row.place[end - 1], grid, here);
                        count = near.search::<L, true>(start..end, start + 1..window.end, contacts, count);
                    }
                } else {
                    members.take::<L>(here, here.own(grid), &there.rectangle().shifted(shift.map(|x| -x)), squared);
                    candidates.take::<L>(there, there.all(), &here.rectangle().shifted(shift), squared);
                    let near = Near { members: members.entries(), candidates: candidates.entries(), shift, squared };
                    for start in (0..members.count()).step_by(CLUSTER) {
                        let end = members.count().min(start + CLUSTER);
                        let (first, last) = (near.members.place[start], near.members.place[end - 1]);
                        let window = here.window(first, last, grid, there);
                        let window = candidates.rank(window.start)..candidates.rank(window.end);
                        count = near.search::<L, false>(start..end, window, contacts, count);
                    }
                }
            }
        }
        contacts.finish(count);
    }
}

/// Particles of a row, and those of another or the same that they look at.
struct Near<'a> {
    members: Entries<'a>,
    candidates: Entries<'a>,
    /// What to add to the members' coordinates across the rows to compare them with the candidates.
    shift: [f32; 2],
    squared: f32,
}

impl Near<'_> {
    /// Writes the contacts of a cluster with the candidates in a window from `count` on; returns where they end. In a row with
    /// itself the later particle is the second.
    #[inline(always)]
    fn search<L: Lanes, const ITSELF: bool>(
        &self,
        cluster: Range<usize>,
        window: Range<usize>,
        contacts: &mut Contacts,
        mut count: usize,
    ) -> usize {
        let (places, points) = self.members.cluster(cluster.clone(), self.shift);
        let mut room = contacts.room(count + CLUSTER * (window.len() + SEARCH_WIDTH));
        let mut candidate = window.start;
        while candidate < window.end
            && let Some((names, coordinates)) = self.candidates.group(candidate)
        {
            let candidates = L::Candidates::load(names, coordinates);
            let inside = u32::MAX >> (32 - (window.end - candidate).min(SEARCH_WIDTH));
            for member in 0..CLUSTER {
                let mut mask = candidates.near(points[member], self.squared) & inside;
                if ITSELF {
                    mask &= u32::MAX << (cluster.start + member + 1).saturating_sub(candidate).min(31);
                }
                count += room.append::<L>(count, places[member], &candidates, mask);
            }
            candidate += SEARCH_WIDTH;
        }
        count
    }
}
