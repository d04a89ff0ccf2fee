//! Files that a simulation writes.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use super::error::SimError;

/// Opens a file before a run whose results would have no place.
pub(super) fn create(path: &Path) -> Result<BufWriter<File>, SimError> {
    File::create(path)
        .map(BufWriter::new)
        .map_err(|source| SimError::Write {
            path: path.to_owned(),
            source,
        })
}
