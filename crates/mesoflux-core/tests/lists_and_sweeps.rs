//! The upkeep of lists and the direction of sweeps, over many steps.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::Fluid;
use common::naive::Naive;
use mesoflux_core::integrate::{Schedule, SweepOrder, Thermostat};
use mesoflux_core::noise::NoiseKey;
use std::collections::BTreeSet;

/// Fast particles in nearly free flight and a wide skin: many pairs meet on the day before the list is renewed.
#[test]
fn no_pair_is_missed_however_long_a_list_is_kept() {
    let fluid = Fluid { skin: 0.9, ..Fluid::ideal(1029, 0.1) };
    let mut simulation = fluid.simulation("ABOBA", None, NoiseKey::new(&[1]), 0.01);
    let steps = 400;
    for step in 0..steps {
        simulation.step().unwrap();
        let system = &mut simulation.system;
        let id = system.particles.id.clone();
        let mut found = BTreeSet::new();
        let cutoff = system.interactions.cutoff();
        let (positions, region) = (system.particles.position.clone(), system.region);
        for contacts in system.contacts().contacts() {
            for k in (0..contacts.count()).filter(|&k| contacts.separation(k, &positions, &region).0 < cutoff) {
                let [i, j] = contacts.pair(k).map(|place| id[place] as usize);
                found.insert((i.min(j), i.max(j)));
            }
        }
        let expected: BTreeSet<_> = Naive::of(system).pairs().into_iter().collect();
        let missed: Vec<_> = expected.symmetric_difference(&found).collect();
        assert!(missed.is_empty(), "step {step}: pairs {missed:?} are missed, or listed too far apart");
    }
    let builds = simulation.system.list().builds();
    assert!((20..steps / 5).contains(&builds), "{builds} lists in {steps} steps: each must live for some time");
}

#[test]
fn alternating_sweeps_go_backward_at_odd_steps() {
    let schedule = |order| Schedule::new("ABOBA", Thermostat::PairOrnsteinUhlenbeck, 1.0, order).unwrap();
    let (alternating, forward) = (schedule(SweepOrder::Alternating), schedule(SweepOrder::Forward));
    assert_eq!([0, 1, 2, 3].map(|step| alternating.backward(step)), [false, true, false, true]);
    assert_eq!([0, 1, 2, 3].map(|step| forward.backward(step)), [false; 4]);
}
