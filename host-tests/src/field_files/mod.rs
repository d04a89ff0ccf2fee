//! Files that other tools of the field open, made of the tables of the codecs: the folder `interop` has them.
//!
//! `cargo run -p host-tests --bin field-files` writes them; a test compares what it would write with what is there.

mod dbc;
mod dbc_layout;
mod eds;

pub use dbc::database;
pub use eds::electronic_data_sheet;

/// A file: its name in the folder `interop`, and what makes its text.
pub type FieldFile = (&'static str, fn() -> String);

/// All of them.
pub const FIELD_FILES: [FieldFile; 2] = [
    ("dyn-can.dbc", database),
    ("zlac8030l.eds", electronic_data_sheet),
];
