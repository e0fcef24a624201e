//! The list against all pairs in all images, on random states of random shapes.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn random_particles(count: usize, sides: Vector, seed: u64) -> Particles {
    let draw = crate::noise::NoiseKey::new(&[seed]).draw(crate::noise::Purpose::Start, 0, 0);
    let positions = (0..count as u64)
        .map(|id| std::array::from_fn(|axis| sides[axis] * (3.0 * draw.uniform(id, axis as u64) - 1.0)));
    Particles::at_rest(positions.collect(), vec![0; count], &[1.0])
}

/// Every pair within the radius, with its image, by brute force.
fn all_pairs(particles: &Particles, region: &PeriodicBox, radius: f64) -> BTreeSet<(u64, u64)> {
    let mut found = BTreeSet::new();
    for i in 0..particles.count() {
        for j in 0..i {
            let d = subtract(particles.position[i], particles.position[j]);
            let nearest: f64 = (0..3)
                .map(|axis| {
                    let side = region.sides()[axis];
                    (d[axis] - side * (d[axis] / side).round()).powi(2)
                })
                .sum();
            if nearest < radius * radius {
                found.insert((particles.id[i].min(particles.id[j]), particles.id[i].max(particles.id[j])));
            }
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn lists_exactly_the_pairs_within_the_radius(
        sides in [2.6..9.0f64, 2.6..9.0f64, 2.6..20.0f64], count in 2usize..200, seed: u64,
    ) {
        let region = PeriodicBox::new(sides).unwrap();
        let mut particles = random_particles(count, sides, seed);
        let mut list = NeighborList::new(&region, 1.0, 0.3, 200).unwrap();
        list.build(&mut particles, &region, None, Workers::One);
        let expected = all_pairs(&particles, &region, 1.3);
        let mut found = BTreeSet::new();
        for brick in list.bricks() {
            for pair in &brick.listed {
                let (i, j) = (pair.first as usize, pair.second as usize);
                let ids = (particles.id[i].min(particles.id[j]), particles.id[i].max(particles.id[j]));
                prop_assert!(found.insert(ids), "pair {ids:?} is listed twice");
                let offset = list.offsets[usize::from(pair.image)];
                let d = subtract(particles.position[i], particles.position[j]);
                let d: Vector = std::array::from_fn(|axis| d[axis] + offset[axis]);
                prop_assert!(dot(d, d) < 1.3 * 1.3);
            }
        }
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn bricks_of_one_color_share_no_particle(sides in [2.6..16.0f64, 2.6..16.0f64, 2.6..16.0f64], seed: u64) {
        let region = PeriodicBox::new(sides).unwrap();
        let mut particles = random_particles(300, sides, seed);
        let mut list = NeighborList::new(&region, 1.0, 0.3, 200).unwrap();
        list.build(&mut particles, &region, None, Workers::One);
        for color in 0..8 {
            let mut owner = vec![None; 300];
            for brick in &list.bricks[list.color_starts[color]..list.color_starts[color + 1]] {
                for place in brick.listed.iter().flat_map(|pair| [pair.first, pair.second]) {
                    let owner = &mut owner[place as usize];
                    prop_assert!(owner.is_none() || *owner == Some(brick.coordinates));
                    *owner = Some(brick.coordinates);
                }
            }
        }
    }

    #[test]
    fn the_order_does_not_depend_on_the_storage(seed: u64) {
        let region = PeriodicBox::new([6.0, 5.0, 7.0]).unwrap();
        let ids = |shuffled: bool| {
            let mut particles = random_particles(150, region.sides(), seed);
            if shuffled {
                particles.reorder(&(0..150).map(|k| k * 77 % 150).collect::<Vec<_>>());
            }
            let mut list = NeighborList::new(&region, 1.0, 0.3, 200).unwrap();
            list.build(&mut particles, &region, None, Workers::One);
            list.bricks.iter().flat_map(|brick| &brick.listed)
                .map(|pair| (particles.id[pair.first as usize], particles.id[pair.second as usize]))
                .collect::<Vec<_>>()
        };
        prop_assert_eq!(ids(false), ids(true));
    }
}

#[test]
fn boxes_below_twice_the_list_radius_are_refused_with_the_smallest_legal_side() {
    let region = PeriodicBox::new([5.0, 2.59, 5.0]).unwrap();
    let error = NeighborList::new(&region, 1.0, 0.3, 200).unwrap_err();
    assert_eq!(error, NeighborError::BoxTooSmall { side: 2.59, smallest: 2.6, cutoff: 1.0, skin: 0.3 });
    let legal = PeriodicBox::new([5.0, 2.6, 5.0]).unwrap();
    assert!(NeighborList::new(&legal, 1.0, 0.3, 200).is_ok());
}

#[test]
fn a_nearly_empty_box_needs_little_memory() {
    let region = PeriodicBox::new([1e6, 1e6, 1e4]).unwrap();
    let list = NeighborList::new(&region, 1.0, 0.3, 10).unwrap();
    assert!(list.grid.cell_count() < 1000, "{} cells", list.grid.cell_count());
}
