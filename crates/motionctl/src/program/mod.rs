//! A program of G-code as a source of set-points.
//!
//! Data flows one way: [`source`] reads lines from the file, the crate `program` makes moves of them, [`player`] feeds them to the crate
//! `path` and returns the command counts of every cycle. [`check`] plays the whole program before anything moves and keeps its peaks;
//! the run plays it again, from the same open file, as [`in_motion`] with the orders of
//! whoever watches it. [`machine`] has the motors, [`machine_file`] reads them from a file. [`options`] is all of it as options of a command line, [`report`] what the program is
//! about to do, and [`picture`] its path as SVG.

mod check;
mod error;
mod in_motion;
mod machine;
mod machine_file;
mod options;
mod picture;
mod player;
mod report;
mod source;

pub(crate) use check::Checked;
pub(crate) use error::ProgramFileError;
pub(crate) use in_motion::ProgramInMotion;
pub(crate) use machine::MachineSetup;
pub(crate) use options::{Axes, ProgramOptions};
use player::Player;
pub(crate) use report::ProgramReport;
pub(crate) use source::ProgramFile;
