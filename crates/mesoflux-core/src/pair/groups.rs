//! Contacts in groups that share no particle: what is done to one member doesn't matter to the others.

use super::contacts::{Block, Contacts};
use crate::lanes::WIDTH;
use std::ops::Range;

/// Rows of eight contacts in a group: a processor works on several chains at a time.
pub(super) const ROWS: usize = 2;

/// The most members of a group.
pub(super) const MEMBERS: usize = ROWS * WIDTH;

/// Contacts that are put into groups together: few enough that they stay in the nearest cache.
const PORTION: usize = 4096;

/// Particles are told apart by the last bits of their places. Those that have them in common are only kept apart more than needed.
const SLOTS: usize = 4096;

/// Contacts that are looked at in turn, from as many equal parts: neighbors in the list often share a particle.
const STREAMS: usize = 16;

/// A portion of a brick's contacts in groups of up to [`MEMBERS`].
///
/// Every contact goes to the first group with room that comes after all groups with one of its particles. So contacts that share a
/// particle are visited one after the other, and the groups follow from the contacts alone.
#[derive(Debug)]
pub(super) struct Groups {
    /// The contacts, group after group, each with room for all members; in the empty places the first stands once more.
    pub contacts: Contacts,
    sizes: [u8; PORTION + 1],
    /// One more than the latest group with a particle.
    latest: [u16; SLOTS],
    count: usize,
}

impl Default for Groups {
    fn default() -> Self {
        Self { contacts: Contacts::default(), sizes: [0; PORTION + 1], latest: [0; SLOTS], count: 0 }
    }
}

/// The contacts of a brick in portions, first to last or the other way round.
pub(super) fn portions(count: usize, backward: bool) -> impl Iterator<Item = Range<usize>> {
    let portions = count.div_ceil(PORTION);
    (0..portions).map(move |n| {
        let first = PORTION * if backward { portions - 1 - n } else { n };
        first..count.min(first + PORTION)
    })
}

impl Groups {
    /// Puts a portion of others' contacts into groups.
    ///
    /// A function of its own: as a part of a kernel it would have to share registers with it.
    #[inline(never)]
    pub fn arrange(&mut self, others: &Contacts, portion: Range<usize>) {
        let Self { contacts, sizes, latest, count } = self;
        contacts.room(portion.len() + portion.len() / 4);
        sizes.fill(0);
        latest.fill(0);
        *count = 0;
        let stride = portion.len() / STREAMS;
        let inner = (0..STREAMS * stride).map(|visit| visit % STREAMS * stride + visit / STREAMS);
        // The groups before this one are full.
        let mut open = 0;
        for contact in inner.chain(STREAMS * stride..portion.len()) {
            let contact = portion.start + contact;
            let [i, j] = others.pair(contact).map(|place| place % SLOTS);
            while usize::from(sizes[open]) == MEMBERS {
                open += 1;
            }
            let mut group = usize::from(latest[i].max(latest[j])).max(open);
            while usize::from(sizes[group]) == MEMBERS {
                group += 1;
            }
            let size = usize::from(sizes[group]);
            if size == 0 {
                contacts.begin_rows(group * ROWS..(group + 1) * ROWS, others, contact);
                *count = group + 1;
            }
            contacts.copy(group * MEMBERS + size, others, contact);
            sizes[group] += 1;
            (latest[i], latest[j]) = (group as u16 + 1, group as u16 + 1);
        }
        contacts.end_rows(*count * ROWS, others);
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// How many contacts a group has.
    #[inline(always)]
    pub fn size(&self, group: usize) -> usize {
        usize::from(self.sizes[group]).min(MEMBERS)
    }

    /// The block of some groups.
    #[inline(always)]
    pub fn block(groups: Range<usize>) -> Block {
        Block::of_rows(groups.start * ROWS..groups.end * ROWS)
    }

    /// The pairs of a group by their places.
    pub fn members(&self, group: usize) -> impl Iterator<Item = [usize; 2]> {
        (0..self.size(group)).map(move |member| self.contacts.pair(group * MEMBERS + member))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{NoiseKey, Purpose};

    #[test]
    fn every_contact_is_in_one_group_and_no_group_has_a_particle_twice() {
        let draw = NoiseKey::new(&[7]).draw(Purpose::Start, 0, 0);
        for (particles, count) in [(3, 1), (40, 100), (300, 5000), (100_000, 20_000)] {
            let place = |k: usize, end: u64| (draw.uniform(k as u64, end) * f64::from(particles)) as u32;
            let pairs = (0..count).map(|k| [place(k, 0), place(k, 1)]).filter(|[i, j]| i != j);
            let contacts = Contacts::of(&pairs.collect::<Vec<_>>());
            let mut all: Vec<[usize; 2]> = (0..contacts.count()).map(|k| contacts.pair(k)).collect();
            let (mut groups, mut visited, mut places) = (Groups::default(), Vec::new(), 0);
            for portion in portions(contacts.count(), false) {
                groups.arrange(&contacts, portion);
                places += groups.count() * MEMBERS;
                for group in 0..groups.count() {
                    let mut met: Vec<usize> = groups.members(group).flatten().collect();
                    met.sort_unstable();
                    met.dedup();
                    assert_eq!(met.len(), 2 * groups.size(group));
                    visited.extend(groups.members(group));
                }
            }
            all.sort_unstable();
            visited.sort_unstable();
            assert_eq!(visited, all);
            assert!(particles < 300 || 5 * places < 6 * all.len(), "{places} places for {} contacts", all.len());
        }
    }
}
