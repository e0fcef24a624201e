//! The pairs of a block in space.

use super::contacts::{Block, Contacts};
use crate::boundary::PeriodicBox;
use crate::elementary::{inverse_sqrt, nearest_integer};
use crate::lanes::{BlockNumbers, BlockOf, Lanes, Row, inner_product, scaled};

/// r, e and ids of a block's pairs at their nearest images.
#[derive(Debug, Clone, Default)]
pub(crate) struct Separations {
    /// r.
    pub distance: BlockNumbers,
    /// e = (r_first − r_second)/r by component; zero for coincident particles.
    pub direction: [BlockNumbers; 3],
    /// The bits of both particles' ids.
    pub ids: [BlockNumbers; 2],
    /// The places of both particles.
    pub places: [BlockOf<u32>; 2],
}

impl Separations {
    /// Works them out; `points` hold positions and ids.
    #[inline(always)]
    pub fn update<L: Lanes>(&mut self, contacts: &Contacts, block: &Block, points: &[Row], region: &PeriodicBox) {
        assert!(contacts.places_below() <= points.len(), "contacts of other particles");
        let sides = region.sides();
        let inverse = [1.0 / sides[0], 1.0 / sides[1], 1.0 / sides[2]];
        for s in 0..block.streams {
            let [first, second] = contacts.places(block.stream(s));
            (self.places[0][s], self.places[1][s]) = (*first, *second);
            // SAFETY: all places of the contacts are below the number of points.
            let (a, b) = unsafe { (L::load_rows(points.as_ptr(), first), L::load_rows(points.as_ptr(), second)) };
            let mut d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            for axis in 0..3 {
                let copies = nearest_integer(d[axis] * L::splat(inverse[axis]));
                d[axis] = (-copies).mul_add(L::splat(sides[axis]), d[axis]);
            }
            for axis in 0..3 {
                d[axis].store(&mut self.direction[axis][s]);
            }
            inner_product(d, d).store(&mut self.distance[s]);
            a[3].store(&mut self.ids[0][s]);
            b[3].store(&mut self.ids[1][s]);
        }
        for s in 0..block.streams {
            let squared = L::load(&self.distance[s]);
            let (zero, smallest) = (L::splat(0.0), L::splat(f64::MIN_POSITIVE));
            let inverse = L::select(smallest.below(squared), inverse_sqrt(squared), zero);
            (squared * inverse).store(&mut self.distance[s]);
            let e = scaled(inverse, self.direction(s));
            for axis in 0..3 {
                e[axis].store(&mut self.direction[axis][s]);
            }
        }
    }

    /// e of one stream's pairs.
    #[inline(always)]
    pub fn direction<L: Lanes>(&self, stream: usize) -> [L; 3] {
        let [x, y, z] = &self.direction;
        [L::load(&x[stream]), L::load(&y[stream]), L::load(&z[stream])]
    }
}
