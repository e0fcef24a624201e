//! One simulation: a system, an integrator, a driving and the noise of the run, moved on step by step.

use crate::driving::{DrivenStep, Driving, Exchanged};
use crate::forcing::ForcingError;
use crate::integrate::{Integrator, Stroke};
use crate::noise::NoiseKey;
use crate::observable::BookedStress;
use crate::pair::PairStress;
use crate::snapshot::{Snapshot, SnapshotError};
use crate::state::Column;
use crate::system::{SimulationError, System};
use serde::{Deserialize, Serialize};

/// A simulation that can't be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A forcing that the system can't take.
    #[error(transparent)]
    Forcing(#[from] ForcingError),
    /// A driving with an integrator that has no letters.
    #[error(
        "a driven run needs a splitting word such as \"ABOBA\": other schemes have no letters between which to act"
    )]
    DrivingNeedsWord,
    /// A letter that can't say what Norton dynamics needs to book.
    #[error("the letter '{0}' can't tell the expected part of its change of the flux: constant flux is refused")]
    LetterCannotTell(char),
}

/// The whole state of a simulation between two steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SimulationSnapshot<'a> {
    /// Particles, list, step.
    pub system: Snapshot<'a>,
    /// Where velocity Verlet keeps its forces.
    pub velocity_verlet: Option<Column>,
    /// The stress of these forces, where it is booked.
    pub velocity_verlet_stress: Option<PairStress>,
    /// What the driving remembers.
    pub driving: Vec<f64>,
}

/// A simulation under way.
#[derive(Debug)]
pub struct Simulation {
    /// The state.
    pub system: System,
    integrator: Integrator,
    driving: Option<Box<dyn Driving>>,
    noise: NoiseKey,
    time_step: f64,
    books_stress: bool,
    booked: Option<BookedStress>,
}

impl Simulation {
    /// Brings the parts together and lets the driving prepare the state.
    ///
    /// # Errors
    /// A driving that doesn't fit the integrator or the system.
    pub fn new(
        system: System,
        integrator: Integrator,
        mut driving: Option<Box<dyn Driving>>,
        noise: NoiseKey,
        time_step: f64,
    ) -> Result<Self, SetupError> {
        let mut system = system.with_integrator(&integrator);
        if let Some(driving) = &mut driving {
            if let Integrator::Splitting(schedule) = &integrator {
                let mute = schedule.entries().iter().find(|(letter, _)| !letter.tells_expected_flux());
                if let (true, Some((letter, _))) = (driving.needs_expected_flux(), mute) {
                    return Err(SetupError::LetterCannotTell(letter.symbol()));
                }
            } else if driving.needs_word() {
                return Err(SetupError::DrivingNeedsWord);
            }
            driving.begin(&mut system)?;
        }
        Ok(Self { system, integrator, driving, noise, time_step, books_stress: false, booked: None })
    }

    /// Whether every step from now on books the momentum flux that it makes; this costs time and changes no trajectory.
    ///
    /// Velocity Verlet kicks with a force twice, at the end of the step that worked it out and at the beginning of the next: its
    /// first step books only if it is the very first, or if the step before has booked.
    pub fn book_stress(&mut self, on: bool) {
        self.books_stress = on;
        self.booked = None;
    }

    /// The momentum flux of the last step, over Δt, if it was booked.
    pub fn booked_stress(&self) -> Option<&BookedStress> {
        self.booked.as_ref()
    }

    /// The whole state, between two steps.
    pub fn snapshot(&self) -> SimulationSnapshot<'_> {
        let (velocity_verlet, velocity_verlet_stress) = match &self.integrator {
            Integrator::VelocityVerlet(scheme) => (scheme.force_column(), scheme.force_stress()),
            Integrator::Splitting(_) | Integrator::Explicit(_) => (None, None),
        };
        let driving = self.driving.as_ref().map_or_else(Vec::new, |driving| driving.memory());
        SimulationSnapshot { system: self.system.snapshot(), velocity_verlet, velocity_verlet_stress, driving }
    }

    /// Goes on from a state that `snapshot` gave, to the same bits.
    ///
    /// # Errors
    /// A snapshot that doesn't fit.
    pub fn restore(&mut self, snapshot: SimulationSnapshot) -> Result<(), SnapshotError> {
        self.system.restore(snapshot.system)?;
        self.booked = None;
        let remembered = match &mut self.driving {
            Some(driving) => driving.remember(&snapshot.driving),
            None => snapshot.driving.is_empty(),
        };
        if !remembered {
            return Err(SnapshotError::Inconsistent);
        }
        match (&mut self.integrator, snapshot.velocity_verlet) {
            (Integrator::VelocityVerlet(scheme), column)
                if column.is_none_or(|column| self.system.particles.has_column(column)) =>
            {
                scheme.resume(column, snapshot.velocity_verlet_stress);
                Ok(())
            }
            (Integrator::Splitting(_) | Integrator::Explicit(_), None) => Ok(()),
            _ => Err(SnapshotError::Inconsistent),
        }
    }

    /// One time step.
    ///
    /// Returns flux and forcing of the step where a driving acts.
    ///
    /// # Errors
    /// A state that is no longer finite.
    pub fn step(&mut self) -> Result<Option<DrivenStep>, SimulationError> {
        self.system.booked = self.books_stress.then(BookedStress::default);
        match &mut self.integrator {
            Integrator::VelocityVerlet(scheme) => scheme.step(&mut self.system, self.noise, self.time_step)?,
            Integrator::Explicit(scheme) => scheme.step(&mut self.system, self.noise, self.time_step)?,
            Integrator::Splitting(schedule) => {
                let backward = schedule.backward(self.system.step);
                for (place, (letter, share)) in schedule.entries().iter().enumerate() {
                    let time = share * self.time_step;
                    if let Some(driving) = &mut self.driving {
                        driving.before_letter(&mut self.system, letter.symbol(), time);
                    }
                    let constraint = self.driving.as_mut().and_then(|driving| driving.constraint(&self.system));
                    let response = constraint.map(|constraint| constraint.response);
                    let stroke =
                        Stroke { time, place: place as u64, noise: self.noise, backward, response, constraint };
                    let change = letter.apply(&mut self.system, &stroke)?;
                    if let Some(driving) = &mut self.driving {
                        driving.after_letter(&mut self.system, letter.symbol(), time, change);
                    }
                }
            }
        }
        self.system.step += 1;
        let time_step = self.time_step;
        self.booked = self.system.booked.take().map(|booked| booked.scaled(1.0 / time_step));
        Ok(self.driving.as_mut().and_then(|driving| driving.end_step(&mut self.system, time_step)))
    }

    /// What was exchanged in and after the last step, where the driving exchanges momentum.
    pub fn exchanged(&self) -> Option<Exchanged> {
        self.driving.as_ref()?.exchanged()
    }

    /// Δt.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// λ(q, p) at the present state, where the driving holds a flux.
    pub fn forcing_observable(&mut self) -> Option<f64> {
        match (&mut self.driving, &self.integrator) {
            (Some(driving), Integrator::Splitting(schedule)) => driving.forcing_observable(&mut self.system, schedule),
            _ => None,
        }
    }
}
