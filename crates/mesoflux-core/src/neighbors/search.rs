//! Finding the contacts of one brick: sixteen candidates at a time, row by row.

use super::grid::{Grid, ROW_PAIRS};
use super::rows::{CLUSTER, Columns, SearchRow};
use crate::boundary::PeriodicBox;
use crate::lanes::{Candidates, Kernel, Lanes, SEARCH_WIDTH};
use crate::pair::Contacts;

/// Finds the contacts of one brick in the order in which the sweep counts them: row by row, each with its near rows, four
/// particles at a time.
pub struct Search<'a> {
    pub grid: &'a Grid,
    pub region: &'a PeriodicBox,
    pub rows: &'a [SearchRow],
    pub brick: [usize; 2],
    pub squared: f32,
    pub contacts: &'a mut Contacts,
}

impl Kernel for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { grid, region, rows, brick, squared, contacts } = self;
        let sides = [1, 2].map(|k| region.sides()[grid.axes[k]]);
        let mut count = 0;
        for coordinates in grid.rows_of(brick) {
            for [here, there] in ROW_PAIRS {
                let itself = here == there;
                let (here, there) = (grid.seen(coordinates, here), grid.seen(coordinates, there));
                let shift: [f32; 2] =
                    std::array::from_fn(|k| (f64::from(here.copies[k] - there.copies[k]) * sides[k]) as f32);
                let near =
                    NearRows { grid, here: rows[here.row].columns(), there: rows[there.row].columns(), shift, squared };
                count = if itself {
                    near.search::<L, true>(contacts, count)
                } else {
                    near.search::<L, false>(contacts, count)
                };
            }
        }
        contacts.finish(count);
    }
}

/// Two rows near to each other, or a row and itself.
struct NearRows<'a> {
    grid: &'a Grid,
    here: Columns<'a>,
    there: Columns<'a>,
    /// What to add to the coordinates across the rows of those here to compare them with those there.
    shift: [f32; 2],
    squared: f32,
}

impl NearRows<'_> {
    /// Writes the contacts from `count` on; returns where they end. In a row with itself the later particle is the second.
    #[inline(always)]
    fn search<L: Lanes, const ITSELF: bool>(&self, contacts: &mut Contacts, mut count: usize) -> usize {
        let Self { grid, here, there, shift, squared } = self;
        let own = here.own(grid);
        for start in own.clone().step_by(CLUSTER) {
            let members = CLUSTER.min(own.end - start);
            let window = here.window(start, start + members - 1, grid, there);
            let mut room = contacts.room(count + members * (window.len() + SEARCH_WIDTH));
            // Behind the last own entry there are others: a whole cluster can be read.
            let (places, points) = here.cluster(start, *shift);
            let mut candidate = if ITSELF { start + 1 } else { window.start };
            while candidate < window.end
                && let Some((names, coordinates)) = there.group(candidate)
            {
                let candidates = L::Candidates::load(names, coordinates);
                let inside = u32::MAX >> (32 - (window.end - candidate).min(SEARCH_WIDTH));
                for member in 0..CLUSTER {
                    if member < members {
                        let mut mask = candidates.near(points[member], *squared) & inside;
                        if ITSELF {
                            mask &= u32::MAX << (start + member + 1).saturating_sub(candidate).min(31);
                        }
                        count += room.append::<L>(count, places[member], &candidates, mask);
                    }
                }
                candidate += SEARCH_WIDTH;
            }
        }
        count
    }
}
