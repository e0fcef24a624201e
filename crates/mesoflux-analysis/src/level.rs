//! One level of a blocking: sums, products and lag-one products of consecutive blocks of one length.

use serde::{Deserialize, Serialize};

/// Moments of the blocks y of one length, relative to a fixed shift so that a large mean costs no digits.
///
/// With c components, `products` and `lag_products` are symmetric c × c matrices of which the lower triangle is kept, row
/// by row: `Σ y_t y_tᵀ` over all blocks, and the symmetric part of `Σ y_t y_{t+1}ᵀ` over pairs of neighbors.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Level {
    /// Number of blocks, over all series.
    pub(crate) blocks: u64,
    /// Number of series (replicas) that reach this level; each has one pair of neighbors less than blocks.
    series: u64,
    sum: Vec<f64>,
    /// Sum of the first blocks of all series and of the last blocks of the finished (merged) ones.
    edges: Vec<f64>,
    products: Vec<f64>,
    lag_products: Vec<f64>,
    /// The latest block of the series being recorded; empty if there is none.
    last: Vec<f64>,
    /// Whether `last` waits for a partner to form a block of the next level.
    waiting: bool,
}

/// Moments of the scalar w·y at one level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarMoments {
    pub(crate) blocks: u64,
    pub(crate) pairs: u64,
    /// Σ (y − ȳ)² over blocks.
    pub(crate) squares: f64,
    /// `Σ (y_t − ȳ)(y_{t+1} − ȳ)` over pairs of neighbors within a series.
    pub(crate) lag_products: f64,
}

impl Level {
    pub(crate) fn new(components: usize) -> Self {
        let triangle = components * (components + 1) / 2;
        Self {
            blocks: 0,
            series: 0,
            sum: vec![0.0; components],
            edges: vec![0.0; components],
            products: vec![0.0; triangle],
            lag_products: vec![0.0; triangle],
            last: Vec::new(),
            waiting: false,
        }
    }

    /// Whether sums and counts fit together for this many components.
    pub(crate) fn is_consistent(&self, components: usize) -> bool {
        let triangle = components * (components + 1) / 2;
        // So many blocks as still are whole numbers; nobody records more.
        self.series <= self.blocks
            && self.blocks < 1 << f64::MANTISSA_DIGITS
            && self.sum.len() == components
            && self.edges.len() == components
            && self.products.len() == triangle
            && self.lag_products.len() == triangle
            && (self.last.is_empty() || self.last.len() == components)
    }

    /// Takes a block. If it completes a pair, leaves the pair's mean in `block` and returns true.
    pub(crate) fn push(&mut self, block: &mut Vec<f64>) -> bool {
        self.blocks += 1;
        add(&mut self.sum, block, 1.0);
        add_outer(&mut self.products, block, block, 1.0);
        if self.last.is_empty() {
            self.series += 1;
            add(&mut self.edges, block, 1.0);
            self.last.clone_from(block);
        } else {
            add_outer(&mut self.lag_products, &self.last, block, 1.0);
            std::mem::swap(&mut self.last, block);
        }
        self.waiting = !self.waiting;
        if self.waiting {
            return false;
        }
        for (earlier, later) in block.iter_mut().zip(&self.last) {
            *earlier = 0.5 * (*earlier + later);
        }
        true
    }

    /// Adds another series of blocks, whose shift is larger than this one's by `offset`. No pair spans the seam.
    pub(crate) fn merge(&mut self, other: &Self, offset: &[f64]) {
        let other_edges = other.all_edges();
        // With y = y' + offset: Σ y yᵀ = Σ y' y'ᵀ + Σ y' offsetᵀ + offset Σ y'ᵀ + n offset offsetᵀ, and alike for pairs.
        for (own, theirs) in self.products.iter_mut().zip(&other.products) {
            *own += theirs;
        }
        add_outer(&mut self.products, &other.sum, offset, 2.0);
        add_outer(&mut self.products, offset, offset, other.blocks as f64);
        for (own, theirs) in self.lag_products.iter_mut().zip(&other.lag_products) {
            *own += theirs;
        }
        add_outer(&mut self.lag_products, &other.sum, offset, 2.0);
        add_outer(&mut self.lag_products, &other_edges, offset, -1.0);
        add_outer(&mut self.lag_products, offset, offset, (other.blocks - other.series) as f64);
        add(&mut self.sum, &other.sum, 1.0);
        add(&mut self.sum, offset, other.blocks as f64);
        add(&mut self.edges, &other_edges, 1.0);
        add(&mut self.edges, offset, 2.0 * other.series as f64);
        self.blocks += other.blocks;
        self.series += other.series;
    }

    /// Mean block, relative to the shift.
    pub(crate) fn mean(&self) -> Vec<f64> {
        self.sum.iter().map(|sum| sum / self.blocks as f64).collect()
    }

    /// Moments of w·y about the mean of this level.
    pub(crate) fn project(&self, weights: &[f64]) -> ScalarMoments {
        let pairs = self.blocks - self.series;
        let sum = dot(&self.sum, weights);
        let edges = dot(&self.all_edges(), weights);
        let mean = sum / self.blocks as f64;
        let squares = quadratic_form(&self.products, weights) - sum * mean;
        ScalarMoments {
            blocks: self.blocks,
            pairs,
            // Rounding can leave a tiny negative number where the series is constant. (`max` would hide an overflow.)
            squares: if squares < 0.0 { 0.0 } else { squares },
            lag_products: quadratic_form(&self.lag_products, weights) - mean * (2.0 * sum - edges)
                + pairs as f64 * mean * mean,
        }
    }

    /// First and last blocks of all series, the one being recorded included, summed.
    fn all_edges(&self) -> Vec<f64> {
        let mut edges = self.edges.clone();
        add(&mut edges, &self.last, 1.0);
        edges
    }
}

fn add(target: &mut [f64], source: &[f64], factor: f64) {
    for (target, source) in target.iter_mut().zip(source) {
        *target += factor * source;
    }
}

/// Adds `factor` times the symmetric part of a bᵀ to a packed lower triangle.
fn add_outer(triangle: &mut [f64], a: &[f64], b: &[f64], factor: f64) {
    let mut rest = triangle;
    for i in 0..a.len() {
        let (row, tail) = rest.split_at_mut(i + 1);
        let (half_a, half_b) = (0.5 * factor * a[i], 0.5 * factor * b[i]);
        for ((entry, a_j), b_j) in row.iter_mut().zip(a).zip(b) {
            *entry += half_a * b_j + half_b * a_j;
        }
        rest = tail;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// wᵀ A w for a packed lower triangle of a symmetric A.
fn quadratic_form(triangle: &[f64], weights: &[f64]) -> f64 {
    let mut total = 0.0;
    let mut rest = triangle;
    for (i, weight) in weights.iter().enumerate() {
        let (row, tail) = rest.split_at(i + 1);
        // Each entry off the diagonal stands for two.
        total += weight * (2.0 * dot(&row[..i], weights) + row[i] * weight);
        rest = tail;
    }
    total
}
