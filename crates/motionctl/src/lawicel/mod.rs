//! The text protocol of Lawicel serial adapters (CAN232, CANUSB; "slcan"), as far as both ends share it.
//!
//! Source: Lawicel CAN232 manual, version 3. A line is a letter, its parameters in hexadecimal, and CR. The answer to a
//! command is CR, with something before it where there is something to tell, or a lone BEL when it is refused.

mod bit_rate;
mod lines;
mod text;

pub(crate) use bit_rate::{bit_rate_code, kbit_per_s};
pub(crate) use lines::{Lines, Token};
pub(crate) use text::{decode, encode};

/// Ends a line.
pub(crate) const CR: u8 = b'\r';
/// Refuses a command.
pub(crate) const BEL: u8 = 0x07;
