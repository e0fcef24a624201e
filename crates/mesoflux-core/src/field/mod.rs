//! External fields: what acts on single particles by their place in the box. They break the conservation of momentum.

pub mod expression;

use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::elementary::wrapped;
use crate::lanes::{BlockNumbers, Row, WIDTH};
use crate::pair::PairSums;
use crate::state::Particles;
use crate::vector::{Vector, ZERO, add_scaled};
use expression::ExpressionField;

/// A field and whom it acts on.
#[derive(Debug, Clone)]
pub struct Field {
    /// What it does.
    pub law: ExpressionField,
    /// For each species whether it feels the field.
    pub felt_by: Vec<bool>,
}

/// All fields of a system.
#[derive(Debug, Clone, Default)]
pub struct Fields(Vec<Field>);

/// Particles whose forces are worked out together.
const BLOCK: usize = WIDTH * WIDTH;

impl From<Vec<Field>> for Fields {
    fn from(fields: Vec<Field>) -> Self {
        Self(fields)
    }
}

impl Fields {
    /// Along which axes no field pushes, so that the total momentum is conserved.
    pub fn conserved(&self) -> [bool; 3] {
        let pushes = |axis: usize| self.0.iter().any(|field| field.law.pushes()[axis] && field.felt_by.contains(&true));
        std::array::from_fn(|axis| !pushes(axis))
    }

    /// Adds −∇u for every particle that feels a field.
    pub(crate) fn add_forces(&self, particles: &Particles, region: &PeriodicBox, force: &mut [Row], workers: Workers) {
        for Field { law, felt_by } in &self.0 {
            workers.for_each_chunk(force, |offset, rows| {
                let feels = |k: &usize| felt_by[usize::from(particles.species[offset + k])];
                let mut touched = (0..rows.len()).filter(feels);
                let (mut places, mut forces) = ([BlockNumbers::default(); 3], [BlockNumbers::default(); 3]);
                loop {
                    let mut block = [0; BLOCK];
                    let mut count = 0;
                    for k in touched.by_ref().take(BLOCK) {
                        let place = in_box(particles.position[offset + k], region);
                        for axis in 0..3 {
                            places[axis][count / WIDTH][count % WIDTH] = place[axis];
                        }
                        block[count] = k;
                        count += 1;
                    }
                    if count == 0 {
                        break;
                    }
                    law.fill(count.div_ceil(WIDTH), &places, &mut forces);
                    for (entry, &k) in block[..count].iter().enumerate() {
                        let mut sum = rows[k].vector();
                        let push = forces.each_ref().map(|force| force[entry / WIDTH][entry % WIDTH]);
                        add_scaled(&mut sum, 1.0, push);
                        rows[k] = Row::new(sum, 0.0);
                    }
                }
            });
        }
    }

    /// Energy and Laplacian of all particles in the fields; a field has no virial.
    pub(crate) fn sums(&self, particles: &Particles, region: &PeriodicBox, workers: Workers) -> PairSums {
        let mut sums = PairSums::default();
        for Field { law, felt_by } in &self.0 {
            let over = |term: &(dyn Fn(&Vector) -> f64 + Sync)| {
                workers.sum(particles.count(), |k| {
                    let feels = felt_by[usize::from(particles.species[k])];
                    if feels { term(&in_box(particles.position[k], region)) } else { 0.0 }
                })
            };
            sums.potential_energy += over(&|place| law.energy(place));
            sums.laplacian += over(&|place| law.laplacian(place));
        }
        sums
    }
}

/// Where in the box a particle is; between two sortings some have left it a little.
fn in_box(position: Vector, region: &PeriodicBox) -> Vector {
    let mut place = ZERO;
    for axis in 0..3 {
        place[axis] = wrapped(position[axis], region.sides()[axis]);
    }
    place
}
