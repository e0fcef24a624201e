//! Where the runs of a job keep their states, so that nothing is lost.

use crate::plan::Task;
use crate::route::RouteRecorder;
use mesoflux_core::pair::KERNEL;
use mesoflux_core::simulation::{Simulation, SimulationSnapshot};
use mesoflux_io::checkpoint::{CheckpointError, CheckpointFiles, StateReader};
use mesoflux_io::directory::{DirectoryError, OutputDirectory};
use mesoflux_io::input::Input;
use mesoflux_io::state::Head;
use mesoflux_io::stream::{self, Count};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often a run writes its state.
#[derive(Debug, Clone, Copy)]
pub struct Cadence {
    /// After so many steps, if at all.
    pub steps: Option<u64>,
    /// After so much wall time, or a hundred times what the last checkpoint took, whichever is longer.
    pub wall: Duration,
}

/// When a run wrote its state, and how long that took.
#[derive(Debug, Clone, Copy)]
pub struct LastKept {
    /// The step of the state.
    pub step: u64,
    at: Instant,
    took: Duration,
}

/// What a state takes to write for each particle, as long as none was written: measured with the longest records there are.
const FIRST_STATE: Duration = Duration::from_micros(5);

impl LastKept {
    /// None is written yet in this session, which begins at `step`.
    pub fn none(step: u64, particles: u64) -> Self {
        Self { step, at: Instant::now(), took: FIRST_STATE.saturating_mul(particles.try_into().unwrap_or(u32::MAX)) }
    }

    /// The state of this step is written now; writing began at `start`.
    pub fn since(start: Instant, step: u64) -> Self {
        let now = Instant::now();
        Self { step, at: now, took: now - start }
    }
}

/// Checkpoints by wall time take no more than one part in so many of it.
const WALL_PER_CHECKPOINT: u32 = 100;

impl Cadence {
    /// Whether a run that has come to `step` must write its state.
    pub fn is_due(&self, step: u64, last: &LastKept) -> bool {
        let wall = self.wall.max(last.took.saturating_mul(WALL_PER_CHECKPOINT));
        self.steps.is_some_and(|steps| step.is_multiple_of(steps)) || last.at.elapsed() >= wall
    }
}

/// The states of all runs of a job, in one directory.
#[derive(Debug, Clone)]
pub struct Store {
    directory: OutputDirectory,
    /// How often states are written.
    pub cadence: Cadence,
}

/// Everything that one run needs to go on, as it is read; `write_state` writes it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunState {
    /// The simulation.
    pub simulation: SimulationSnapshot<'static>,
    /// The recorders, in the order of the measurements that use the run; the thermometer last.
    pub recorders: Vec<Vec<u8>>,
}

/// The head of the state of a run of an input.
pub fn head(input: &Input, step: u64) -> Head {
    let species = input.species().into_iter().map(|(name, _)| name).collect();
    Head::new(step, species, input.bond.keys().cloned().collect())
}

/// Streams the state of a run of an input, behind its head; nothing of it is copied in memory.
///
/// # Errors
/// Those of `out`.
pub fn write_state(
    out: &mut impl Write,
    input: &Input,
    simulation: &Simulation,
    recorders: &[Box<dyn RouteRecorder>],
) -> std::io::Result<()> {
    stream::write(out, &(head(input, simulation.system.step), simulation.snapshot()))?;
    stream::write(out, &(recorders.len() as u64))?;
    for recorder in recorders {
        // Its length comes before its bytes, so it's asked for them twice.
        let mut length = Count::default();
        recorder.save(&mut length)?;
        stream::write(out, &length.0)?;
        recorder.save(out)?;
    }
    Ok(())
}

/// What is there of a run.
#[derive(Debug)]
pub struct Kept {
    /// Its newest whole state.
    pub state: RunState,
    /// The file that holds it.
    pub path: PathBuf,
    /// What a reader must know: files that were passed over.
    pub remarks: Vec<String>,
}

