//! Packing pairs into blocks that share no particle, so that the pairs of a block can be worked on at the same time.

use super::ListedPair;

/// Pairs in a block.
const WIDTH: u32 = 8;

/// Scratch space of the packing, for one brick after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks {
    /// For each particle the first block that comes after all that hold a pair of it; zero between bricks.
    free: Vec<u32>,
    /// Pairs in each block; then where each block begins.
    filled: Vec<u32>,
    /// From a full block toward the next one that isn't.
    next: Vec<u32>,
    block: Vec<u32>,
}

impl Blocks {
    /// Reorders pairs so that each run of `WIDTH` touches as few particles twice as possible; the result depends on their order alone.
    ///
    /// Every pair goes, in turn, into the first block that has room and comes after all blocks with one of its particles: two
    /// pairs with a common particle keep their order.
    pub(super) fn pack(&mut self, pairs: &mut Vec<ListedPair>, particles: usize) {
        self.free.resize(particles, 0);
        self.filled.clear();
        self.next.clear();
        self.block.clear();
        for pair in pairs.iter() {
            let (i, j) = (pair.first as usize, pair.second as usize);
            let block = self.roomy(self.free[i].max(self.free[j]));
            self.filled[block as usize] += 1;
            self.block.push(block);
            self.free[i] = block + 1;
            self.free[j] = block + 1;
        }
        let mut start = 0;
        for filled in &mut self.filled {
            (start, *filled) = (start + *filled, start);
        }
        let mut packed = pairs.clone();
        for (pair, &block) in pairs.iter().zip(&self.block) {
            let place = &mut self.filled[block as usize];
            packed[*place as usize] = *pair;
            *place += 1;
        }
        *pairs = packed;
        // Only what this brick touched is cleared: the column is as long as there are particles.
        for pair in pairs.iter() {
            self.free[pair.first as usize] = 0;
            self.free[pair.second as usize] = 0;
        }
    }

    /// The first block from `block` on that has room; shortens the way there for those who come after.
    fn roomy(&mut self, block: u32) -> u32 {
        let mut end = block;
        loop {
            while self.filled.len() <= end as usize {
                self.next.push(self.filled.len() as u32);
                self.filled.push(0);
            }
            if self.filled[end as usize] < WIDTH {
                break;
            }
            if self.next[end as usize] == end {
                self.next[end as usize] = end + 1;
            }
            end = self.next[end as usize];
        }
        let mut place = block;
        while place != end {
            place = std::mem::replace(&mut self.next[place as usize], end);
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{NoiseKey, Purpose};

    #[test]
    fn packing_keeps_all_pairs_and_the_order_of_those_that_share_a_particle() {
        let draw = NoiseKey::new(&[1]).draw(Purpose::Start, 0, 0);
        for (particles, count) in [(2, 1), (10, 30), (200, 3000)] {
            let pairs: Vec<ListedPair> = (0..count)
                .map(|k| {
                    let first = (draw.uniform(k, 0) * f64::from(particles)) as u32;
                    let second = (first + 1 + (draw.uniform(k, 1) * f64::from(particles - 1)) as u32) % particles;
                    // The image serves as a mark of the pair's place.
                    ListedPair { first, second, image: (k % 256) as u8, kind: 0 }
                })
                .collect();
            let mut packed = pairs.clone();
            Blocks::default().pack(&mut packed, particles as usize);
            assert_eq!(packed.len(), pairs.len());
            for particle in 0..particles {
                let of = |pairs: &[ListedPair]| -> Vec<ListedPair> {
                    pairs.iter().copied().filter(|pair| pair.first == particle || pair.second == particle).collect()
                };
                assert_eq!(of(&packed), of(&pairs), "pairs of particle {particle}");
            }
            if particles == 200 {
                let clash = |block: &&[ListedPair]| {
                    let mut seen: Vec<u32> = block.iter().flat_map(|pair| [pair.first, pair.second]).collect();
                    seen.sort_unstable();
                    seen.windows(2).any(|pair| pair[0] == pair[1])
                };
                assert_eq!(packed[..2800].chunks_exact(WIDTH as usize).filter(clash).count(), 0);
            }
        }
    }
}
