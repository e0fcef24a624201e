//! Friction that depends on velocity: the letter's balance at any time step and the order of its dynamics, worked out without
//! noise; the explicit schemes' distributions; whole fluids.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{advance, by_id, check_scores, friction, interactions, probit};
use mesoflux_analysis::{chi_squared_p_value, kolmogorov_smirnov_p_value, maxwell_speed_cdf, normal_cdf};
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::domain::Workers;
use mesoflux_core::friction::cross::Cross;
use mesoflux_core::friction::dot::Dot;
use mesoflux_core::friction::expression::Source;
use mesoflux_core::friction::fluctuation_dissipation::{Correction, PairStep, correction, predicted, random_force};
use mesoflux_core::friction::thinning::Thinning;
use mesoflux_core::friction::{Friction, Motion};
use mesoflux_core::integrate::{Explicit, Integrator, Schedule, SweepOrder, Thermostat};
use mesoflux_core::noise::{NoiseKey, Purpose};
use mesoflux_core::simulation::Simulation;
use mesoflux_core::start::{Start, draw_momenta, positions};
use mesoflux_core::state::Particles;
use mesoflux_core::system::System;
use mesoflux_core::vector::{dot, subtract};

/// kT of the paper's fluids.
const TEMPERATURE: f64 = 0.1;

/// 1/m_i + 1/m_j of equal particles of mass one.
const INVERSE_REDUCED_MASS: f64 = 2.0;

fn dot_law(thinning: f64) -> Friction {
    Friction::Dot(Dot(Thinning { coefficient: 5.0, thinning, cutoff: 1.0, exponent: 2.0 }))
}

fn typed_law() -> Friction {
    let friction = "5*(1 - r)^2*(1 + radial^2)/(1 + 4*radial^2)";
    Friction::Expression(Source { friction: friction.into(), parameters: [].into(), cutoff: 1.0 }.into())
}

/// The letter's update of one pair at a distance, as a Markov chain of u in units of its thermal width.
struct Pair<'a> {
    law: &'a Friction,
    distance: f64,
    time: f64,
}

impl Pair<'_> {
    /// The width of u in equilibrium.
    fn width() -> f64 {
        (TEMPERATURE * INVERSE_REDUCED_MASS).sqrt()
    }

    fn step(&self, u: f64) -> PairStep<f64> {
        let motion = Motion::along(self.distance, u);
        let (strength, slope) = (self.law.strength(motion), self.law.slope(motion));
        PairStep::new(strength, slope, INVERSE_REDUCED_MASS, TEMPERATURE, self.time)
    }

    /// u' − u for given random numbers.
    fn change(&self, x: f64, normal: f64, uniform: f64) -> f64 {
        let u = x * Self::width();
        let (here, variance) = (self.step(u), Self::width().powi(2));
        let back = self.step(u + here.change(u, normal));
        here.accepted(&back, u, normal, uniform, variance) / Self::width()
    }

    /// The probability that the step which `normal` proposes is taken: the largest uniform number that takes it.
    fn acceptance(&self, x: f64, normal: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        if self.change(x, normal, 1.0 - 1e-16) != 0.0 {
            return 1.0;
        }
        for _ in 0..26 {
            let middle = 0.5 * (low + high);
            if self.change(x, normal, middle) == 0.0 { high = middle } else { low = middle }
        }
        low
    }
}

/// A function of x on a grid, between its points by a cubic through four of them.
struct Grid {
    values: Vec<f64>,
}

impl Grid {
    const REACH: f64 = 8.0;
    const POINTS: usize = 321;
    const STEP: f64 = 2.0 * Self::REACH / (Self::POINTS as f64 - 1.0);

    fn place(k: usize) -> f64 {
        k as f64 * Self::STEP - Self::REACH
    }

    fn of(function: impl Fn(f64) -> f64) -> Self {
        Self { values: (0..Self::POINTS).map(|k| function(Self::place(k))).collect() }
    }

    fn at(&self, x: f64) -> f64 {
        let s = ((x + Self::REACH) / Self::STEP).clamp(0.0, Self::POINTS as f64 - 1.0);
        let k = (s as usize).clamp(1, Self::POINTS - 3);
        let t = s - k as f64;
        let [a, b, c, d] = [k - 1, k, k + 1, k + 2].map(|k| self.values[k]);
        -t * (t - 1.0) * (t - 2.0) / 6.0 * a + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * b
            - (t + 1.0) * t * (t - 2.0) / 2.0 * c
            + (t + 1.0) * t * (t - 1.0) / 6.0 * d
    }

