//! The works that both programs do, and how mesoflux is told to do them its different ways.

/// How two threads are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Split {
    /// Both work on one system.
    Bricks,
    /// Each works on a replica of its own; all of their steps count.
    Replicas,
}

/// An integrator of ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// The scheme that LAMMPS has: Groot and Warren's with λ = ½.
    VelocityVerlet,
    /// The splitting with the exact update of pairs.
    Aboba,
}

impl Scheme {
    /// Its name in the results.
    pub fn name(self) -> &'static str {
        match self {
            Self::VelocityVerlet => "velocity-verlet",
            Self::Aboba => "ABOBA",
        }
    }

    /// What chooses it in an input, whose `dynamics` says nothing else.
    pub fn setting(self) -> String {
        match self {
            Self::VelocityVerlet => "dynamics.velocity_verlet.lambda=0.5".to_owned(),
            Self::Aboba => "dynamics.word=ABOBA".to_owned(),
        }
    }
}

/// One work, as an input of each program states it.
#[derive(Debug)]
pub struct Work {
    /// Its name; that of our input.
    pub name: &'static str,
    /// What it is, for the reader of the results.
    pub title: &'static str,
    /// LAMMPS' input.
    pub lammps_input: &'static str,
    /// What its variables are set to.
    pub lammps_variables: &'static [(&'static str, &'static str)],
    /// The same for a tiny system.
    pub lammps_small: &'static [(&'static str, &'static str)],
    /// The number of particles of the tiny system.
    pub small: usize,
    /// Steps before anything is timed, as LAMMPS' input has them.
    pub warm_up: u64,
    /// Steps of the first, short timing.
    pub first_steps: u64,
    /// Steps along which temperature and pressure are sampled.
    pub sampled: u64,
    /// Steps in which the kinetic temperature forgets itself: 1/(2ΓΔt) with Γ = γρ (4π/3) r_c³/30.
    pub relaxation: u64,
    /// Our integrators to be timed.
    pub schemes: &'static [Scheme],
    /// How two threads are used.
    pub split: Split,
}

/// All works.
pub const WORKS: [Work; 4] = [
    Work {
        name: "groot-warren",
        title: "Groot–Warren fluid, ρ = 3, a = 25, γ = 4.5, Δt = 0.02",
        lammps_input: "groot-warren.lmp",
        lammps_variables: &[("L", "30")],
        lammps_small: &[("L", "6")],
        small: 648,
        warm_up: 300,
        first_steps: 10,
        sampled: 600,
        relaxation: 13,
        schemes: &[Scheme::VelocityVerlet, Scheme::Aboba],
        split: Split::Bricks,
    },
    ideal("ideal-16", "ideal fluid, n = 16, kT = 0.1, γ = 5, Δt = 10⁻⁴", &[("rho", "16")], IDEAL_SMALL_16, 450),
    ideal("ideal-32", "ideal fluid, n = 32, kT = 0.1, γ = 5, Δt = 10⁻⁴", &[("rho", "32")], IDEAL_SMALL_32, 225),
    Work {
        name: "lj-dpd",
        title: "Lennard-Jones liquid with a pair thermostat, ρ = 0.85, γ = 4.5, Δt = 0.01",
        lammps_input: "lj-dpd.lmp",
        lammps_variables: &[("gamma", "4.5")],
        lammps_small: &[("gamma", "4.5")],
        small: 500,
        warm_up: 2000,
        first_steps: 200,
        sampled: 20_000,
        relaxation: 6,
        schemes: &[Scheme::Aboba],
        split: Split::Replicas,
    },
];

const IDEAL_SMALL_16: &[(&str, &str)] = &[("rho", "16"), ("particles", "500")];
const IDEAL_SMALL_32: &[(&str, &str)] = &[("rho", "32"), ("particles", "500")];

const fn ideal(
    name: &'static str,
    title: &'static str,
    lammps_variables: &'static [(&'static str, &'static str)],
    lammps_small: &'static [(&'static str, &'static str)],
    relaxation: u64,
) -> Work {
    Work {
        name,
        title,
        lammps_input: "ideal.lmp",
        lammps_variables,
        lammps_small,
        small: 500,
        warm_up: 50,
        first_steps: 10,
        sampled: 1000,
        relaxation,
        schemes: &[Scheme::VelocityVerlet],
        split: Split::Bricks,
    }
}
