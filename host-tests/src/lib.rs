//! Golden vectors, and the functions that hold the crates of this workspace against them.
//!
//! The vectors are JSON lists made by an independent reference, see `vectors/README.md`. They lie in `host-tests/vectors`; the
//! environment variable `VECTORS_DIR` names another folder with the same file names.
//!
//! Each `check` function takes the folder and returns a [`Report`] instead of panicking, so that a test can also show that a damaged
//! vector is noticed. Nothing is skipped: an unknown field, command, option or code is a failure of its vector, and so is a file that is
//! missing or empty.

#![forbid(unsafe_code)]

pub mod arguments;
pub mod campaign;
pub mod canopen_bridge;
pub mod dyn_can_rejects;
pub mod dyn_can_replies;
pub mod dyn_can_requests;
pub mod dyn_serial;
pub mod dyn_units;
pub mod field_files;
pub mod frame_fields;
pub mod options;
pub mod random_driver;
pub mod report;
pub mod rig;
pub mod serial_noise;
pub mod vector_file;
pub mod wire_bits;
pub mod zlac_misc;
pub mod zlac_sdo;

pub use report::{Failure, Report};
pub use vector_file::vectors_dir;

/// The examples of the project's README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