    /// ∫ f g π dx with π the normal density.
    fn mean_product(&self, other: &Self) -> f64 {
        let weight = |k: usize| (-0.5 * Self::place(k).powi(2)).exp();
        let sum = |term: &dyn Fn(usize) -> f64| (0..Self::POINTS).map(|k| weight(k) * term(k)).sum::<f64>();
        sum(&|k| self.values[k] * other.values[k]) / sum(&|_| 1.0)
    }
}

/// The transitions of the letter on the grid: for every x the places to which normal numbers lead, and with which probability.
struct Transitions {
    steps: Vec<Vec<(f64, f64)>>,
    rejected: f64,
}

impl Transitions {
    fn of(pair: &Pair) -> Self {
        let (normals, spacing) = (480, 12.0 / 480.0);
        let mut rejected = 0.0;
        let unit = Grid::of(|_| 1.0);
        let all: f64 = (0..Grid::POINTS).map(|k| (-0.5 * Grid::place(k).powi(2)).exp() * unit.values[k]).sum();
        let steps = (0..Grid::POINTS).map(|k| {
            let x = Grid::place(k);
            let mut stay = 1.0;
            let mut steps: Vec<(f64, f64)> = (0..normals)
                .map(|n| {
                    let normal = (f64::from(n) + 0.5) * spacing - 6.0;
                    let density = spacing * (-0.5 * normal * normal).exp() / std::f64::consts::TAU.sqrt();
                    let weight = density * pair.acceptance(x, normal);
                    stay -= weight;
                    (x + pair.change(x, normal, 0.0), weight)
                })
                .collect();
            rejected += stay * (-0.5 * x * x).exp() / all;
            steps.push((x, stay));
            steps
        });
        let steps = steps.collect();
        Self { steps, rejected }
    }

    /// ⟨f(x')|x⟩.
    fn apply(&self, f: &Grid) -> Grid {
        Grid {
            values: self.steps.iter().map(|steps| steps.iter().map(|&(x, weight)| weight * f.at(x)).sum()).collect(),
        }
    }
}

/// A detailed balance is one of every two functions: ⟨f P g⟩ = ⟨g P f⟩, at small time steps and at absurd ones.
#[test]
fn the_letter_has_detailed_balance_at_any_time_step() {
    for (name, law) in [("dot", dot_law(10.0)), ("typed", typed_law())] {
        for time in [0.01, 0.3, 3.0] {
            let transitions = Transitions::of(&Pair { law: &law, distance: 0.4, time });
            let functions = [
                Grid::of(|_| 1.0),
                Grid::of(|x| x * x),
                Grid::of(|x| x.powi(4)),
                Grid::of(|x| x),
                Grid::of(|x| x.powi(3)),
            ];
            for f in &functions {
                for g in &functions {
                    let (forward, backward) =
                        (f.mean_product(&transitions.apply(g)), g.mean_product(&transitions.apply(f)));
                    let scale = (f.mean_product(f) * g.mean_product(g)).sqrt();
                    assert!(
                        (forward - backward).abs() < 3e-5 * scale,
                        "{name}, t = {time}: {forward} against {backward}"
                    );
                }
            }
        }
    }
}

/// Rejections fall as t^(3/2).
#[test]
fn rejections_fall_fast() {
    for law in [dot_law(1.0), typed_law()] {
        let rejected =
            [0.0004, 0.0016, 0.0064].map(|time| Transitions::of(&Pair { law: &law, distance: 0.4, time }).rejected);
        println!("rejected: {rejected:?}");
        for pair in rejected.windows(2) {
            let order = (pair[1] / pair[0]).log2() / 2.0;
            assert!((1.3..1.7).contains(&order), "order {order}");
        }
    }
}

