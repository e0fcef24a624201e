//! From an input file to transport coefficients with their errors.
