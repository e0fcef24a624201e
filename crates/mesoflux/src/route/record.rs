//! What a run leaves for the estimators: accumulators of bounded size that replicas merge into.

use super::RouteError;
use super::correlation::Correlations;
use super::driven::DrivenRecord;
use super::momentum_exchange::ExchangeRecord;
use super::speed_distribution::SpeedRecord;
use mesoflux_analysis::{Blocking, Histogram, MeanSquaredDisplacement};

/// The record of a run, or of several replicas merged.
#[derive(Debug, Clone)]
pub enum Record {
    /// A vector-valued series.
    Series(Blocking),
    /// Mean squared displacements.
    Displacement(MeanSquaredDisplacement),
    /// Series of their own, one for each number of a profile.
    Profile(Vec<Blocking>),
    /// Counts of an observable's values.
    Histogram(Histogram),
    /// Correlations in time.
    Correlations(Box<Correlations>),
    /// Of a driven run.
    Driven(Box<DrivenRecord>),
    /// Of a run by momentum exchange.
    Exchange(Box<ExchangeRecord>),
    /// Of the particles' speeds.
    Speeds(Box<SpeedRecord>),
}

impl Record {
    /// Adds the record of another replica.
    ///
    /// # Errors
    /// Records of different kinds.
    pub fn merge(&mut self, other: &Self) -> Result<(), RouteError> {
        match (self, other) {
            (Self::Series(mine), Self::Series(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Displacement(mine), Self::Displacement(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Profile(mine), Self::Profile(theirs)) if mine.len() == theirs.len() => {
                Ok(mine.iter_mut().zip(theirs).try_for_each(|(mine, theirs)| mine.merge(theirs))?)
            }
            (Self::Histogram(mine), Self::Histogram(theirs)) => Ok(mine.merge(theirs)?),
            (Self::Correlations(mine), Self::Correlations(theirs)) => mine.merge(theirs),
            (Self::Driven(mine), Self::Driven(theirs)) => mine.merge(theirs),
            (Self::Exchange(mine), Self::Exchange(theirs)) => mine.merge(theirs),
            (Self::Speeds(mine), Self::Speeds(theirs)) => mine.merge(theirs),
            _ => Err(RouteError::WrongRecord),
        }
    }

    /// What a driven run left, for a route that drives.
    ///
    /// # Errors
    /// Another kind of record.
    pub fn driven(&self) -> Result<&DrivenRecord, RouteError> {
        match self {
            Self::Driven(record) => Ok(record),
            _ => Err(RouteError::WrongRecord),
        }
    }

    /// The correlations, for a route that records them.
    ///
    /// # Errors
    /// Another kind of record.
    pub fn correlations(&self) -> Result<&Correlations, RouteError> {
        match self {
            Self::Correlations(correlations) => Ok(correlations),
            _ => Err(RouteError::WrongRecord),
        }
    }

    /// The series, for a route that records one.
    ///
    /// # Errors
    /// Another kind of record.
    pub fn series(&self) -> Result<&Blocking, RouteError> {
        match self {
            Self::Series(series) => Ok(series),
            _ => Err(RouteError::WrongRecord),
        }
    }
}
