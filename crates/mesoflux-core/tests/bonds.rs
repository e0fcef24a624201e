//! Chains of beads in a solvent: the temperature, Boltzmann's distribution of the bond lengths, starts without broken bonds.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{advance, check_scores, friction, interactions, probit, replicas, splitting};
use mesoflux_analysis::Blocking;
use mesoflux_core::bond::{Bond, BondLaw, ExclusionRange, Topology};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::friction::Friction;
use mesoflux_core::noise::NoiseKey;
use mesoflux_core::potential::Potential;
use mesoflux_core::potential::fene::Fene;
use mesoflux_core::potential::harmonic::Harmonic;
use mesoflux_core::potential::soft::Soft;
use mesoflux_core::potential::wca::Wca;
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{Start, chain, check_overlaps, draw_momenta, positions, relax_overlaps};
use mesoflux_core::state::Particles;
use mesoflux_core::system::{SimulationError, System};

/// Chains in a solvent in a cubic box, solvent and beads being two species.
struct Solution {
    chains: usize,
    beads: usize,
    solvent: usize,
    density: f64,
    law: BondLaw,
    range: ExclusionRange,
    /// Between beads, between bead and solvent, between solvent particles.
    potentials: [Option<Potential>; 3],
}

const KREMER_GREST: Fene = Fene { stiffness: 30.0, longest: 1.5 };
const WCA: Potential = Potential::Wca(Wca { epsilon: 1.0, sigma: 1.0 });
const SOFT: Potential = Potential::Soft(Soft { repulsion: 25.0, cutoff: 1.0 });

impl Solution {
    fn system(&self, noise: NoiseKey) -> System {
        let count = self.chains * self.beads + self.solvent;
        let region = PeriodicBox::new([(count as f64 / self.density).cbrt(); 3]).unwrap();
        let length = self.law.most_likely_length(self.potentials[0].as_ref(), 1.0);
        let lengths = vec![length; self.beads - 1];
        let firsts = (0..self.chains).map(|k| (k * self.beads) as u64);
        let mut sites: Vec<_> = firsts.clone().flat_map(|first| chain(&lengths, first, &region, noise)).collect();
        sites.extend(positions(Start::CubicLattice, self.solvent, &region, noise));
        let species = (0..count).map(|k| u8::from(k >= self.chains * self.beads)).collect();
        let mut particles = Particles::at_rest(sites, species, &[1.0, 1.0]);
        draw_momenta(&mut particles, 1.0, noise);
        let laws = interactions(
            &[1.0; 2],
            |a, b| self.potentials[a + b].clone(),
            |_, _| Some(Friction::Linear(friction(4.5, 1.2))),
        );
        let bonds = firsts.flat_map(|first| (first + 1..first + self.beads as u64).map(|k| k as u32));
        let bonds = bonds.map(|k| Bond { law: 0, first: k - 1, second: k }).collect();
        let topology = Topology::new(count, vec![self.law], bonds, self.range).unwrap();
        System::new(particles, region, laws, 0.3, Workers::One).unwrap().with_bonds(topology)
    }
}

/// A sample of the temperature of beads, solvent and all, by the momenta.
fn temperatures(simulation: &Simulation) -> [f64; 2] {
    let particles = &simulation.system.particles;
    let (mut sum, mut count) = ([0.0; 2], [0.0; 2]);
    for k in 0..particles.count() {
        let (p, kind) = (particles.momentum[k], usize::from(particles.species[k]));
        sum[kind] += p.iter().map(|p| p * p).sum::<f64>() * particles.inverse_mass[k];
        count[kind] += 3.0;
    }
    // The total momentum is zero, which takes 1/N of every particle's kinetic energy.
    let correction = 1.0 - 1.0 / particles.count() as f64;
    [sum[0] / count[0] / correction, sum[1] / count[1] / correction]
}

