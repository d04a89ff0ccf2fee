//! The lines of a text file, one at a time and never more of it than one line.

use std::io::BufRead;

use super::error::{Place, TrajectoryError};

/// Longest line that is read, in bytes: 2000 columns of 30 digits.
pub(super) const LONGEST_LINE: usize = 65_536;

/// UTF-8 byte order mark, which editors of Windows write.
const UTF8_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];
/// UTF-16 byte order marks, little and big endian.
const UTF16_MARKS: [[u8; 2]; 2] = [[0xFF, 0xFE], [0xFE, 0xFF]];

/// Reads lines that end in LF, CR LF or CR, without their ends.
pub(super) struct Lines<R> {
    input: R,
    line: Vec<u8>,
    number: u64,
    /// The line before ended in CR: an LF now belongs to it.
    after_cr: bool,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            line: Vec::new(),
            number: 0,
            after_cr: false,
        }
    }

    /// The next line and its number from 1; bytes that are no UTF-8 become U+FFFD.
    pub(super) fn next(&mut self) -> Result<Option<(u64, String)>, TrajectoryError> {
        self.line.clear();
        self.number += 1;
        if !self.fill()? {
            return Ok(None);
        }
        if self.number == 1 {
            if UTF16_MARKS.iter().any(|mark| self.line.starts_with(mark)) {
                return Err(TrajectoryError::Encoding { line: 1 });
            }
            if self.line.starts_with(&UTF8_MARK) {
                self.line.drain(..UTF8_MARK.len());
            }
        }
        if self.line.contains(&0) {
            return Err(TrajectoryError::Encoding { line: self.number });
        }
        let text = String::from_utf8_lossy(&self.line).into_owned();
        Ok(Some((self.number, text)))
    }

    /// Collects one line; false at the end of the file.
    fn fill(&mut self) -> Result<bool, TrajectoryError> {
        let mut is_empty = true;
        loop {
            let bytes = self.input.fill_buf();
            let bytes = bytes.map_err(|error| TrajectoryError::Unreadable {
                line: self.number,
                reason: error.to_string(),
            })?;
            if bytes.is_empty() {
                return Ok(!is_empty);
            }
            if core::mem::take(&mut self.after_cr) && bytes[0] == b'\n' {
                self.input.consume(1);
                continue;
            }
            is_empty = false;
            let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let part = &bytes[..end.unwrap_or(bytes.len())];
            if self.line.len() + part.len() > LONGEST_LINE {
                return Err(TrajectoryError::LongLine {
                    place: Place::line(self.number),
                });
            }
            self.line.extend_from_slice(part);
            self.after_cr = end.is_some_and(|end| bytes[end] == b'\r');
            let used = end.map_or(bytes.len(), |end| end + 1);
            self.input.consume(used);
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<(u64, String)> {
        // A reader of three bytes at a time meets line ends at every place of its buffer.
        let mut lines = Lines::new(std::io::BufReader::with_capacity(3, bytes));
        core::iter::from_fn(|| lines.next().unwrap()).collect()
    }

    #[test]
    fn every_line_end_counts_once() {
        for text in ["a\nbcd\n\ne", "a\r\nbcd\r\n\r\ne\r\n", "a\rbcd\r\re\r"] {
            let expected = [(1, "a"), (2, "bcd"), (3, ""), (4, "e")];
            let expected = expected.map(|(number, line)| (number, line.to_owned()));
            assert_eq!(lines(text.as_bytes()), expected, "{text:?}");
        }
    }

    #[test]
    fn marks_of_the_encoding() {
        assert_eq!(lines(b"\xEF\xBB\xBFa\n"), [(1, "a".to_owned())]);
        assert_eq!(lines(b"a\xB0\n"), [(1, "a\u{fffd}".to_owned())]);
        for bytes in [&b"\xFF\xFEa\0\n\0"[..], b"\xFE\xFF\0a\0\n", b"a\0\n"] {
            let error = Lines::new(bytes).next().unwrap_err();
            assert_eq!(error, TrajectoryError::Encoding { line: 1 });
        }
    }

    #[test]
    fn a_line_without_an_end_is_refused_before_it_is_held() {
        let endless = std::io::repeat(b'1');
        let mut lines = Lines::new(std::io::BufReader::new(endless));
        let error = lines.next().unwrap_err();
        assert!(matches!(error, TrajectoryError::LongLine { .. }));
        assert!(lines.line.capacity() <= 2 * LONGEST_LINE);
    }
}
