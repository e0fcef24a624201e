//! The command line of mesoflux.
fn main() {}