/// FENE chains of soft beads in Groot and Warren's solvent are at kT.
///
/// The curvature u'' of a bond, about 60, makes the kinetic temperature of ABOBA too high by ⟨ω²⟩Δt²/4 with
/// ⟨ω²⟩ = 2u''/(3m): by 2.5e-4 at Δt = 0.005. Kremer and Grest's stiff bonds (u'' near 1000) would need a fifth of that step:
/// at 0.005 they were measured at 1.0100(24).
#[test]
fn a_chain_in_a_solvent_has_the_set_temperature() {
    let solution = Solution {
        chains: 10,
        beads: 20,
        solvent: 280,
        density: 3.0,
        law: BondLaw::Fene(KREMER_GREST),
        range: ExclusionRange::default(),
        potentials: [Some(SOFT), Some(SOFT), Some(SOFT)],
    };
    check_scores(|seed| {
        let runs = replicas(2, |replica| {
            let noise = NoiseKey::new(&[seed, replica]);
            let mut simulation =
                Simulation::new(solution.system(noise), splitting("ABOBA"), None, noise, 0.005).unwrap();
            advance(&mut simulation, 10.0);
            let mut series = Blocking::new(2).unwrap();
            for _ in 0..2000 {
                advance(&mut simulation, 0.05);
                series.record(&temperatures(&simulation)).unwrap();
            }
            series
        });
        let mut series = runs[0].clone();
        series.merge(&runs[1]).unwrap();
        (0..2)
            .map(|kind| {
                let estimate = series.component(kind);
                let (value, error) = (estimate.value.unwrap(), estimate.standard_error.unwrap());
                println!("{}: kT = {value:.5}({error:.5})", ["beads", "solvent"][kind]);
                assert!(error <= 0.003, "the error {error} is too large to tell anything");
                (value - 1.0) / error
            })
            .collect()
    });
}

/// ∫₀^r s² exp(−u(s)/kT) ds, normalized, on a fine grid (Simpson): the probability of a bond shorter than r.
fn boltzmann(energy: impl Fn(f64) -> f64, longest: f64) -> impl Fn(f64) -> f64 {
    let points = 40_000;
    let h = longest / f64::from(points);
    let weight = |r: f64| if r > 0.0 { r * r * (-energy(r)).exp() } else { 0.0 };
    let mut below = vec![0.0];
    for k in 0..points {
        let r = f64::from(k) * h;
        let part = h / 6.0 * (weight(r) + 4.0 * weight(r + 0.5 * h) + weight((r + h).min(longest * (1.0 - 1e-12))));
        below.push(below[k as usize] + part);
    }
    let total = below[points as usize];
    move |r: f64| {
        let place = (r / h).clamp(0.0, f64::from(points) - 1.0);
        let (k, part) = (place as usize, place.fract());
        (below[k] * (1.0 - part) + below[k + 1] * part) / total
    }
}

/// Scores of the bonds' lengths in independent snapshots against Boltzmann's distribution: each length is turned into the normal
/// deviate of the same probability, whose mean must be 0 and whose mean square 1.
///
/// Chains that feel nothing but their bonds, and the solvent's friction, are ideal: every bond is distributed on its own as
/// r² exp(−u(r)/kT).
fn scores_of_lengths(law: BondLaw, dt: f64, seed: u64) -> [f64; 2] {
    let solution = Solution {
        chains: 8,
        beads: 10,
        solvent: 240,
        density: 3.0,
        law,
        range: ExclusionRange::default(),
        potentials: [None, None, Some(SOFT)],
    };
    let longest = if law.longest().is_finite() { law.longest() } else { 4.0 };
    let below = boltzmann(|r| law.energy(r), longest);
    let runs = replicas(2, |replica| {
        let noise = NoiseKey::new(&[seed, dt.to_bits(), replica]);
        let mut simulation = Simulation::new(solution.system(noise), splitting("ABOBA"), None, noise, dt).unwrap();
        advance(&mut simulation, 20.0);
        let mut lengths = Vec::new();
        for _ in 0..60 {
            // The slowest mode of a chain of ten takes a few units of time to forget.
            advance(&mut simulation, 4.0);
            let system = &simulation.system;
            system.topology().for_each_length(&system.particles, &system.region, |_, r| lengths.push(r));
        }
        lengths
    });
    let deviates: Vec<f64> = runs.concat().iter().map(|&r| probit(below(r))).collect();
    let count = deviates.len() as f64;
    let [mean, square] = [1, 2].map(|power| deviates.iter().map(|x| x.powi(power)).sum::<f64>() / count);
    println!("{law:?}: {count} lengths, mean {mean:.4}, mean square {square:.4}");
    [mean * count.sqrt(), (square - 1.0) * (count / 2.0).sqrt()]
}

#[test]
fn bond_lengths_follow_boltzmann() {
    let spring = BondLaw::Harmonic(Harmonic { stiffness: 20.0, length: 0.7 });
    let weak_fene = BondLaw::Fene(Fene { stiffness: 6.0, longest: 1.5 });
    check_scores(|seed| [scores_of_lengths(spring, 0.01, seed), scores_of_lengths(weak_fene, 0.01, seed)].concat());
}