/// ⟨u(t)u(0)⟩ of the diffusion itself, du = (−Γu + kT w Γ') w dt + √(2ΓkT) w dW, by small steps of its Fokker–Planck operator: finite
/// volumes, which are reversible as the diffusion is, and Crank and Nicolson in time.
fn decay_of_the_diffusion(law: &Friction, distance: f64, time: f64) -> f64 {
    let (points, reach, steps) = (1601, 8.0, 400);
    let h = 2.0 * reach / (points as f64 - 1.0);
    let place = |k: f64| k * h - reach;
    let weight = |x: f64| (-0.5 * x * x).exp();
    let rate = |x: f64| law.strength(Motion::along(distance, x * Pair::width())) * INVERSE_REDUCED_MASS;
    let flow: Vec<f64> =
        (0..points - 1).map(|k| place(k as f64 + 0.5)).map(|x| weight(x) * rate(x) / (h * h)).collect();
    let dt = time / f64::from(steps);
    let mut f: Vec<f64> = (0..points).map(|k| place(k as f64)).collect();
    for _ in 0..steps {
        // (1 − ½dt L) f' = (1 + ½dt L) f with (Lf)_k = Σ flow (f_neighbor − f_k)/weight_k, by elimination.
        let mut right = vec![0.0; points];
        let (mut diagonal, mut upper, mut lower) = (vec![1.0; points], vec![0.0; points], vec![0.0; points]);
        for k in 0..points {
            let w = weight(place(k as f64));
            right[k] = f[k];
            for (flow, other) in
                [(k > 0).then(|| (flow[k - 1], k - 1)), (k + 1 < points).then(|| (flow[k.min(points - 2)], k + 1))]
                    .into_iter()
                    .flatten()
            {
                let rate = 0.5 * dt * flow / w;
                right[k] += rate * (f[other] - f[k]);
                diagonal[k] += rate;
                *(if other > k { &mut upper[k] } else { &mut lower[k] }) = -rate;
            }
        }
        for k in 1..points {
            let factor = lower[k] / diagonal[k - 1];
            diagonal[k] -= factor * upper[k - 1];
            right[k] -= factor * right[k - 1];
        }
        f[points - 1] = right[points - 1] / diagonal[points - 1];
        for k in (0..points - 1).rev() {
            f[k] = (right[k] - upper[k] * f[k + 1]) / diagonal[k];
        }
    }
    let sum = |term: &dyn Fn(usize) -> f64| (0..points).map(|k| weight(place(k as f64)) * term(k)).sum::<f64>();
    sum(&|k| place(k as f64) * f[k]) / sum(&|_| 1.0)
}

/// The letter's decay of ⟨u(t)u(0)⟩ tends to that of the diffusion, at first order or better.
#[test]
fn the_dynamics_converges_at_first_order_or_better() {
    for law in [dot_law(3.0), typed_law()] {
        let (distance, time) = (0.4, 0.32);
        let expected = decay_of_the_diffusion(&law, distance, time);
        assert!((0.2..0.8).contains(&expected), "{expected} tells nothing");
        let errors = [4, 8, 16].map(|steps| {
            let transitions = Transitions::of(&Pair { law: &law, distance, time: time / f64::from(steps) });
            let identity = Grid::of(|x| x);
            let after = (0..steps).fold(Grid::of(|x| x), |f, _| transitions.apply(&f));
            identity.mean_product(&after) - expected
        });
        println!("⟨u(t)u(0)⟩ = {expected:.5}, errors {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).abs().log2();
            assert!(order > 0.85, "order {order}");
        }
    }
}

/// χ² of u after so many explicit steps of many pairs, each with its own noise; `update` gives the impulse of the noise.
fn p_value_of_explicit_pairs(law: &Friction, impulse: impl Fn(f64, f64, f64, f64) -> f64) -> f64 {
    let (pairs, steps, time_step, distance) = (30_000u64, 250, 2e-3, 0.3);
    let noise = NoiseKey::new(&[7]);
    let (bins, width) = (24, Pair::width());
    let mut observed = vec![0.0; bins];
    for pair in 0..pairs {
        let mut u = width * noise.draw(Purpose::Start, 0, 0).gaussian(pair, 1);
        for step in 0..steps {
            let normal = noise.draw(Purpose::Pair, step, 0).gaussian(pair, 0);
            let motion = Motion::along(distance, u);
            let (strength, slope) = (law.strength(motion), law.slope(motion));
            u += time_step * INVERSE_REDUCED_MASS * (impulse(u, strength, slope, normal) - strength * u);
        }
        observed[((normal_cdf(u / width) * bins as f64) as usize).min(bins - 1)] += 1.0;
    }
    chi_squared_p_value(&observed, &vec![pairs as f64 / bins as f64; bins], 1).unwrap()
}

