//! What checks the solver without sharing anything with it: cases by name, a judge, and another solver.
#![allow(
    dead_code,
    reason = "each test and example uses its own part of this module"
)]

pub(crate) mod cases;
pub(crate) mod fastest_stop;
pub(crate) mod judge;
pub(crate) mod optimum;
pub(crate) mod random;
