//! The Gaussians of pairs alone, compiled for the instruction set that the engine's kernels use.

use mesoflux_core::noise::Draw;
use mesoflux_core::pair::InstructionSet;
use std::hint::black_box;

/// Pairs drawn at once, as the engine's kernels do.
const CHUNK: usize = 128;

/// Pairs of particles, given by their places in the column of ids.
pub struct Pairs {
    id: Vec<u64>,
    first: Vec<u32>,
    second: Vec<u32>,
}

impl Pairs {
    /// So many pairs of neighbors in storage.
    pub fn new(particles: usize, count: usize) -> Self {
        let place = |k: usize, step: usize| ((k / 6 + step * (1 + k % 6)) % particles) as u32;
        Self {
            id: (0..particles as u64).collect(),
            first: (0..count).map(|k| place(k, 0)).collect(),
            second: (0..count).map(|k| place(k, 1)).collect(),
        }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// Draws the Gaussian of every pair.
    pub fn draw(&self, draw: Draw) {
        match InstructionSet::detect() {
            InstructionSet::Portable => self.draw_portable(draw),
            // SAFETY: the set was detected on this machine.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe { self.draw_avx2(draw) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe { self.draw_avx512(draw) },
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn draw_avx2(&self, draw: Draw) {
        self.draw_portable(draw);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    fn draw_avx512(&self, draw: Draw) {
        self.draw_portable(draw);
    }

    #[inline(always)]
    fn draw_portable(&self, draw: Draw) {
        for (first, second) in self.first.chunks(CHUNK).zip(self.second.chunks(CHUNK)) {
            let gaussians: [f64; CHUNK] = draw.pair_gaussians(&self.id, first, second);
            black_box(&gaussians);
        }
    }
}
