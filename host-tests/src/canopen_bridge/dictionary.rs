//! The object dictionary as tab-separated text.

use std::io::{self, Write};

use zlac8030l::dictionary::{Access, Default, entries};

/// Prints one line an object: index, sub-index, type, access, mappable, default, name.
///
/// # Errors
/// When standard output is closed.
pub fn print() -> io::Result<()> {
    let mut out = io::stdout().lock();
    for entry in entries() {
        let access = match entry.access {
            Access::Ro => "ro",
            Access::Rw | Access::RwS => "rw",
        };
        let default = match entry.default {
            Default::Value(value) => value.to_string(),
            Default::CanId(base) => format!("node+{base}"),
            Default::Unstated => String::new(),
        };
        let (address, data_type, mappable) = (entry.address, entry.data_type, entry.mappable);
        writeln!(
            out,
            "{:04X}\t{:02X}\t{data_type}\t{access}\t{mappable}\t{default}\t{}",
            address.index, address.sub, entry.name
        )?;
    }
    Ok(())
}
