//! The particles: one column for each quantity, in storage order.
//!
//! Storage follows the sweep order of the neighbor list and changes when the list is rebuilt; a particle is known by its id.

use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::tensor::{AXES, SymmetricTensor};
use crate::vector::{Vector, ZERO, dot};
use serde::{Deserialize, Serialize};

/// The state of all particles. Columns have equal length; entry k of every column belongs to the same particle.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Particles {
    /// Identity: 0 … N−1, once each.
    pub id: Vec<u64>,
    /// Index into the table of species.
    pub species: Vec<u8>,
    /// Position; inside the box when the list was built, wherever it has drifted to since.
    pub position: Vec<Vector>,
    /// How many box sides the particle has crossed along each axis, up to the last wrapping.
    pub crossings: Vec<[i32; 3]>,
    /// Momentum.
    pub momentum: Vec<Vector>,
    /// 1/m.
    pub inverse_mass: Vec<f64>,
    /// Further columns, registered by those who need them.
    pub columns: Vec<Vec<Vector>>,
}

/// Columns of more particles are not kept as spare ones.
const MOST_KEPT: usize = 4000;

/// Columns to write to when particles are put into another order.
#[derive(Debug, Clone, Default)]
pub(crate) struct SpareColumns {
    words: Vec<u64>,
    bytes: Vec<u8>,
    vectors: Vec<Vector>,
    integers: Vec<[i32; 3]>,
    numbers: Vec<f64>,
}

/// The name of a registered column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column(usize);

impl Column {
    /// Its place among the registered columns.
    pub(crate) fn index(self) -> usize {
        self.0
    }
}

impl Particles {
    /// Particles at rest at the given positions; `masses` by species.
    pub fn at_rest(positions: Vec<Vector>, species: Vec<u8>, masses: &[f64]) -> Self {
        let count = positions.len();
        Self {
            id: (0..count as u64).collect(),
            inverse_mass: species.iter().map(|&s| 1.0 / masses[usize::from(s)]).collect(),
            species,
            position: positions,
            crossings: vec![[0; 3]; count],
            momentum: vec![ZERO; count],
            columns: Vec::new(),
        }
    }

    /// N.
    pub fn count(&self) -> usize {
        self.id.len()
    }

    /// Adds a column of zeros that follows its particles through every reordering.
    pub fn register_column(&mut self) -> Column {
        self.columns.push(vec![ZERO; self.count()]);
        Column(self.columns.len() - 1)
    }

    /// A registered column.
    pub fn column(&self, column: Column) -> &[Vector] {
        &self.columns[column.0]
    }

    /// A registered column, for writing.
    pub fn column_mut(&mut self, column: Column) -> &mut Vec<Vector> {
        &mut self.columns[column.0]
    }

    /// v = p/m of the particle in place k.
    #[inline(always)]
    pub fn velocity(&self, k: usize) -> Vector {
        let (p, w) = (self.momentum[k], self.inverse_mass[k]);
        [p[0] * w, p[1] * w, p[2] * w]
    }

    /// Puts the particle that is now in place `order[k]` into place k.
    pub(crate) fn reorder(&mut self, order: &[u32], spare: &mut SpareColumns, workers: Workers) {
        fn permute<T: Copy + Default + Send + Sync>(
            column: &mut Vec<T>,
            order: &[u32],
            spare: &mut Vec<T>,
            workers: Workers,
        ) {
            spare.resize(column.len(), T::default());
            workers.for_each_chunk(spare, |offset, chunk| {
                for (entry, &k) in chunk.iter_mut().zip(&order[offset..]) {
                    *entry = column[k as usize];
                }
            });
            std::mem::swap(column, spare);
            // Room for so many particles costs more than finding it again.
            if order.len() > MOST_KEPT {
                *spare = Vec::new();
            }
        }
        permute(&mut self.id, order, &mut spare.words, workers);
        permute(&mut self.species, order, &mut spare.bytes, workers);
        permute(&mut self.position, order, &mut spare.vectors, workers);
        permute(&mut self.crossings, order, &mut spare.integers, workers);
        permute(&mut self.momentum, order, &mut spare.vectors, workers);
        permute(&mut self.inverse_mass, order, &mut spare.numbers, workers);
        for column in &mut self.columns {
            permute(column, order, &mut spare.vectors, workers);
        }
    }

    /// Twice the kinetic energy, Σ p²/m.
    pub fn twice_kinetic_energy(&self, workers: Workers) -> f64 {
        workers.sum(self.count(), |k| dot(self.momentum[k], self.momentum[k]) * self.inverse_mass[k])
    }

    /// Σ p_a p_b/m.
    pub fn kinetic_stress(&self, workers: Workers) -> SymmetricTensor {
        let term = |[a, b]: [usize; 2], k: usize| self.momentum[k][a] * self.momentum[k][b] * self.inverse_mass[k];
        SymmetricTensor(AXES.map(|axes| workers.sum(self.count(), |k| term(axes, k))))
    }

    /// Whether the columns fit together: equal lengths, every id once, known species, finite numbers.
    pub fn is_consistent(&self, species: usize) -> bool {
        let count = self.count();
        let mut seen = vec![false; count];
        let each_id_once = self.id.iter().all(|&id| {
            let place = seen.get_mut(id as usize);
            place.is_some_and(|seen| !std::mem::replace(seen, true))
        });
        let lengths = [
            self.species.len(),
            self.position.len(),
            self.crossings.len(),
            self.momentum.len(),
            self.inverse_mass.len(),
        ];
        let columns = [&self.position, &self.momentum].into_iter().chain(&self.columns);
        each_id_once
            && lengths.iter().all(|&length| length == count)
            && self.columns.iter().all(|column| column.len() == count)
            && self.species.iter().all(|&kind| usize::from(kind) < species)
            && self.inverse_mass.iter().all(|&w| w.is_finite() && w > 0.0)
            && columns.flatten().flatten().all(|number| number.is_finite())
    }

    /// Whether each id has the species and the mass that it has in `other`, whatever the order; both must be consistent.
    pub(crate) fn are_the_same_as(&self, other: &Self) -> bool {
        let mut known = vec![(0, 0.0); other.count()];
        for k in 0..other.count() {
            known[other.id[k] as usize] = (other.species[k], other.inverse_mass[k]);
        }
        (0..self.count()).all(|k| known[self.id[k] as usize] == (self.species[k], self.inverse_mass[k]))
    }

    /// Whether this column is registered.
    pub(crate) fn has_column(&self, column: Column) -> bool {
        column.0 < self.columns.len()
    }

    /// Σ p.
    pub fn total_momentum(&self, workers: Workers) -> Vector {
        std::array::from_fn(|axis| workers.sum(self.count(), |k| self.momentum[k][axis]))
    }

    /// Σ m.
    pub fn total_mass(&self, workers: Workers) -> f64 {
        workers.sum(self.count(), |k| 1.0 / self.inverse_mass[k])
    }

    /// Writes the positions, followed through all crossings, into a column ordered by id.
    pub fn unwrapped_positions(&self, region: &PeriodicBox, by_id: &mut Vec<Vector>) {
        by_id.clear();
        by_id.resize(self.count(), ZERO);
        for k in 0..self.count() {
            by_id[self.id[k] as usize] = region.unwrap(self.position[k], self.crossings[k]);
        }
    }
}