/// With Λ, or by two steps, explicit pairs keep Maxwell's distribution; without, they lose it.
#[test]
fn explicit_pairs_need_the_correction() {
    let law = dot_law(3.0);
    let (time_step, distance) = (2e-3, 0.3);
    let by_derivative = p_value_of_explicit_pairs(&law, |_, strength, slope, normal| {
        random_force(strength, TEMPERATURE, time_step) * normal
            + correction(slope, INVERSE_REDUCED_MASS, TEMPERATURE) * normal * normal
    });
    let by_two_steps = p_value_of_explicit_pairs(&law, |u, strength, _, normal| {
        let first = random_force(strength, TEMPERATURE, time_step) * normal;
        let moved = Motion::along(distance, predicted(u, first, INVERSE_REDUCED_MASS, time_step));
        random_force(law.strength(moved), TEMPERATURE, time_step) * normal
    });
    let without = p_value_of_explicit_pairs(&law, |_, strength, _, normal| {
        random_force(strength, TEMPERATURE, time_step) * normal
    });
    println!("p = {by_derivative:.3}, {by_two_steps:.3}, {without:.3e}");
    assert!(by_derivative > 1e-3 && by_two_steps > 1e-3 && without < 1e-6);
}

/// The paper's ideal fluid, n = 16, in a small box.
fn fluid(law: &Friction, masses: &[f64], integrator: Integrator, noise: NoiseKey, time_step: f64) -> Simulation {
    fluid_of(600, law, masses, integrator, noise, time_step)
}

fn fluid_of(
    count: usize,
    law: &Friction,
    masses: &[f64],
    integrator: Integrator,
    noise: NoiseKey,
    time_step: f64,
) -> Simulation {
    let region = PeriodicBox::new([(count as f64 / 16.0).cbrt(); 3]).unwrap();
    let species = (0..count).map(|k| (k % masses.len()) as u8).collect();
    let sites = positions(Start::CubicLattice, count, &region, noise);
    let mut particles = Particles::at_rest(sites, species, masses);
    draw_momenta(&mut particles, 1.5 * TEMPERATURE, noise);
    let laws = interactions(masses, |_, _| None, |_, _| Some(law.clone()));
    let system = System::new(particles, region, laws, 0.1, Workers::One).unwrap();
    Simulation::new(system, integrator, None, noise, time_step).unwrap()
}

fn letter() -> Integrator {
    let thermostat = Thermostat::PairOrnsteinUhlenbeck;
    Integrator::Splitting(Schedule::new("ABOBA", thermostat, TEMPERATURE, SweepOrder::Alternating).unwrap())
}

/// γnr_c³·2π/45 over m: the rate at which friction at rest makes a velocity decay.
const RATE: f64 = std::f64::consts::TAU * 5.0 * 16.0 / 45.0;

/// The kinetic temperature over snapshots, with its standard error where snapshots are independent.
fn temperature(simulation: &mut Simulation, snapshots: usize) -> (f64, f64) {
    advance(simulation, 2.0);
    let mut sum = 0.0;
    for _ in 0..snapshots {
        advance(simulation, 5.0 / RATE);
        sum += simulation.system.kinetic_temperature();
    }
    let freedom = 3.0 * (simulation.system.particles.count() as f64 - 1.0) * snapshots as f64;
    (sum / snapshots as f64, TEMPERATURE * (2.0 / freedom).sqrt())
}

/// The letter at a hundred times the paper's time step: temperature and speeds, of equal and unequal particles.
#[test]
fn fluids_have_maxwells_speeds_at_a_large_time_step() {
    let cross = Friction::Cross(Cross(Thinning { coefficient: 5.0, thinning: 1.0, cutoff: 1.0, exponent: 2.0 }));
    let laws = [("cross", cross), ("dot", dot_law(1.0)), ("typed", typed_law())];
    check_scores(|seed| {
        let mut scores = Vec::new();
        for (index, (name, law)) in laws.iter().enumerate() {
            let masses: &[f64] = if index == 1 { &[1.0, 2.5] } else { &[1.0] };
            let noise = NoiseKey::new(&[seed, index as u64]);
            let mut simulation = fluid(law, masses, letter(), noise, 0.01);
            let (found, error) = temperature(&mut simulation, 30);
            println!("{name}: kT = {found:.5}({error:.5})");
            scores.push((found - TEMPERATURE) / error);
            let mut places = Vec::new();
            for _ in 0..15 {
                advance(&mut simulation, 5.0 / RATE);
                let particles = &simulation.system.particles;
                let total_mass = particles.total_mass(Workers::One);
                for k in 0..particles.count() {
                    let (v, inverse_mass) = (particles.velocity(k), particles.inverse_mass[k]);
                    let variance = TEMPERATURE * (inverse_mass - 1.0 / total_mass);
                    places.push(maxwell_speed_cdf(dot(v, v).sqrt(), variance));
                }
            }
            places.sort_by(f64::total_cmp);
            scores.push(probit(kolmogorov_smirnov_p_value(&places, |place| place).unwrap()));
        }
        scores
    });
}

