//! From an input file to transport coefficients with their errors.
//!
//! A [`route`] says which runs a coefficient needs and turns their records into an estimate; [`job::perform`] does the runs
//! of all routes, sweep points and replicas side by side on the cores; [`report`] shows what came out.

pub mod answer;
pub mod command;
pub mod figure;
mod finite_size;
pub mod job;
pub mod long_wave;
pub mod plan;
pub mod prediction;
pub mod progress;
pub mod report;
pub mod response_figure;
pub mod route;
mod setup;
pub mod store;
pub mod study;
