#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod arc;
mod block;
mod error;
mod interpreter;
mod number;
mod words;

pub use error::{ErrorKind, ProgramError};
pub use interpreter::{Action, Actions, Interpreter, Move, Settings};

/// Bytes of the longest line.
pub const LONGEST_LINE: usize = 255;
/// Words of the longest line.
pub const MOST_WORDS: usize = 24;