/// The explicit scheme heats the linear fluid to kT/(1 − ½aΔt).
#[test]
fn the_explicit_schemes_temperature_is_the_predicted_one() {
    check_scores(|seed| {
        let time_step = 0.01;
        let integrator = Integrator::Explicit(Explicit::new(TEMPERATURE, Correction::default()));
        let linear = Friction::Linear(friction(5.0, 1.0));
        let mut simulation = fluid(&linear, &[1.0], integrator, NoiseKey::new(&[seed]), time_step);
        let (found, error) = temperature(&mut simulation, 60);
        // Of N particles only N − 1 rub against each.
        let rate = RATE * 599.0 / 600.0;
        let expected = TEMPERATURE / (1.0 - 0.5 * rate * time_step);
        println!("kT = {found:.5}({error:.5}), expected {expected:.5}");
        vec![(found - expected) / error]
    });
}

/// The order of visits follows from the state, whoever works on which brick; momentum is conserved.
#[test]
fn threads_change_no_bits() {
    for law in [dot_law(1.0), typed_law()] {
        let run = |workers: Workers| {
            let mut simulation = fluid_of(6000, &law, &[1.0, 2.0], letter(), NoiseKey::new(&[3]), 0.01);
            simulation.system.workers = workers;
            for _ in 0..6 {
                simulation.step().unwrap();
            }
            let particles = &simulation.system.particles;
            let total =
                particles.momentum.iter().fold([0.0; 3], |sum, p| [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]]);
            assert!(dot(total, total).sqrt() < 1e-10, "momentum {total:?}");
            by_id(particles, &particles.momentum)
        };
        let expected = run(Workers::One);
        for threads in [2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| run(Workers::Pool)) == expected, "momenta differ on {threads} threads");
        }
    }
}

/// Every pair's relative velocity along its line of centers has the variance kT(1/m_i + 1/m_j).
#[test]
fn relative_velocities_of_near_pairs_are_normal() {
    check_scores(|seed| {
        let mut simulation = fluid(&dot_law(3.0), &[1.0, 3.0], letter(), NoiseKey::new(&[seed, 9]), 0.01);
        advance(&mut simulation, 2.0);
        let mut places = Vec::new();
        for _ in 0..20 {
            // The heavier particles are three times as slow.
            advance(&mut simulation, 15.0 / RATE);
            // In the order of ids: the order in storage remembers where particles were, and so tells of their velocities.
            let particles = &simulation.system.particles;
            let position = by_id(particles, &particles.position);
            let momentum = by_id(particles, &particles.momentum);
            let inverse_mass = by_id(particles, &particles.inverse_mass);
            // One neighbor for each particle at most, so that the numbers are independent.
            let mut free = vec![true; particles.count()];
            for i in 0..particles.count() {
                for j in i + 1..particles.count() {
                    let d = simulation.system.region.nearest_image(subtract(position[i], position[j]));
                    let r = dot(d, d).sqrt();
                    if free[i] && free[j] && r < 0.5 {
                        (free[i], free[j]) = (false, false);
                        let u = dot(d, momentum[i]) * inverse_mass[i] - dot(d, momentum[j]) * inverse_mass[j];
                        let variance = TEMPERATURE * (inverse_mass[i] + inverse_mass[j]);
                        places.push(normal_cdf(u / r / variance.sqrt()));
                    }
                }
            }
        }
        assert!(places.len() > 3000, "{}", places.len());
        places.sort_by(f64::total_cmp);
        vec![probit(kolmogorov_smirnov_p_value(&places, |place| place).unwrap())]
    });
}
