//! Reads CAN logs and follows the conversation on the bus: frames with time in, described messages out.
//!
//! Sans-I/O: [`log::LogReader`] takes lines, [`Decoder`] takes frames with their time; neither opens a file, reads a
//! clock or waits. A live interface needs the decoder alone.
//!
//! | Module | What |
//! |---|---|
//! | [`frame`] | a CAN frame as a log or an interface reports it |
//! | [`log`] | the text logs of candump and python-can, line by line, with errors that say what was expected |
//! | [`conversation`] | the seam between the decoder and the protocols on a bus |
//! | [`dyn_drives`] | DYN drives: which side sent a frame, what it means, in words and as values |
//! | [`canopen`] | ZLAC8030L hub-motor drives on CANopen, with the objects in their PDOs |
//! | [`decoder`] | asks the protocols in turn |
//! | [`statistics`] | frames, intervals and response times of each identifier |
//!
//! ```
//! use can_decode::{Decoder, Frame};
//!
//! let mut decoder = Decoder::default();
//! let request = Frame::new(0x029, false, &[]).unwrap();
//! let reply = Frame::new(0x029, false, &[0x02]).unwrap();
//! assert_eq!(
//!     decoder.hear(1_000_000, &request).to_string(),
//!     "to drive 1    Read_Drive_Status: read the status"
//! );
//! assert_eq!(
//!     decoder.hear(1_600_000, &reply).to_string(),
//!     "from drive 1  Read_Drive_Status: on position, disabled, no alarm (0.600 ms after the request)"
//! );
//! ```

#![forbid(unsafe_code)]

pub mod canopen;
pub mod conversation;
pub mod decoder;
pub mod dyn_drives;
pub mod frame;
pub mod log;
pub mod statistics;

pub use conversation::{Conversation, Direction};
pub use decoder::{Decoder, Meaning};
pub use frame::Frame;
