//! The contacts against all pairs in all images, on random states of random shapes.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn random_particles(count: usize, sides: Vector, seed: u64) -> Particles {
    let draw = crate::noise::NoiseKey::new(&[seed]).draw(crate::noise::Purpose::Start, 0, 0);
    let positions = (0..count as u64)
        .map(|id| std::array::from_fn(|axis| sides[axis] * (3.0 * draw.uniform(id, axis as u64) - 1.0)));
    Particles::at_rest(positions.collect(), vec![0; count], &[1.0])
}

/// A list with its contacts, after everybody moved by less than half the skin along one of the diagonals.
fn moved_list(particles: &mut Particles, region: &PeriodicBox, skin: f64) -> NeighborList {
    let mut list = NeighborList::new(region, 1.0, skin, particles.count()).unwrap();
    list.build(particles, None, Workers::One);
    for (k, position) in particles.position.iter_mut().enumerate() {
        let step = if k % 2 == 0 { 0.288 } else { -0.288 };
        *position = position.map(|x| x + step * skin);
    }
    assert!(!list.is_spent(particles, Workers::One));
    list.update_contacts(particles, None, Workers::One);
    list
}

/// The ids of the contacts within a radius, none of which may stand twice in the list.
fn contacts_within(list: &NeighborList, particles: &Particles, radius: f64) -> BTreeSet<(u64, u64)> {
    let mut found = BTreeSet::new();
    for contacts in list.contacts() {
        let near = |&k: &usize| contacts.separation(k, &particles.position, list.region()).0 < radius;
        for k in (0..contacts.count()).filter(near) {
            let [a, b] = contacts.pair(k).map(|place| particles.id[place]);
            assert!(found.insert((a.min(b), a.max(b))), "the pair {a}, {b} is found twice");
        }
    }
    found
}

