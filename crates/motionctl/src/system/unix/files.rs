//! Files.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Reads from a place in a file that several readings share.
///
/// # Errors
/// Of the file.
pub(crate) fn read_at(file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    file.read_at(buffer, at)
}
