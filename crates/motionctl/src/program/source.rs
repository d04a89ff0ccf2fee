//! The file of a program: read twice, line by line.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use program::LONGEST_LINE;

use super::error::ProgramFileError;
use crate::system::read_at;

const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// An open program. Every reading is of the file that was opened, whatever takes its name in the meantime.
#[derive(Debug, Clone)]
pub(crate) struct ProgramFile {
    pub(crate) path: PathBuf,
    file: Arc<File>,
}

impl ProgramFile {
    pub(crate) fn open(path: &Path) -> Result<Self, ProgramFileError> {
        let open = || {
            let file = File::open(path)?;
            if file.metadata()?.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            Ok(Arc::new(file))
        };
        Ok(Self {
            path: path.to_owned(),
            file: open().map_err(|source| ProgramFileError::Read {
                path: path.to_owned(),
                source,
            })?,
        })
    }

    /// From the first line.
    pub(crate) fn lines(&self) -> Lines {
        Lines {
            reader: BufReader::new(Reading {
                file: Arc::clone(&self.file),
                at: 0,
            }),
            path: self.path.clone(),
            is_first: true,
            bytes: Vec::new(),
            text: String::new(),
        }
    }
}

/// A place in a file that several readings share.
#[derive(Debug)]
struct Reading {
    file: Arc<File>,
    at: u64,
}

impl Read for Reading {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = read_at(&self.file, buffer, self.at)?;
        self.at += read as u64;
        Ok(read)
    }
}

/// Lines in the memory of one.
#[derive(Debug)]
pub(crate) struct Lines {
    reader: BufReader<Reading>,
    pub(crate) path: PathBuf,
    is_first: bool,
    bytes: Vec<u8>,
    text: String,
}

impl Lines {
    /// The next line; `None` behind the last one. Of a line that is too long, only so much that it is seen to be.
    pub(crate) fn next(&mut self) -> Result<Option<&str>, ProgramFileError> {
        self.bytes.clear();
        let most = LONGEST_LINE as u64 + 3;
        let read = (&mut self.reader)
            .take(most)
            .read_until(b'\n', &mut self.bytes);
        match read {
            Ok(0) => return Ok(None),
            Ok(_) => {}
            Err(source) => {
                return Err(ProgramFileError::Read {
                    path: self.path.clone(),
                    source,
                });
            }
        }
        // Editors put it in front of a file.
        if self.is_first && self.bytes.starts_with(BYTE_ORDER_MARK) {
            self.bytes.drain(..BYTE_ORDER_MARK.len());
        }
        self.is_first = false;
        // What is no UTF-8 stays in comments, and is refused elsewhere.
        self.text = String::from_utf8_lossy(&self.bytes).into_owned();
        Ok(Some(&self.text))
    }
}
