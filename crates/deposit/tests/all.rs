//! All tests of deposits as one program, which is built and run sooner than one for each file.

mod coats;
mod condensation;
mod rain;
