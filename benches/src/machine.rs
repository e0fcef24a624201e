//! What the timings were taken on: processor, caches, instruction sets, compiler, LAMMPS.

use crate::lammps::Lammps;
use mesoflux_core::lanes::InstructionSet;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::SystemTime;

/// A machine and its programs. What the system doesn't tell is "unknown".
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// How many threads can run at once.
    pub cores: usize,
    /// The caches of one core, such as "L2 2048K".
    pub caches: Vec<String>,
    /// The instruction sets that our kernels are compiled for and the machine has; the last one is used.
    pub instruction_sets: Vec<String>,
    /// The compiler.
    pub compiler: String,
    /// LAMMPS, where it took part.
    pub lammps: Option<String>,
    /// The day, in UTC.
    pub date: String,
}

impl Machine {
    /// This machine, today.
    pub fn here(lammps: Option<&Lammps>) -> Self {
        let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        Self {
            processor: processor().unwrap_or_else(unknown),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            caches: caches(),
            instruction_sets: InstructionSet::available().iter().map(|set| format!("{set:?}").to_lowercase()).collect(),
            compiler: version_of(&compiler).unwrap_or_else(unknown),
            lammps: lammps.map(|lammps| lammps.version.clone()),
            date: now.chars().take(10).collect(),
        }
    }

    /// Processor and cores.
    pub fn in_one_line(&self) -> String {
        format!("{}, {} cores", self.processor, self.cores)
    }
}

fn unknown() -> String {
    "unknown".to_owned()
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// The caches of the first core, without that of instructions.
fn caches() -> Vec<String> {
    let place = Path::new("/sys/devices/system/cpu/cpu0/cache");
    let cache = |index: usize| -> Option<String> {
        let read = |name: &str| std::fs::read_to_string(place.join(format!("index{index}/{name}"))).ok();
        let (level, size, kind) = (read("level")?, read("size")?, read("type")?);
        (kind.trim() != "Instruction").then(|| format!("L{} {}", level.trim(), size.trim()))
    };
    (0..8).filter_map(cache).collect()
}

fn version_of(program: &str) -> Option<String> {
    let output = Command::new(program).arg("--version").stdin(Stdio::null()).output().ok()?;
    Some(String::from_utf8_lossy(&output.stdout).lines().next()?.trim().to_owned())
}

/// The memory that is free for programs, in bytes, where the system tells.
pub fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}
