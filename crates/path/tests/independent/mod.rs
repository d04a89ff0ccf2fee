//! What the tests of paths share: the judge, and a rig that feeds a path.
#![allow(dead_code)]

mod judge;
pub(crate) mod rig;

pub(crate) use judge::{Ideal, judge};
