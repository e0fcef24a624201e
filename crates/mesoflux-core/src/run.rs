//! The driver of one run: equilibration, production, recorders at their cadence, and a word from outside at every step.

use crate::driving::{DrivenStep, Exchanged};
use crate::observable::BookedStress;
use crate::simulation::Simulation;
use crate::system::SimulationError;

/// What a recorder sees after a step of production.
#[derive(Debug)]
pub struct Moment<'a> {
    /// The simulation; reading observables may bring its forces up to date but changes no trajectory.
    pub simulation: &'a mut Simulation,
    /// Steps of production done.
    pub step: u64,
    /// Flux and forcing of the step just done, where a driving has any.
    pub driven: Option<DrivenStep>,
}

impl Moment<'_> {
    /// The momentum flux of the step just done, over Δt, where the simulation books it.
    pub fn stress(&self) -> Option<&BookedStress> {
        self.simulation.booked_stress()
    }

    /// What was exchanged in and after the step just done, where the driving exchanges momentum.
    pub fn exchanged(&self) -> Option<Exchanged> {
        self.simulation.exchanged()
    }
}

/// Takes samples along the production run.
pub trait Recorder: Send {
    /// Looks at the state after every step of production; most recorders act only at their cadence.
    fn observe(&mut self, moment: &mut Moment);
}

/// How long a run lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Length {
    /// Steps before anything is recorded.
    pub equilibration: u64,
    /// Steps that are recorded.
    pub production: u64,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// All steps were done.
    Complete,
    /// The supervisor stopped it.
    Stopped,
}

/// Runs a simulation on from where it is, to the end of its length.
///
/// `supervise` sees simulation and recorders after every step, and stops the run by answering `false`.
///
/// # Errors
/// A state that is no longer finite.
pub fn run<R: Recorder>(
    simulation: &mut Simulation,
    length: Length,
    recorders: &mut [R],
    mut supervise: impl FnMut(&Simulation, &[R]) -> bool,
) -> Result<Ending, SimulationError> {
    while simulation.system.step < length.equilibration + length.production {
        let driven = simulation.step()?;
        if let Some(step) = simulation.system.step.checked_sub(length.equilibration).filter(|&step| step > 0) {
            let mut moment = Moment { simulation, step, driven };
            recorders.iter_mut().for_each(|recorder| recorder.observe(&mut moment));
        }
        if !supervise(simulation, recorders) {
            return Ok(Ending::Stopped);
        }
    }
    Ok(Ending::Complete)
}