/// The ids of every pair within the radius, by brute force.
fn all_pairs(particles: &Particles, region: &PeriodicBox, radius: f64) -> BTreeSet<(u64, u64)> {
    let mut found = BTreeSet::new();
    for i in 0..particles.count() {
        for j in 0..i {
            let d = region.nearest_image(subtract(particles.position[i], particles.position[j]));
            if dot(d, d) < radius * radius {
                found.insert((particles.id[i].min(particles.id[j]), particles.id[i].max(particles.id[j])));
            }
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn finds_exactly_the_pairs_within_the_cutoff(
        sides in [2.6..9.0f64, 2.6..9.0f64, 2.6..20.0f64], count in 2usize..400, skin in 0.01..0.3f64, seed: u64,
    ) {
        let region = PeriodicBox::new(sides).unwrap();
        let mut particles = random_particles(count, sides, seed);
        let list = moved_list(&mut particles, &region, skin);
        let mut found = BTreeSet::new();
        for contacts in list.contacts() {
            for k in 0..contacts.count() {
                let (r, _) = contacts.separation(k, &particles.position, &region);
                prop_assert!(r < 1.001 + if skin <= THIN { 2.0 * skin } else { 0.0 }, "a pair at {r} is no neighbor");
                let [a, b] = contacts.pair(k).map(|place| particles.id[place]);
                prop_assert!(r >= 1.0 || found.insert((a.min(b), a.max(b))), "the pair {a}, {b} is found twice");
            }
        }
        prop_assert_eq!(found, all_pairs(&particles, &region, 1.0));
    }

    #[test]
    fn bricks_of_one_color_share_no_particle(sides in [2.6..16.0f64, 2.6..16.0f64, 2.6..16.0f64], seed: u64) {
        let region = PeriodicBox::new(sides).unwrap();
        let mut particles = random_particles(1000, sides, seed);
        let list = moved_list(&mut particles, &region, 0.3);
        for color in 0..4 {
            let mut owner = vec![None; 1000];
            for brick in &list.bricks[list.color_starts[color]..list.color_starts[color + 1]] {
                for place in (0..brick.contacts.count()).flat_map(|k| brick.contacts.pair(k)) {
                    let owner = &mut owner[place];
                    prop_assert!(owner.is_none() || *owner == Some(brick.coordinates));
                    *owner = Some(brick.coordinates);
                }
            }
        }
    }

    #[test]
    fn a_sweep_visits_every_contact_once_in_either_direction(count in 0usize..300) {
        let contacts = Contacts::of(&vec![[0, 1]; count]);
        let order: Vec<usize> = contacts.in_order().collect();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        prop_assert_eq!(sorted, (0..count).collect::<Vec<_>>());
        let length = count / 8;
        for (n, &k) in order.iter().enumerate() {
            prop_assert_eq!(k, if n < 8 * length { n % 8 * length + n / 8 } else { n });
        }
    }
}

/// Particles on the faces, edges and corners of cells and of the box, and pairs as far apart as the cutoff: nobody is missed.
#[test]
fn particles_on_faces_of_cells_find_their_neighbors() {
    for (spacing, skin) in [(0.5, 0.3), (1.3, 0.3), (1.0, 0.3), (0.65, 0.3), (1.0, 0.25), (0.5, 0.02), (1.02, 0.02)] {
        let count = (5.2f64 / spacing).round() as usize;
        let side = count as f64 * spacing;
        let region = PeriodicBox::new([side; 3]).unwrap();
        let sites =
            (0..count.pow(3)).map(|k| [k % count, k / count % count, k / count / count].map(|c| c as f64 * spacing));
        let mut particles = Particles::at_rest(sites.collect(), vec![0; count.pow(3)], &[1.0]);
        let mut list = NeighborList::new(&region, 1.0, skin, particles.count()).unwrap();
        list.build(&mut particles, None, Workers::One);
        list.update_contacts(&particles, None, Workers::One);
        let found = contacts_within(&list, &particles, 1.0);
        assert_eq!(found, all_pairs(&particles, &region, 1.0), "spacing {spacing}");
    }
}

/// Far from the origin single precision is coarse: the search must take a radius that is larger by as much.
#[test]
fn pairs_just_within_the_cutoff_are_found_far_from_the_origin() {
    let sides = [5.0, 6.0, 2000.0];
    let region = PeriodicBox::new(sides).unwrap();
    let direction = [0.48, 0.6, 0.64].map(|e| (1.0 - 1e-9) * e);
    let firsts = random_particles(500, sides, 1).position;
    let sites = firsts.into_iter().flat_map(|a| [a, std::array::from_fn(|axis| a[axis] + direction[axis])]);
    let mut particles = Particles::at_rest(sites.collect(), vec![0; 1000], &[1.0]);
    let mut list = NeighborList::new(&region, 1.0, 0.3, 1000).unwrap();
    list.build(&mut particles, None, Workers::One);
    list.update_contacts(&particles, None, Workers::One);
    let found = contacts_within(&list, &particles, 1.0);
    let expected = all_pairs(&particles, &region, 1.0);
    assert!((0..500).all(|k| expected.contains(&(2 * k, 2 * k + 1))), "the pairs are within the cutoff");
    assert_eq!(found, expected);
}

#[test]
fn a_list_is_spent_when_two_particles_together_have_moved_by_the_skin() {
    let sides = [6.0; 3];
    let region = PeriodicBox::new(sides).unwrap();
    for (first, second, spent) in [(0.49, 0.49, false), (0.6, 0.6, true), (0.0, 0.99, false), (1.01, 0.0, true)] {
        let mut particles = random_particles(100, sides, 1);
        let mut list = NeighborList::new(&region, 1.0, 0.3, 100).unwrap();
        list.build(&mut particles, None, Workers::One);
        particles.position[17][1] += 0.3 * first;
        particles.position[60][2] -= 0.3 * second;
        assert_eq!(list.is_spent(&particles, Workers::One), spent, "{first} and {second} of the skin");
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
    for sides in [[1e6, 1e6, 1e4], [3.0, 1e7, 1e7], [1e7, 3.0, 3.0], [1e9, 1e9, 1e9]] {
        let region = PeriodicBox::new(sides).unwrap();
        let mut particles = random_particles(10, sides, 1);
        let mut list = NeighborList::new(&region, 1.0, 0.3, 10).unwrap();
        assert!(list.grid.row_count() < 1000 && list.grid.cell_count() < 10_000, "{sides:?}: {:?}", list.grid);
        list.build(&mut particles, None, Workers::One);
        list.update_contacts(&particles, None, Workers::One);
    }
}
