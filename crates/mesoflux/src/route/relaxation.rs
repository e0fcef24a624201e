//! Whether production lasts long enough for the structure of the fluid to be renewed many times.

use super::Outcome;
use mesoflux_analysis::Estimate;
use mesoflux_core::friction::Friction;
use mesoflux_core::potential::Potential;
use mesoflux_io::input::Input;

/// So many relaxations at least should a replica last.
const FEWEST: f64 = 100.0;

/// The size of a particle: the largest diameter of a hard core, the cutoff of laws that have none, that of the friction where
/// there is no potential.
fn diameter(input: &Input) -> f64 {
    let interactions = input.interactions();
    let size = |law: &Potential| match law.contact_distance() {
        0.0 => law.cutoff(),
        contact => contact,
    };
    let largest = |sizes: &mut dyn Iterator<Item = f64>| sizes.reduce(f64::max);
    largest(&mut interactions.potentials.entries().iter().flatten().map(size))
        .or_else(|| largest(&mut interactions.frictions.entries().iter().flatten().map(Friction::cutoff)))
        .unwrap_or(0.0)
}

/// Adds how many times the structure relaxes in the production of one replica, t 6D/σ², σ being the size of a particle; a warning
/// where these are few.
pub(super) fn report(outcome: &mut Outcome, input: &Input, diffusion: &Estimate) {
    let Some(diffusion) = diffusion.value else { return };
    let relaxations = input.run.production_time * 6.0 * diffusion / diameter(input).powi(2);
    if !relaxations.is_finite() {
        return;
    }
    outcome.conditions.insert("structural_relaxations".to_owned(), relaxations.into());
    if relaxations < FEWEST {
        let warning = format!(
            "the production time of a replica is {relaxations:.2} times the {:.3} in which the structure relaxes; it should be {FEWEST} \
             times as long",
            input.run.production_time / relaxations
        );
        outcome.estimate.warnings.push(warning);
    }
}
