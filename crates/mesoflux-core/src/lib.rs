//! The mesoflux engine.
