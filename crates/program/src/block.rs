//! A line: its codes by group, its other words by letter, each with its column.

use crate::error::ErrorKind;
use crate::number::Decimal;
use crate::words::{At, Word, Words};

/// Groups of G codes of which a line has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Motion,
    /// G4 and G28, which use the words of a line themselves.
    Once,
    Plane,
    Units,
    Distance,
    Corners,
}

const GROUPS: usize = 6;

/// The letters of words that are no codes.
const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'I', 'J', 'K', 'R', 'F', 'P'];

#[derive(Debug, Clone, Copy)]
pub(crate) struct Code {
    pub(crate) number: u32,
    pub(crate) column: u32,
}

/// One line.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Block {
    codes: [Option<Code>; GROUPS],
    pub(crate) miscellaneous: Option<Code>,
    values: [Option<(Decimal, u32)>; LETTERS.len()],
    used: [bool; LETTERS.len()],
}

impl Block {
    pub(crate) fn read(line: &str) -> Result<Self, At> {
        let words = Words::read(line)?;
        let mut block = Self::default();
        let mut is_numbered = false;
        for word in words.iter() {
            match word.letter {
                'G' => block.general(word)?,
                'M' => block.stop(word)?,
                'N' if is_numbered => return Err((word.column, ErrorKind::Twice { letter: 'N' })),
                'N' => is_numbered = true,
                _ => block.value(word)?,
            }
        }
        Ok(block)
    }

    fn general(&mut self, word: &Word) -> Result<(), At> {
        let code = code(word, group_of)?;
        let Some(group) = group_of(code.number) else {
            return Ok(());
        };
        place(&mut self.codes[group as usize], word, code)
    }

    fn stop(&mut self, word: &Word) -> Result<(), At> {
        let code = code(word, |number| {
            matches!(number, 0 | 2 | 30).then_some(Group::Once)
        })?;
        place(&mut self.miscellaneous, word, code)
    }

    fn value(&mut self, word: &Word) -> Result<(), At> {
        let letter = word.letter;
        let place = LETTERS.iter().position(|&other| other == letter);
        let slot = place.and_then(|place| self.values.get_mut(place));
        let Some(slot) = slot else {
            return Err((word.column, ErrorKind::UnknownLetter { actual: letter }));
        };
        if slot.is_some() {
            return Err((word.column, ErrorKind::Twice { letter }));
        }
        *slot = Some((word.value, word.column));
        Ok(())
    }

    pub(crate) fn code(&self, group: Group) -> Option<Code> {
        self.codes[group as usize]
    }

    /// The value of a letter, which is used by that, and its column.
    pub(crate) fn take(&mut self, letter: char) -> Option<(Decimal, u32)> {
        let place = LETTERS.iter().position(|&other| other == letter)?;
        *self.used.get_mut(place)? = true;
        *self.values.get(place)?
    }

    /// Where the first of these letters is, if one is given.
    pub(crate) fn first_of(&self, letters: [char; 3]) -> Option<u32> {
        let of = |(letter, value): (&char, &Option<(Decimal, u32)>)| {
            value
                .filter(|_| letters.contains(letter))
                .map(|(_, column)| column)
        };
        LETTERS.iter().zip(&self.values).filter_map(of).min()
    }

    /// Refuses what nothing has used.
    pub(crate) fn finish(&self) -> Result<(), At> {
        let words = LETTERS.iter().zip(&self.values).zip(&self.used);
        for ((&letter, value), is_used) in words {
            if let (Some((_, column)), false) = (value, is_used) {
                return Err((*column, ErrorKind::Unused { letter }));
            }
        }
        Ok(())
    }
}

const fn group_of(number: u32) -> Option<Group> {
    Some(match number {
        0..=3 => Group::Motion,
        4 | 28 => Group::Once,
        17..=19 => Group::Plane,
        20 | 21 => Group::Units,
        61 | 64 => Group::Corners,
        90 | 91 => Group::Distance,
        _ => return None,
    })
}

fn code(word: &Word, group_of: impl Fn(u32) -> Option<Group>) -> Result<Code, At> {
    let letter = word.letter;
    let tenths = word.value.tenths();
    let number = tenths
        .filter(|tenths| tenths % 10 == 0)
        .map(|tenths| tenths / 10);
    match number.filter(|&number| group_of(number).is_some()) {
        Some(number) => Ok(Code {
            number,
            column: word.column,
        }),
        None => Err((
            word.column,
            match tenths {
                Some(actual_tenths) => ErrorKind::UnknownCode {
                    letter,
                    actual_tenths,
                },
                None => ErrorKind::Number { letter },
            },
        )),
    }
}

fn place(slot: &mut Option<Code>, word: &Word, code: Code) -> Result<(), At> {
    if let Some(before) = slot {
        let kind = ErrorKind::Conflict {
            letter: word.letter,
            actual: (before.number, code.number),
        };
        return Err((code.column, kind));
    }
    *slot = Some(code);
    Ok(())
}
