//! Words: which letters act in which order, each for its share of the time step.

use super::{Drift, Kick, Langevin, Letter, PairOrnsteinUhlenbeck, ParticleOrnsteinUhlenbeck, SweepOrder, Thermostat};
use crate::lanes::Row;
use crate::system::System;

/// A word that is no integrator.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WordError {
    /// A letter nobody knows.
    #[error("the letter '{0}' is unknown: must be one of A (drift), B (kick), O (thermostat)")]
    UnknownLetter(char),
    /// A letter without which nothing moves.
    #[error("the letter '{0}' is missing: a word needs at least one A (drift) and one B (kick)")]
    MissingLetter(char),
    /// A thermostat that never acts.
    #[error(
        "the letter 'O' is missing: with a thermostat, a word needs at least one O; use thermostat = \"none\" for constant energy"
    )]
    MissingThermostat,
    /// A letter O that stands for nothing.
    #[error("the letter 'O' has no meaning with thermostat = \"none\": must be left out")]
    NoThermostat,
}

/// A word made ready: its letters, each with its share of the time step.
#[derive(Debug)]
pub struct Schedule {
    word: String,
    entries: Vec<(Box<dyn Letter>, f64)>,
    sweep: SweepOrder,
    temperature: f64,
}

impl Schedule {
    /// Reads a word such as "ABOBA"; the shares of each letter are equal and sum to one.
    ///
    /// # Errors
    /// Unknown or missing letters.
    pub fn new(word: &str, thermostat: Thermostat, temperature: f64, sweep: SweepOrder) -> Result<Self, WordError> {
        let letter = |symbol: char| -> Result<Box<dyn Letter>, WordError> {
            Ok(match (symbol, thermostat) {
                ('A', _) => Box::new(Drift),
                ('B', _) => Box::new(Kick),
                ('O', Thermostat::PairOrnsteinUhlenbeck) => Box::new(PairOrnsteinUhlenbeck { temperature }),
                ('O', Thermostat::Langevin(Langevin { friction })) => {
                    Box::new(ParticleOrnsteinUhlenbeck { temperature, friction })
                }
                ('O', Thermostat::None) => return Err(WordError::NoThermostat),
                _ => return Err(WordError::UnknownLetter(symbol)),
            })
        };
        let share = |symbol: char| 1.0 / word.chars().filter(|&other| other == symbol).count() as f64;
        let entries = word.chars().map(|symbol| Ok((letter(symbol)?, share(symbol)))).collect::<Result<_, _>>()?;
        for required in ['A', 'B'] {
            if !word.contains(required) {
                return Err(WordError::MissingLetter(required));
            }
        }
        if thermostat != Thermostat::None && !word.contains('O') {
            return Err(WordError::MissingThermostat);
        }
        Ok(Self { word: word.to_owned(), entries, sweep, temperature })
    }

    /// kT of its thermostat.
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// The word.
    pub fn word(&self) -> &str {
        &self.word
    }

    /// The letters in the order in which they act, each with its share of the time step.
    pub fn entries(&self) -> &[(Box<dyn Letter>, f64)] {
        &self.entries
    }

    /// G·(the friction force of all letters) at the present state, for a response G in storage order.
    pub fn dissipative_flux(&self, system: &mut System, response: &[Row]) -> f64 {
        self.entries.iter().map(|(letter, share)| share * letter.dissipative_flux(system, response)).sum()
    }

    /// Whether the sweeps of a step go backward.
    pub fn backward(&self, step: u64) -> bool {
        self.sweep == SweepOrder::Alternating && step % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(word: &str, thermostat: Thermostat) -> Result<Schedule, WordError> {
        Schedule::new(word, thermostat, 1.0, SweepOrder::Forward)
    }

    #[test]
    fn shares_of_each_letter_sum_to_one() {
        for word in ["ABOBA", "OBABO", "BAOAB", "ABOBAO", "AABO"] {
            let schedule = schedule(word, Thermostat::PairOrnsteinUhlenbeck).unwrap();
            for symbol in "ABO".chars() {
                let entries = schedule.entries().iter().filter(|(letter, _)| letter.symbol() == symbol);
                let total: f64 = entries.map(|(_, share)| share).sum();
                assert!((total - 1.0).abs() < 1e-15, "{word}: {symbol}");
            }
        }
    }

    #[test]
    fn words_that_integrate_nothing_are_refused() {
        use Thermostat::{None, PairOrnsteinUhlenbeck};
        let refused = |word, thermostat| schedule(word, thermostat).err();
        assert_eq!(refused("ABXBA", PairOrnsteinUhlenbeck), Some(WordError::UnknownLetter('X')));
        assert_eq!(refused("BOB", PairOrnsteinUhlenbeck), Some(WordError::MissingLetter('A')));
        assert_eq!(refused("", None), Some(WordError::MissingLetter('A')));
        assert_eq!(refused("BAB", PairOrnsteinUhlenbeck), Some(WordError::MissingThermostat));
        assert_eq!(refused("ABOBA", None), Some(WordError::NoThermostat));
        assert_eq!(
            refused("BAB", Thermostat::Langevin(Langevin { friction: 1.0 })),
            Some(WordError::MissingThermostat)
        );
        assert!(schedule("BAB", None).is_ok());
    }
}
