//! Where the runs of a job keep their states, so that nothing is lost.

use crate::plan::Task;
use mesoflux_core::simulation::SimulationSnapshot;
use mesoflux_io::checkpoint::{CheckpointError, CheckpointFiles};
use mesoflux_io::directory::{DirectoryError, OutputDirectory};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The version of the state's layout.
const LAYOUT: u32 = 1;

/// How often a run writes its state.
#[derive(Debug, Clone, Copy)]
pub struct Cadence {
    /// After so many steps, if at all.
    pub steps: Option<u64>,
    /// After so much wall time.
    pub wall: Duration,
}

/// The states of all runs of a job, in one directory.
#[derive(Debug, Clone)]
pub struct Store {
    directory: OutputDirectory,
    /// How often states are written.
    pub cadence: Cadence,
}

/// Read before the rest: which layout, and how far.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Header {
    layout: u32,
    steps: u64,
}

/// Everything that one run needs to go on.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunState {
    /// The simulation.
    pub simulation: SimulationSnapshot,
    /// The recorders, in the order of the measurements that use the run; the thermometer last.
    pub recorders: Vec<Vec<u8>>,
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
    /// A state of another kind.
    #[error("the state of a run can't be read: {0}")]
    Layout(#[from] postcard::Error),
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

    /// Writes the state of a run.
    ///
    /// # Errors
    /// A file that can't be written; the states before are then still there.
    pub fn write(&self, files: &mut CheckpointFiles, state: &RunState) -> Result<(), StoreError> {
        let header = Header { layout: LAYOUT, steps: state.simulation.system.step };
        Ok(files.write(&self.directory, &postcard::to_stdvec(&(header, state))?)?)
    }

    /// Reads the newest whole state of a run, if it has any, and what was passed over.
    ///
    /// # Errors
    /// States of which none is whole.
    pub fn read(&self, files: &mut CheckpointFiles) -> Result<Option<(RunState, Vec<CheckpointError>)>, StoreError> {
        let age = |state: &[u8]| {
            let (header, _) = postcard::take_from_bytes::<Header>(state).ok()?;
            (header.layout == LAYOUT).then_some(header.steps)
        };
        let Some(found) = files.read(self.directory.path(), age)? else {
            return Ok(None);
        };
        let (_, state): (Header, RunState) = postcard::from_bytes(&found.state)?;
        Ok(Some((state, found.damaged)))
    }
}