/// Total energy of a melt of Kremer and Grest's chains, whose friction and potential the bonds exclude: constant but for
/// errors that fall with the square of the step.
#[test]
fn energy_is_conserved_without_a_thermostat() {
    let melt = Solution {
        chains: 20,
        beads: 10,
        solvent: 0,
        density: 0.6,
        law: BondLaw::Harmonic(Harmonic { stiffness: 300.0, length: 0.9 }),
        range: ExclusionRange { potential: 1, friction: 1 },
        potentials: [
            Some(common::lennard_jones(2.5, mesoflux_core::potential::lennard_jones::Truncation::ForceShifted)),
            None,
            None,
        ],
    };
    let noise = NoiseKey::new(&[3]);
    let mut start = melt.system(noise);
    relax_overlaps(&mut start, 1.0).unwrap();
    let error = |dt: f64| {
        let mut simulation = Simulation::new(start.clone(), splitting("BAB"), None, noise, dt).unwrap();
        let energy = |system: &mut System| {
            0.5 * system.particles.twice_kinetic_energy(Workers::One) + system.pair_sums().potential_energy
        };
        let before = energy(&mut simulation.system);
        let steps = (1.0 / dt).round() as u64;
        let squares = (0..steps).map(|_| {
            simulation.step().unwrap();
            (energy(&mut simulation.system) - before).powi(2)
        });
        (squares.sum::<f64>() / steps as f64).sqrt()
    };
    let (coarse, fine) = (error(0.004), error(0.002));
    println!("root mean square error of the energy: {coarse:.3e} and {fine:.3e}");
    assert!((3.0..5.5).contains(&(coarse / fine)), "{coarse} and {fine}");
}

/// Dense chains placed at random overlap terribly; relaxing parts them without breaking a bond.
#[test]
fn a_dense_melt_starts_without_overlaps_or_broken_bonds() {
    let melt = Solution {
        chains: 30,
        beads: 20,
        solvent: 0,
        density: 0.85,
        law: BondLaw::Fene(KREMER_GREST),
        range: ExclusionRange::default(),
        potentials: [Some(WCA), None, None],
    };
    let noise = NoiseKey::new(&[1]);
    let mut system = melt.system(noise);
    let overlap = check_overlaps(&mut system, 1.0).unwrap_err();
    assert!(overlap.energy > 1e6, "{overlap}");
    relax_overlaps(&mut system, 1.0).unwrap();
    check_overlaps(&mut system, 1.0).unwrap();
    let longest = |system: &System| {
        let mut longest = 0.0f64;
        system.topology().for_each_length(&system.particles, &system.region, |_, r| longest = longest.max(r));
        longest
    };
    let start = longest(&system);
    let mut simulation = Simulation::new(system, splitting("ABOBA"), None, noise, 0.005).unwrap();
    advance(&mut simulation, 2.0);
    let later = longest(&simulation.system);
    println!("longest bonds: {start:.3}, later {later:.3}");
    // At kT = 1 hardly one bond in a million is longer than 1.2; chains drawn across each other would stay near 1.4.
    assert!(start < 1.4 && later < 1.2, "{start} at the start, {later} later");
}

#[test]
fn a_bond_stretched_beyond_its_law_is_an_error_that_names_it() {
    let dumbbell = Solution {
        chains: 1,
        beads: 2,
        solvent: 100,
        density: 3.0,
        law: BondLaw::Fene(KREMER_GREST),
        range: ExclusionRange::default(),
        potentials: [None, None, None],
    };
    let noise = NoiseKey::new(&[1]);
    let mut system = dumbbell.system(noise);
    for k in 0..2 {
        let place = system.particles.id.iter().position(|&id| id == k).unwrap();
        system.particles.momentum[place] = [if k == 0 { 80.0 } else { -80.0 }, 0.0, 0.0];
    }
    let mut simulation = Simulation::new(system, splitting("ABOBA"), None, noise, 0.01).unwrap();
    let error = (0..3).find_map(|_| simulation.step().err()).unwrap();
    let SimulationError::BrokenBond { step, first, second, length, longest } = error else { panic!("{error}") };
    assert_eq!((step, first, second, longest), (0, 0, 1, 1.5));
    assert!(length > 1.5 && error.to_string().contains("between the particles 0 and 1"), "{error}");
}
