//! A small deterministic generator and the processes the tests measure.
#![allow(dead_code, missing_docs)] // Each test file uses its own part.
#![allow(clippy::unwrap_used)] // Only tests call these functions.

use mesoflux_analysis::{Blocking, MeanSquaredDisplacement};

/// `SplitMix64` with Box and Muller's transformation.
pub struct Random {
    state: u64,
    spare: Option<f64>,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut random = Self { state: seed, spare: None };
        // Neighboring seeds must not give shifted copies of one sequence.
        random.state = random.bits();
        random
    }

    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn uniform(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sine, cosine) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sine);
        radius * cosine
    }
}

/// A stationary first-order autoregressive series of unit variance: x' = φx + √(1 − φ²) ξ.
pub struct Autoregressive {
    memory: f64,
    value: f64,
}

impl Autoregressive {
    pub fn new(memory: f64, random: &mut Random) -> Self {
        Self { memory, value: random.normal() }
    }

    pub fn next(&mut self, random: &mut Random) -> f64 {
        let value = self.value;
        self.value = self.memory * value + (1.0 - self.memory * self.memory).sqrt() * random.normal();
        value
    }
}

pub fn recorded_autoregressive(memory: f64, length: usize, random: &mut Random) -> Blocking {
    let mut blocking = Blocking::new(1).unwrap();
    let mut series = Autoregressive::new(memory, random);
    (0..length).for_each(|_| blocking.record(&[series.next(random)]).unwrap());
    blocking
}

/// How a coordinate moves from one record to the next.
#[derive(Clone, Copy)]
pub enum Motion {
    /// Independent steps of unit variance: D = 1/2 for unit spacing.
    Brownian,
    /// Langevin equation with unit friction rate and kT/m, solved exactly over the spacing: D = 1.
    Langevin { spacing: f64 },
    /// Overdamped in a harmonic well of unit variance and unit relaxation time: D = 0 in the long run.
    Confined { spacing: f64 },
    /// Free flight at a constant velocity.
    Ballistic,
}

pub fn recorded_motion(
    motion: Motion,
    particles: usize,
    lags: usize,
    records: usize,
    random: &mut Random,
) -> MeanSquaredDisplacement {
    let spacing = match motion {
        Motion::Langevin { spacing } | Motion::Confined { spacing } => spacing,
        Motion::Brownian | Motion::Ballistic => 1.0,
    };
    let mut recorder = MeanSquaredDisplacement::new(particles, lags, spacing).unwrap();
    let mut positions = vec![[0.0; 3]; particles];
    let mut velocities: Vec<f64> = (0..3 * particles).map(|_| random.normal()).collect();
    let decay = (-spacing).exp();
    // Covariances of the exact solution (D. T. Gillespie, Phys. Rev. E 54, 2084 (1996)).
    let position_variance = 2.0 * spacing - 3.0 + 4.0 * decay - decay * decay;
    let covariance = (1.0 - decay).powi(2);
    let rest = 1.0 - decay * decay - covariance * covariance / position_variance;
    for _ in 0..records {
        for (x, v) in positions.as_flattened_mut().iter_mut().zip(&mut velocities) {
            match motion {
                Motion::Brownian => *x += random.normal(),
                Motion::Langevin { .. } => {
                    let (first, second) = (random.normal(), random.normal());
                    *x += *v * (1.0 - decay) + position_variance.sqrt() * first;
                    *v = *v * decay + covariance / position_variance.sqrt() * first + rest.sqrt() * second;
                }
                Motion::Confined { .. } => *x = *x * decay + (1.0 - decay * decay).sqrt() * random.normal(),
                Motion::Ballistic => *x += *v,
            }
        }
        recorder.record(&positions).unwrap();
    }
    recorder
}

/// A sum of independent autoregressive series, `C(t) = Σ a_i exp(−t/τ_i)` in units of samples, plus white noise.
pub struct Exponentials {
    parts: Vec<(f64, Autoregressive)>,
    noise: f64,
}

impl Exponentials {
    /// `parts` are variance and correlation time, `noise` the variance of the white noise.
    pub fn new(parts: &[(f64, f64)], noise: f64, random: &mut Random) -> Self {
        let part =
            |&(variance, time): &(f64, f64)| (f64::sqrt(variance), Autoregressive::new((-1.0 / time).exp(), random));
        Self { parts: parts.iter().map(part).collect(), noise: noise.sqrt() }
    }

    pub fn next(&mut self, random: &mut Random) -> f64 {
        let correlated: f64 = self.parts.iter_mut().map(|(scale, part)| *scale * part.next(random)).sum();
        correlated + if self.noise > 0.0 { self.noise * random.normal() } else { 0.0 }
    }

    /// ½C(0) + Σ_{k ≥ 1} C(k).
    pub fn integral(parts: &[(f64, f64)], noise: f64) -> f64 {
        let part = |&(variance, time): &(f64, f64)| {
            let memory = f64::exp(-1.0 / time);
            0.5 * variance * (1.0 + memory) / (1.0 - memory)
        };
        parts.iter().map(part).sum::<f64>() + 0.5 * noise
    }
}

/// A rotating Ornstein–Uhlenbeck process z = x + iy, z' = z exp(−γ + iω) + noise, in units of samples; x and y have unit variance.
///
/// `C_xx = C_yy = exp(−γt) cos ωt` and, with y later, `C_yx = exp(−γt) sin ωt`, which is odd in t.
pub struct Rotating {
    decay: f64,
    frequency: f64,
    position: [f64; 2],
}

impl Rotating {
    pub fn new(decay: f64, frequency: f64, random: &mut Random) -> Self {
        Self { decay, frequency, position: [random.normal(), random.normal()] }
    }

    pub fn next(&mut self, random: &mut Random) -> [f64; 2] {
        let [x, y] = self.position;
        let memory = (-self.decay).exp();
        let (sine, cosine) = self.frequency.sin_cos();
        let noise = (1.0 - memory * memory).sqrt();
        self.position = [
            memory * (cosine * x - sine * y) + noise * random.normal(),
            memory * (sine * x + cosine * y) + noise * random.normal(),
        ];
        [x, y]
    }

    /// ½C(0) + Σ_{k ≥ 1} C(k) of x with itself and of y (later) with x: real and imaginary part of ½ + q/(1 − q), q = exp(−γ + iω).
    pub fn integrals(decay: f64, frequency: f64) -> (f64, f64) {
        let memory = (-decay).exp();
        let denominator = 1.0 - 2.0 * memory * frequency.cos() + memory * memory;
        (0.5 * (1.0 - memory * memory) / denominator, memory * frequency.sin() / denominator)
    }
}
