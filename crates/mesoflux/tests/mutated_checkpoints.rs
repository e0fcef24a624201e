//! A thousand damaged checkpoints: no panic, no hang, no huge allocation, and none accepted whose checksum is wrong.

#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{FLUID, Random};
use mesoflux::answer::{Circumstances, answer};
use mesoflux::job::{Conduct, JobError, perform};
use mesoflux::plan::Plan;
use mesoflux::progress::Progress;
use mesoflux::store::{Cadence, RunState, Store, head};
use mesoflux_io::checkpoint::{HEADER, WholeState};
use mesoflux_io::directory::OutputDirectory;
use mesoflux_io::input::{InputFile, Setting};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const EQUILIBRIUM: &str = "[measure.D]\nquantity = \"diffusion_coefficient\"\nroutes.msd = { longest_lag = 0.8 }\n\
                           [measure.P]\nquantity = \"pressure\"\n";
const NORTON: &str =
    "[measure.m]\nquantity = \"mobility\"\nforcing = \"color_drift\"\nroutes.norton = { flux = 2.0 }\n";

/// A run of one task that has kept its state, and is to go on for a few steps.
struct Victim {
    longer: Plan,
    store: Store,
    states: OutputDirectory,
    path: PathBuf,
    good: Vec<u8>,
    stop: AtomicBool,
    progress: Progress,
    _folder: tempfile::TempDir,
}

impl Victim {
    fn new(input: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let states = OutputDirectory::explicit(&folder.path().join("states"), false).unwrap();
        let store = Store::new(states.clone(), Cadence { steps: None, wall: Duration::MAX });
        let file = folder.path().join("fluid.toml");
        std::fs::write(&file, input).unwrap();
        let plan = |time: &str| {
            let longer = Setting { path: "run.production_time".to_owned(), value: time.to_owned() };
            Plan::new(&InputFile::read(&file, &[longer]).unwrap()).unwrap()
        };
        let mut victim = Self {
            longer: plan("4.0"),
            path: folder.path().join("states/point-0-run-0-replica-0.a.checkpoint"),
            store,
            states,
            good: Vec::new(),
            stop: AtomicBool::new(false),
            progress: Progress::new(0, true),
            _folder: folder,
        };
        let short = std::mem::replace(&mut victim.longer, plan("4.1"));
        assert_eq!(short.tasks().len(), 1);
        victim.go_on(&short).unwrap();
        victim.good = std::fs::read(&victim.path).unwrap();
        // What was streamed is what would have been encoded whole.
        let RunState { simulation, recorders } = victim.state();
        let head = head(&victim.longer.points[0].input, simulation.system.step);
        let encoded = postcard::to_stdvec(&(head, simulation, recorders)).unwrap();
        assert!(victim.good[HEADER..] == encoded, "a stream is encoded otherwise");
        victim
    }

    /// Runs to the end and estimates.
    fn go_on(&self, plan: &Plan) -> Result<(), JobError> {
        let (stop, progress) = (&self.stop, &self.progress);
        let conduct = Conduct { threads: 1, store: Some(&self.store), stop, deadline: None, progress };
        let finished = perform(plan, &conduct)?;
        answer(&plan.points[0].input, plan, &finished, Circumstances { threads: 1, wall_seconds: 1.0 })?;
        Ok(())
    }

    /// The state that is there.
    fn state(&self) -> RunState {
        self.store.read(&mut self.store.files(self.longer.tasks()[0])).unwrap().unwrap().state
    }

    /// Leaves no state.
    fn clear(&self) {
        for entry in std::fs::read_dir(self.path.parent().unwrap()).unwrap() {
            std::fs::remove_file(entry.unwrap().path()).unwrap();
        }
    }

    /// Leaves this state alone.
    fn place(&self, contents: &[u8]) {
        self.clear();
        std::fs::write(&self.path, contents).unwrap();
    }

    /// The contents of a file with this state, whose checksum is right.
    fn framed(&self, state: &[u8]) -> Vec<u8> {
        self.clear();
        self.store.files(self.longer.tasks()[0]).write(&self.states, |out| out.write_all(state)).unwrap();
        std::fs::read(&self.path).unwrap()
    }

    /// Goes on from a file with these contents: whether that was possible, or the message of the refusal.
    fn attempt(&self, contents: &[u8]) -> Result<(), String> {
        self.place(contents);
        let kept = self.store.read(&mut self.store.files(self.longer.tasks()[0])).map_err(|error| error.to_string())?;
        let particles = kept.unwrap().state.simulation.system.particles;
        match self.go_on(&self.longer) {
            // Numbers that are none of a fluid may well fail numerically, later.
            Ok(()) | Err(JobError::Simulation { .. } | JobError::Route { .. }) => {
                assert!(particles.is_consistent(1), "taken over, though it isn't consistent");
                Ok(())
            }
            Err(refused) => Err(refused.to_string()),
        }
    }
}

