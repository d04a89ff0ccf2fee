//! The settings as a TOML file.
//!
//! [`read`] takes a text, [`write()`] makes one: reading what was written gives the same settings.

mod error;
mod reader;
mod reader_of_homing;
mod writer;

pub use error::{FileError, Place};
pub use reader::{SettingsFile, read};
pub use writer::write;

/// The layout of the file.
const FORMAT: i64 = 1;
