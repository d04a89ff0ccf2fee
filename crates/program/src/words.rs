//! The words of one line.

use crate::error::ErrorKind;
use crate::number::Decimal;
use crate::{LONGEST_LINE, MOST_WORDS};

/// A letter and its number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Word {
    /// Upper case.
    pub(crate) letter: char,
    pub(crate) value: Decimal,
    /// From 1.
    pub(crate) column: u32,
}

/// The words of a line in their order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Words {
    words: [Option<Word>; MOST_WORDS],
    len: usize,
}

/// A column, from 1, and what is wrong there.
pub(crate) type At = (u32, ErrorKind);

impl Words {
    /// Cuts a line into words. Comments are left out: what is in parentheses, and what follows a semicolon. A percent sign alone is the
    /// beginning or the end of a tape.
    pub(crate) fn read(line: &str) -> Result<Self, At> {
        let line = line.trim_end_matches(['\r', '\n']);
        if line.len() > LONGEST_LINE {
            return Err((
                LONGEST_LINE as u32 + 1,
                ErrorKind::Long { actual: line.len() },
            ));
        }
        let mut words = Self {
            words: [None; MOST_WORDS],
            len: 0,
        };
        if line.trim() == "%" {
            return Ok(words);
        }
        let mut rest = line;
        loop {
            rest = rest.trim_start_matches([' ', '\t']);
            let column = (line.len() - rest.len()) as u32 + 1;
            let Some(first) = rest.chars().next() else {
                return Ok(words);
            };
            rest = match first {
                ';' => return Ok(words),
                '(' => behind_comment(rest).ok_or((column, ErrorKind::OpenComment))?,
                _ if first.is_ascii_alphabetic() => {
                    let (word, behind) = word(first, rest, column)?;
                    words.add(word)?;
                    behind
                }
                actual => return Err((column, ErrorKind::Character { actual })),
            };
        }
    }

    fn add(&mut self, word: Word) -> Result<(), At> {
        let full = (word.column, ErrorKind::ManyWords);
        *self.words.get_mut(self.len).ok_or(full)? = Some(word);
        self.len += 1;
        Ok(())
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Word> {
        self.words.iter().flatten()
    }
}

fn behind_comment(text: &str) -> Option<&str> {
    text.split_once(')').map(|(_, behind)| behind)
}

/// The word at the start of a text, and what is behind it.
fn word(first: char, text: &str, column: u32) -> Result<(Word, &str), At> {
    let letter = first.to_ascii_uppercase();
    let number = text
        .get(1..)
        .unwrap_or_default()
        .trim_start_matches([' ', '\t']);
    let is_part = |(place, byte): (usize, u8)| {
        byte.is_ascii_digit() || byte == b'.' || (place == 0 && (byte == b'-' || byte == b'+'))
    };
    let len = number
        .bytes()
        .enumerate()
        .take_while(|&part| is_part(part))
        .count();
    let (number, behind) = number.split_at_checked(len).unwrap_or((number, ""));
    let value = Decimal::read(letter, number).map_err(|kind| (column, kind))?;
    let word = Word {
        letter,
        value,
        column,
    };
    Ok((word, behind))
}
