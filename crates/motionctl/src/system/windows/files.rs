//! Files.

use std::fs::File;
use std::io;
use std::os::windows::fs::FileExt;

/// Reads from a place in a file that several readings share.
///
/// # Errors
/// Of the file.
pub(crate) fn read_at(file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    match file.seek_read(buffer, at) {
        // The end of the file (ERROR_HANDLE_EOF) is no error elsewhere.
        Err(error) if error.raw_os_error() == Some(38) => Ok(0),
        read => read,
    }
}
