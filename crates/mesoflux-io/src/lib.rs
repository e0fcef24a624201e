//! Input and result files of mesoflux.
