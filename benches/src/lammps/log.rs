//! What LAMMPS prints: loop times, and temperature and pressure along the last run.

/// A log of warm-up, timed run and, where it was asked for, a sampled run.
#[derive(Debug, PartialEq)]
pub struct Log {
    seconds: f64,
    steps: u64,
    /// N.
    pub particles: u64,
    /// Temperature and pressure along the sampled run.
    pub samples: Vec<[f64; 2]>,
}

impl Log {
    /// Reads a log; `None` if it ends before the timed run does.
    pub fn parse(text: &str) -> Option<Self> {
        let (seconds, steps, particles) = text.lines().filter_map(loop_time).nth(1)?;
        let header = |line: &&str| line.split_whitespace().eq(["Step", "Temp", "Press"]);
        let lines = text.lines().skip_while(|line| !header(line)).skip(1);
        Some(Self { seconds, steps, particles, samples: lines.map_while(sample).collect() })
    }

    /// Particle-steps per second of the timed run.
    pub fn rate(&self) -> f64 {
        self.particles as f64 * self.steps as f64 / self.seconds
    }
}

/// "Loop time of T on P procs for S steps with N atoms".
fn loop_time(line: &str) -> Option<(f64, u64, u64)> {
    let words: Vec<&str> = line.strip_prefix("Loop time of ")?.split_whitespace().collect();
    let after = |word: &str| words.get(words.iter().position(|other| *other == word)? + 1).copied();
    Some((words.first()?.parse().ok()?, after("for")?.parse().ok()?, after("with")?.parse().ok()?))
}

/// A line of step, temperature and pressure.
fn sample(line: &str) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    <[f64; 3]>::try_from(numbers).ok().map(|[_, temperature, pressure]| [temperature, pressure])
}

#[cfg(test)]
mod tests {
    use super::*;

    const WARM_UP: &str = "\
   Step          Temp          E_pair         E_mol          TotEng         Press     
         0   1             -3.9614942      0             -2.4644942      5.954782     
Loop time of 3.93156 on 1 procs for 2000 steps with 500 atoms
";
    const REST: &str = "\
Loop time of 0.5 on 2 procs for 100 steps with 500 atoms
Performance: 1 tau/day
   Step          Temp          Press     
      2100   0.9827128      3.6169862    
      2110   1.0320362      3.4915581    
Loop time of 9.34311 on 1 procs for 10 steps with 500 atoms
";

    #[test]
    fn the_second_loop_is_the_timed_one_and_the_last_table_holds_the_samples() {
        let log = Log::parse(&format!("{WARM_UP}{REST}")).unwrap();
        assert_eq!(log.rate(), 500.0 * 100.0 / 0.5);
        assert_eq!(log.samples, [[0.982_712_8, 3.616_986_2], [1.032_036_2, 3.491_558_1]]);
    }

    #[test]
    fn a_log_that_ends_early_is_none() {
        assert_eq!(Log::parse(WARM_UP), None);
        assert_eq!(Log::parse(""), None);
    }
}