/// Damages the inside of a state: what is left is a whole state of the right layout, with the numbers of none that ever was.
fn mutate_within(victim: &Victim, random: &mut Random) -> Vec<u8> {
    loop {
        victim.place(&victim.good);
        let mut state = victim.state();
        if random.below(2) == 0 {
            let recorder = random.below(state.recorders.len());
            let bytes = &mut state.recorders[recorder];
            match random.below(2) {
                0 => mutate(bytes, random),
                // Where counts and lengths are.
                _ => bytes[random.below(32)] = random.below(8) as u8,
            }
        } else {
            let mut bytes = postcard::to_stdvec(&state.simulation).unwrap();
            match random.below(2) {
                0 => mutate(&mut bytes, random),
                // Where the names of velocity Verlet's columns are.
                _ => *bytes.last_mut().unwrap() = random.below(4) as u8,
            }
            let Ok(simulation) = postcard::from_bytes(&bytes) else { continue };
            state.simulation = simulation;
        }
        let RunState { simulation, recorders } = state;
        let head = head(&victim.longer.points[0].input, simulation.system.step);
        return victim.framed(&postcard::to_stdvec(&(head, simulation, recorders)).unwrap());
    }
}

/// Damages bytes in one of many ways.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let place = random.below(bytes.len());
    let length = 1 + random.below(64.min(bytes.len() - place));
    match random.below(11) {
        0 | 1 => bytes[place] ^= 1 << random.below(8),
        2 => bytes.truncate(place),
        3 => bytes[place..place + length].fill(0xff),
        4 => bytes[place..place + length].fill(0),
        // The largest number that the encoding of integers can hold.
        5 => drop(bytes.splice(place..place, [0xff; 9].into_iter().chain([1]))),
        6 => drop(bytes.splice(place..place, (0..length).map(|_| random.next() as u8).collect::<Vec<_>>())),
        7 => drop(bytes.drain(place..place + length)),
        8 => {
            let other = random.below(bytes.len() - length + 1);
            let block = bytes[place..place + length].to_vec();
            bytes.copy_within(other..other + length, place);
            bytes[other..other + length].copy_from_slice(&block);
        }
        // Where the first lengths and counts are.
        9 => {
            let early = random.below(bytes.len().min(48));
            bytes[early] = random.next() as u8;
        }
        // Where the recorders' last numbers are.
        _ => {
            let late = bytes.len() - 1 - random.below(bytes.len().min(400));
            bytes[late] ^= random.next() as u8 | 1;
        }
    }
}

/// Half of them damaged as files are; half of them with the checksum made right, so that all that comes after it is met.
fn meet_a_thousand() {
    let fluid = FLUID.replace("particles = 64", "particles = 32").replace("replicas = 2", "replicas = 1");
    let fluid = fluid.replace("density = 3.0", "density = 2.0").replace("cutoff = 1.0", "cutoff = 0.9");
    let verlet = fluid.replace("time_step = 0.02", "time_step = 0.02\nvelocity_verlet = {}");
    let victims =
        [format!("{fluid}{EQUILIBRIUM}"), format!("{fluid}{NORTON}"), verlet].map(|input| Victim::new(&input));
    let mut random = Random(3);
    let (mut accepted, mut refused, mut damaged) = (0, 0, 0);
    for number in 0..1000 {
        let victim = &victims[number % 3];
        let mut bytes = victim.good.clone();
        if number % 2 == 0 {
            while bytes == victim.good {
                mutate(&mut bytes, &mut random);
            }
        } else if number % 4 == 1 {
            let mut state = victim.good[HEADER..].to_vec();
            for _ in 0..=random.below(3) {
                mutate(&mut state, &mut random);
            }
            bytes = victim.framed(&state);
        } else {
            bytes = mutate_within(victim, &mut random);
        }
        let start = Instant::now();
        let met = catch_unwind(AssertUnwindSafe(|| victim.attempt(&bytes)));
        let met = met.unwrap_or_else(|_| panic!("a panic at number {number}"));
        assert!(start.elapsed() < Duration::from_secs(10), "number {number} took {:?}", start.elapsed());
        match met {
            Ok(()) => {
                assert!(number % 2 == 1, "number {number} was accepted, though its checksum is wrong");
                accepted += 1;
            }
            Err(message) => {
                assert!(message.contains("point-0-run-0-replica-0.a.checkpoint"), "number {number}: {message}");
                refused += 1;
                std::fs::write(&victim.path, &bytes).unwrap();
                damaged += u64::from(WholeState::open(&victim.path, "").is_err());
            }
        }
    }
    eprintln!("{damaged} damaged, {refused} refused, {accepted} accepted");
    // The bits of momenta and sums have no sense of their own, so some must be accepted; a state as it was must be, too.
    assert!(
        damaged == 500 && refused > 600 && accepted > 100,
        "{damaged} damaged, {refused} refused, {accepted} accepted"
    );
    for victim in &victims {
        victim.attempt(&victim.good).unwrap();
    }
}

#[test]
fn a_thousand_damaged_checkpoints_do_no_harm() {
    const INNER: &str = "MESOFLUX_TEST_WITH_LITTLE_MEMORY";
    if cfg!(not(unix)) || std::env::var_os(INNER).is_some() {
        return meet_a_thousand();
    }
    // With a gigabyte to live on, a huge allocation is the end.
    let program = std::env::current_exe().unwrap();
    let script = "ulimit -v 1000000; exec \"$0\" --nocapture --exact a_thousand_damaged_checkpoints_do_no_harm";
    let output = std::process::Command::new("sh").args(["-c", script]).arg(program).env(INNER, "1").output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
}
