//! Lines of somebody who may send anything: each is complete, text, and not too long, or an error.

use std::io::{self, BufRead, BufReader, Read};

/// The longest line, in bytes, its end included.
pub(crate) const LONGEST_LINE: usize = 4_096;

/// A line, without its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Line {
    /// Text.
    Text(String),
    /// More than [`LONGEST_LINE`] bytes, which are not kept.
    TooLong { actual: usize },
    /// Not UTF-8; the place of the first byte that is not.
    NotText { at: usize },
    /// The sender has gone in the middle of the line: a number in it may be cut off.
    Unfinished { actual: usize },
}

/// Reads lines.
pub(crate) struct LineReader<R> {
    input: BufReader<R>,
}

impl<R: Read> LineReader<R> {
    /// Lines of this input.
    pub(crate) fn new(input: R) -> Self {
        Self {
            input: BufReader::new(input),
        }
    }

    /// The next line; `None` at the end.
    ///
    /// # Errors
    /// When it cannot be read any further.
    pub(crate) fn next(&mut self) -> io::Result<Option<Line>> {
        let (mut kept, mut length) = (Vec::new(), 0_usize);
        loop {
            let bytes = match self.input.fill_buf() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                bytes => bytes?,
            };
            if bytes.is_empty() {
                return Ok((length > 0).then_some(Line::Unfinished { actual: length }));
            }
            let end = bytes.iter().position(|&byte| byte == b'\n');
            let used = end.map_or(bytes.len(), |end| end + 1);
            length = length.saturating_add(used);
            if length <= LONGEST_LINE {
                kept.extend_from_slice(&bytes[..used]);
            }
            self.input.consume(used);
            if end.is_some() {
                return Ok(Some(line(kept, length)));
            }
        }
    }
}

fn line(bytes: Vec<u8>, length: usize) -> Line {
    if length > LONGEST_LINE {
        return Line::TooLong { actual: length };
    }
    match String::from_utf8(bytes) {
        Ok(text) => Line::Text(text.trim_end_matches(['\n', '\r']).to_owned()),
        Err(error) => Line::NotText {
            at: error.utf8_error().valid_up_to(),
        },
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Hands out a few bytes at a time, as a connection does.
    struct Portions<'a>(&'a [u8], usize);

    impl Read for Portions<'_> {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let length = self.1.min(bytes.len());
            self.0.read(&mut bytes[..length])
        }
    }

    proptest! {
        /// Whatever the bytes and however they come: as many lines as line feeds, and each is the one that was sent.
        #[test]
        fn any_bytes_are_the_lines_that_they_are(
            bytes in proptest::collection::vec(prop_oneof![Just(b'\n'), any::<u8>(), 32..126_u8], 0..12_000),
            portion in 1..5_000_usize,
        ) {
            let mut reader = LineReader::new(Portions(&bytes, portion));
            let mut sent: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
            let rest = sent.pop().unwrap_or_default();
            for line in sent {
                let expected = match std::str::from_utf8(line) {
                    _ if line.len() >= LONGEST_LINE => Line::TooLong { actual: line.len() + 1 },
                    Ok(text) => Line::Text(text.trim_end_matches('\r').to_owned()),
                    Err(error) => Line::NotText { at: error.valid_up_to() },
                };
                prop_assert_eq!(reader.next().unwrap(), Some(expected));
            }
            let unfinished = (!rest.is_empty()).then_some(Line::Unfinished { actual: rest.len() });
            prop_assert_eq!(reader.next().unwrap(), unfinished);
        }
    }

    fn lines(bytes: &[u8]) -> Vec<Line> {
        let mut reader = LineReader::new(bytes);
        core::iter::from_fn(|| reader.next().unwrap()).collect()
    }

    #[test]
    fn a_line_is_whole_and_text_or_an_error() {
        let long = [b"7".repeat(LONGEST_LINE), b"\n0,1\n".to_vec()].concat();
        assert_eq!(
            lines(&long),
            [
                Line::TooLong {
                    actual: LONGEST_LINE + 1
                },
                Line::Text("0,1".to_owned())
            ]
        );
        assert_eq!(
            lines(b"a\r\n\nb\xFFc\n12"),
            [
                Line::Text("a".to_owned()),
                Line::Text(String::new()),
                Line::NotText { at: 1 },
                Line::Unfinished { actual: 2 },
            ]
        );
        let longest = [b"7".repeat(LONGEST_LINE - 1), b"\n".to_vec()].concat();
        assert!(
            matches!(&lines(&longest)[..], [Line::Text(text)] if text.len() == LONGEST_LINE - 1)
        );
        // A line without an end takes no memory.
        assert_eq!(
            lines(&vec![b'x'; 100_000]),
            [Line::Unfinished { actual: 100_000 }]
        );
    }
}
