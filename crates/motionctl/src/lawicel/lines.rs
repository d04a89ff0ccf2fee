//! Bytes in any portions to whole lines.

use std::collections::VecDeque;

use super::{BEL, CR};

/// The longest line: an extended frame with eight bytes and a time stamp.
const LONGEST: usize = 1 + 8 + 1 + 16 + 8;

/// What stands between two ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Token {
    /// A line without its CR; may be empty.
    Line(Vec<u8>),
    /// More bytes without an end than any line has.
    Overlong,
    /// A lone BEL.
    Bell,
}

/// Collects bytes until a line is whole.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    line: Vec<u8>,
    whole: VecDeque<Token>,
}

impl Lines {
    /// Takes bytes as they come.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match byte {
                CR if self.line.len() > LONGEST => {
                    self.line.clear();
                    self.whole.push_back(Token::Overlong);
                }
                CR => {
                    let line = std::mem::take(&mut self.line);
                    self.whole.push_back(Token::Line(line));
                }
                BEL => {
                    self.line.clear();
                    self.whole.push_back(Token::Bell);
                }
                // Terminal programs send a line feed after CR.
                b'\n' => {}
                _ if self.line.len() > LONGEST => {}
                _ => self.line.push(byte),
            }
        }
    }

    /// The oldest whole line.
    pub(crate) fn pop(&mut self) -> Option<Token> {
        self.whole.pop_front()
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.line.clear();
        self.whole.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(portions: &[&[u8]]) -> Vec<Token> {
        let mut lines = Lines::default();
        portions.iter().for_each(|bytes| lines.push(bytes));
        std::iter::from_fn(|| lines.pop()).collect()
    }

    #[test]
    fn lines_come_in_any_portions() {
        let line = |text: &[u8]| Token::Line(text.to_vec());
        let expected = [line(b"t03C188"), line(b""), Token::Bell, line(b"z")];
        assert_eq!(tokens(&[b"t03", b"C188\r\r", b"\x07z\r\n", b"V"]), expected);
    }

    #[test]
    fn a_line_without_end_takes_no_memory_and_is_told() {
        let endless = [b'x'; 10_000];
        assert_eq!(
            tokens(&[&endless, b"\rV\r"]),
            [Token::Overlong, Token::Line(b"V".to_vec())]
        );
        let longest = b"T1234567881122334455667788123456AB";
        assert_eq!(tokens(&[longest, b"\r"]), [Token::Line(longest.to_vec())]);
    }
}
