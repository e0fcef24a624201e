//! Temperatures, energy and pressure of one configuration.

use crate::interactions::Interactions;
use crate::system::System;
use crate::vector::dot;

/// The thermodynamic state of one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermodynamics {
    /// kT from the momenta, Σ p²/m over the degrees of freedom.
    pub kinetic_temperature: f64,
    /// U.
    pub potential_energy: f64,
    /// P = ρ kT_kinetic + Σ r f(r)/(3V) over pairs and bonds.
    ///
    /// The kinetic part uses the kinetic temperature, so that the three degrees of freedom which the conserved total momentum
    /// takes away leave no bias of order 1/N. In an external field it is no pressure of anything.
    pub pressure: f64,
    /// Σ |∇_i U|².
    pub force_squared: f64,
    /// Σ ∇_i² U; the configurational temperature is the ratio of the averages ⟨|∇U|²⟩/⟨∇²U⟩.
    pub laplacian: f64,
}

/// An observable that the laws don't allow.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ObservableError {
    /// The virial lacks the impulses at the cutoff.
    #[error(
        "the energy of a potential jumps by {0:.3e} at its cutoff: the virial pressure would lack the impulses there; choose truncation = \"shifted\" or \"force_shifted\""
    )]
    EnergyJump(f64),
    /// The Laplacian lacks a delta function.
    #[error(
        "the force of a potential jumps by {0:.3e} at its cutoff: the configurational temperature would lack the delta function of ∇²U there; choose truncation = \"force_shifted\""
    )]
    ForceJump(f64),
    /// Nothing to measure.
    #[error("no pair of species has a potential: there is no configurational temperature of an ideal fluid")]
    NoPotential,
}

/// Rounding of a force-shifted law leaves this much at the cutoff, relative to its value at 0.9 of it.
const ROUNDING: f64 = 1e-9;

/// Whether every potential ends without a jump of its energy, so that the virial is the whole pressure.
///
/// # Errors
/// The jump.
pub fn check_pressure(interactions: &Interactions) -> Result<(), ObservableError> {
    for law in interactions.potentials.entries().iter().flatten() {
        if law.energy_jump().abs() > ROUNDING * law.energy(0.9 * law.cutoff()).abs() {
            return Err(ObservableError::EnergyJump(law.energy_jump()));
        }
    }
    Ok(())
}

/// Whether every potential ends without a jump of its force, so that ∇²U has no delta functions.
///
/// # Errors
/// The jump, or no potential at all.
pub fn check_configurational_temperature(interactions: &Interactions) -> Result<(), ObservableError> {
    let mut laws = interactions.potentials.entries().iter().flatten().peekable();
    if laws.peek().is_none() {
        return Err(ObservableError::NoPotential);
    }
    for law in laws {
        if law.force_jump().abs() > ROUNDING * law.force(0.9 * law.cutoff()).abs() {
            return Err(ObservableError::ForceJump(law.force_jump()));
        }
    }
    Ok(())
}

impl Thermodynamics {
    /// Reads a system at its present positions and momenta.
    pub fn of(system: &mut System) -> Self {
        system.update_forces();
        let workers = system.workers;
        let sums = system.pair_sums();
        let count = system.particles.count();
        let kinetic_temperature = system.kinetic_temperature();
        let volume = system.region.volume();
        let forces = system.forces();
        Self {
            kinetic_temperature,
            potential_energy: sums.potential_energy,
            pressure: count as f64 / volume * kinetic_temperature + sums.virial / (3.0 * volume),
            force_squared: workers.sum(count, |k| dot(forces[k].vector(), forces[k].vector())),
            laplacian: sums.laplacian,
        }
    }
}
