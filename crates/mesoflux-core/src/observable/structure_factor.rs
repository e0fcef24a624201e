//! The static structure factor S(k) = ⟨|ρ_k|²⟩/N at the smallest wave vectors of the box, ρ_k = Σ exp(−ik·r).

use crate::boundary::PeriodicBox;
use crate::domain::Workers;
use crate::elementary::cos_two_pi;
use crate::state::Particles;
use crate::vector::{Vector, dot};
use std::f64::consts::TAU;

/// Wave vectors of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// |k|.
    pub wave_number: f64,
    /// The waves that fit into the box along each axis; of k and −k, which see the same, one.
    pub waves: Vec<[i32; 3]>,
}

/// The shells of wave vectors of a box with 0 < |k| ≤ `largest`, the shortest first.
pub fn shells(region: &PeriodicBox, largest: f64) -> Vec<Shell> {
    let unit = region.sides().map(|side| TAU / side);
    // A whisker more, so that rounding leaves out no vector of the largest length itself.
    let largest = (1.0 + 1e-9) * largest;
    let most = unit.map(|unit| (largest / unit) as i32);
    let mut found: Vec<(f64, [i32; 3])> = Vec::new();
    for x in 0..=most[0] {
        for y in -most[1]..=most[1] {
            for z in -most[2]..=most[2] {
                let waves = [x, y, z];
                let k: Vector = std::array::from_fn(|axis| f64::from(waves[axis]) * unit[axis]);
                let length = dot(k, k).sqrt();
                if waves > [0; 3] && length <= largest {
                    found.push((length, waves));
                }
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut shells: Vec<Shell> = Vec::new();
    for (length, waves) in found {
        match shells.last_mut() {
            Some(shell) if length - shell.wave_number <= 1e-9 * length => shell.waves.push(waves),
            _ => shells.push(Shell { wave_number: length, waves: vec![waves] }),
        }
    }
    shells
}

/// |ρ_k|²/N at the present positions, averaged over the wave vectors of each shell.
pub fn structure_factors(particles: &Particles, region: &PeriodicBox, shells: &[Shell], workers: Workers) -> Vec<f64> {
    let (count, sides) = (particles.count(), region.sides());
    let most = |axis: usize| shells.iter().flat_map(|shell| &shell.waves).map(|waves| waves[axis].unsigned_abs()).max();
    // exp(−2πi n x/L) for n = 0, 1, … and every particle, along each axis.
    let powers: [Vec<Vec<Complex>>; 3] = std::array::from_fn(|axis| {
        let mut powers = vec![vec![[1.0, 0.0]; count]];
        let mut first = vec![[0.0; 2]; count];
        workers.for_each_chunk(&mut first, |offset, phases| {
            for (phase, position) in phases.iter_mut().zip(&particles.position[offset..]) {
                let turns = position[axis] / sides[axis];
                *phase = unit(turns - turns.floor());
            }
        });
        for n in 1..=most(axis).unwrap_or(0) as usize {
            let mut next = first.clone();
            workers.for_each_chunk(&mut next, |offset, phases| {
                phases
                    .iter_mut()
                    .zip(&powers[n - 1][offset..])
                    .for_each(|(phase, before)| *phase = product(*phase, *before));
            });
            powers.push(next);
        }
        powers
    });
    let density = |waves: &[i32; 3]| {
        let phase = |k: usize| {
            let along = |axis: usize| {
                let [re, im] = powers[axis][waves[axis].unsigned_abs() as usize][k];
                [re, if waves[axis] < 0 { -im } else { im }]
            };
            product(product(along(0), along(1)), along(2))
        };
        let parts = [workers.sum(count, |k| phase(k)[0]), workers.sum(count, |k| phase(k)[1])];
        parts[0] * parts[0] + parts[1] * parts[1]
    };
    let mean = |shell: &Shell| shell.waves.iter().map(density).sum::<f64>() / (shell.waves.len() * count) as f64;
    shells.iter().map(mean).collect()
}

/// Real and imaginary part.
type Complex = [f64; 2];

fn product(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// exp(−2πiu) for 0 ≤ u ≤ 1.
fn unit(u: f64) -> Complex {
    // −sin 2πu = cos 2π(u + ¼).
    let quarter_on = if u > 0.75 { u - 0.75 } else { u + 0.25 };
    [cos_two_pi(u), cos_two_pi(quarter_on)]
}
