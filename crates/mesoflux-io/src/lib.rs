//! The files of mesoflux: what a run is asked (`input`) and what it answers (`results`, `directory`).

pub mod checkpoint;
pub mod configuration;
pub mod directory;
pub mod input;
pub mod results;
pub mod state;
pub mod stream;
