//! Finding the contacts of one brick: sixteen candidates at a time, row by row.

use super::grid::{Grid, ROW_PAIRS};
use super::rows::SearchRow;
use crate::boundary::PeriodicBox;
use crate::lanes::{Kernel, Lanes, SEARCH_WIDTH};
use crate::pair::Contacts;

/// Finds the contacts of one brick in the order in which the sweep counts them: row by row, each with its near rows, there
/// particle by particle in storage order.
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
                let (here, there) = (rows[here.row].columns(), rows[there.row].columns());
                for entry in here.own(grid) {
                    let (place, [x, y, z], window) = here.entry(entry, grid, &there);
                    let point = [x, y + shift[0], z + shift[1]];
                    let mut candidate = if itself { entry + 1 } else { window.start };
                    let [first, second] = contacts.room(count + window.len() + SEARCH_WIDTH);
                    while candidate < window.end
                        && let Some((places, others)) = there.group(candidate)
                        && let (Some(first), Some(second)) = (chunk(first, count), chunk(second, count))
                    {
                        let left = (window.end - candidate).min(SEARCH_WIDTH);
                        let mask = L::near(point, others, squared) & (u32::MAX >> (32 - left));
                        first.fill(place);
                        L::compress(mask, places, second);
                        count += mask.count_ones() as usize;
                        candidate += SEARCH_WIDTH;
                    }
                }
            }
        }
        contacts.finish(count);
    }
}

/// The entries of a column from one on that a search may write to at once.
#[inline(always)]
fn chunk(column: &mut [u32], from: usize) -> Option<&mut [u32; SEARCH_WIDTH]> {
    column.get_mut(from..)?.first_chunk_mut()
}
