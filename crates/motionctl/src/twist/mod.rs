//! Twists of a vehicle: the options that describe it, and the lines that say how it moves.

mod options;
mod reader;

pub(crate) use options::{TwistOptions, Vehicle};
pub(crate) use reader::{TwistError, TwistLine, TwistReader, read_file};