/// A state that can't be kept or found again.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file system refused.
    #[error(transparent)]
    Directory(#[from] DirectoryError),
    /// No whole state is left.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

impl Store {
    /// A store in a directory of its own.
    pub fn new(directory: OutputDirectory, cadence: Cadence) -> Self {
        Self { directory, cadence }
    }

    /// The files of one run.
    pub fn files(&self, task: Task) -> CheckpointFiles {
        CheckpointFiles::new(&format!("point-{}-run-{}-replica-{}", task.point, task.run, task.replica))
    }

    /// Writes the state of a run of an input.
    ///
    /// # Errors
    /// A file that can't be written; the states before are then still there.
    pub fn write(
        &self,
        files: &mut CheckpointFiles,
        input: &Input,
        simulation: &Simulation,
        recorders: &[Box<dyn RouteRecorder>],
    ) -> Result<(), StoreError> {
        Ok(files.write(&self.directory, |out| write_state(out, input, simulation, recorders))?)
    }

    /// Reads the newest whole state of a run, if it has any.
    ///
    /// # Errors
    /// States of which none is whole.
    pub fn read(&self, files: &mut CheckpointFiles) -> Result<Option<Kept>, StoreError> {
        let Some(found) = files.read(self.directory.path(), |state| Ok(Head::read(state)?.steps), decode)? else {
            return Ok(None);
        };
        let step = found.state.simulation.system.step;
        let remarks = found.damaged.iter().map(|damaged| {
            format!("{damaged}; passed over, went on at step {step} from the whole state in {}", found.path.display())
        });
        Ok(Some(Kept { remarks: remarks.collect(), state: found.state, path: found.path }))
    }
}

fn decode(values: &mut StateReader) -> Result<RunState, String> {
    let head = Head::read(values)?;
    if head.kernel != KERNEL {
        return Err(format!(
            "was computed by the kernels \"{}\": must be \"{KERNEL}\", to go on to the same bits",
            head.kernel
        ));
    }
    let state: RunState = values.next_value().map_err(|error| format!("holds a state that can't be read: {error}"))?;
    if values.left() > 0 {
        return Err(format!("has {} bytes after the state: must have none", values.left()));
    }
    let (said, step) = (head.steps, state.simulation.system.step);
    if said != step {
        return Err(format!("says that it is of step {said}: must be {step}, as the state in it"));
    }
    Ok(state)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesoflux_io::checkpoint::StateWriter;

    #[test]
    fn a_state_of_other_kernels_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(
            OutputDirectory::explicit(folder.path(), true).unwrap(),
            Cadence { steps: None, wall: Duration::MAX },
        );
        let mut head = Head::new(0, Vec::new(), Vec::new());
        head.kernel = "abacus".to_owned();
        let mut files = CheckpointFiles::new("run");
        let none: [Vec<u8>; 0] = [];
        let write = |out: &mut StateWriter| stream::write(out, &(head, simulation().snapshot(), none.as_slice()));
        files.write(&store.directory, write).unwrap();
        let refused = store.read(&mut CheckpointFiles::new("run")).unwrap_err().to_string();
        assert!(
            refused.contains(&format!("was computed by the kernels \"abacus\": must be \"{KERNEL}\"")),
            "{refused}"
        );
    }

    /// Two particles at rest.
    fn simulation() -> Simulation {
        use mesoflux_core::boundary::PeriodicBox;
        use mesoflux_core::{
            domain::Workers, integrate, interactions::Interactions, noise::NoiseKey, state::Particles,
        };
        use mesoflux_core::{friction::Friction, system::System};
        let friction =
            Friction::Linear(mesoflux_core::friction::linear::Linear { coefficient: 1.0, cutoff: 1.0, exponent: 2.0 });
        let particles = Particles::at_rest(vec![[0.5; 3], [1.5; 3]], vec![0; 2], &[1.0]);
        let region = PeriodicBox::new([4.0; 3]).unwrap();
        let laws = Interactions::uniform(None, Some(friction), 1.0);
        let system = System::new(particles, region, laws, 0.3, Workers::One).unwrap();
        let integrator = integrate::Integrator::VelocityVerlet(integrate::VelocityVerlet::new(
            1.0,
            0.5,
            mesoflux_core::friction::fluctuation_dissipation::Correction::default(),
        ));
        Simulation::new(system, integrator, None, NoiseKey::new(&[1]), 0.01).unwrap()
    }

    #[test]
    fn a_state_is_due_by_steps_or_by_wall_time_but_costs_at_most_a_hundredth() {
        let cadence = Cadence { steps: Some(5), wall: Duration::from_secs(10) };
        let last = |ago, took| {
            let at = Instant::now().checked_sub(Duration::from_secs(ago)).unwrap();
            LastKept { step: 0, at, took: Duration::from_secs(took) }
        };
        assert!(!cadence.is_due(4, &last(9, 0)));
        assert!(cadence.is_due(5, &last(0, 9)), "steps are the user's word");
        assert!(cadence.is_due(4, &last(11, 0)));
        assert!(!cadence.is_due(4, &last(199, 2)));
        assert!(cadence.is_due(4, &last(201, 2)));
    }
}
