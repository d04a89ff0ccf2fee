//! Counting instructions by straight runs of code.

use core::ops::Range;
use std::collections::HashMap;

/// First address of flash.
const FLASH: u64 = 0x0800_0000;
/// Halfwords of flash.
const FLASH_HALFWORDS: usize = 0x8_0000;
/// Bytes that no straight run exceeds: Unicorn translates less at once.
const LONGEST_RUN: u32 = 0x1000;
/// First byte of a 32-bit instruction, from this value on in its upper five bits (ARMv7-M, section A5.1).
const WIDE: u8 = 0b11101;

/// Instructions of each straight run met so far, by first address and length in bytes.
#[derive(Debug, Clone)]
pub struct Runs {
    /// Instructions and bytes of the run that begins at each halfword of flash.
    flash: Vec<(u32, u32)>,
    elsewhere: HashMap<(u64, u32), u32>,
}

impl Default for Runs {
    fn default() -> Self {
        Self {
            flash: vec![(0, 0); FLASH_HALFWORDS],
            elsewhere: HashMap::new(),
        }
    }
}

impl Runs {
    /// Instructions of a run that was noted before.
    #[must_use]
    pub fn known(&self, address: u64, bytes: u32) -> Option<u32> {
        match self.flash.get(halfword(address)) {
            Some(&(instructions, noted)) => (noted == bytes).then_some(instructions),
            None => self.elsewhere.get(&(address, bytes)).copied(),
        }
    }

    /// Forgets the runs that begin in this part of flash, where other code may stand now, or reach into it.
    pub fn forget(&mut self, changed: &Range<u32>) {
        let first = halfword(u64::from(changed.start.saturating_sub(LONGEST_RUN)).max(FLASH));
        let last = halfword(u64::from(changed.end));
        let runs = self.flash.iter_mut().enumerate();
        for (halfword, (_, bytes)) in runs.take(last).skip(first) {
            let first = FLASH as u32 + 2 * halfword as u32;
            if first < changed.end && first + *bytes > changed.start {
                *bytes = 0;
            }
        }
    }

    /// Notes a run.
    pub fn note(&mut self, address: u64, bytes: u32, instructions: u32) {
        match self.flash.get_mut(halfword(address)) {
            Some(place) => *place = (instructions, bytes),
            None => {
                self.elsewhere.insert((address, bytes), instructions);
            }
        }
    }
}

fn halfword(address: u64) -> usize {
    (address.wrapping_sub(FLASH) / 2) as usize
}

/// Where each instruction of a straight run of Thumb code begins, in bytes from its start.
pub fn offsets(code: &[u8]) -> impl Iterator<Item = u32> {
    let mut at = 0;
    core::iter::from_fn(move || {
        let offset = at;
        let upper = code.get(offset + 1)?;
        at += if upper >> 3 >= WIDE { 4 } else { 2 };
        Some(offset as u32)
    })
}

/// Instructions in a straight run of Thumb code.
#[must_use]
pub fn count(code: &[u8]) -> u32 {
    offsets(code).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_instructions_count_once() {
        // movs r0, #1; movw r1, #0x1234; bx lr
        let code = [0x01, 0x20, 0x41, 0xF2, 0x34, 0x21, 0x70, 0x47];
        assert_eq!(count(&code), 3);
    }

    #[test]
    fn runs_in_changed_flash_are_forgotten() {
        let mut runs = Runs::default();
        for (address, bytes) in [(0x10, 8), (0x18, 8), (0x20, 8)] {
            runs.note(FLASH + address, bytes, 3);
        }
        runs.forget(&(FLASH as u32 + 0x16..FLASH as u32 + 0x20));
        let known = [0x10, 0x18, 0x20].map(|address| runs.known(FLASH + address, 8));
        assert_eq!(known, [None, None, Some(3)]);
    }

    #[test]
    fn a_run_of_another_length_is_another_run() {
        let mut runs = Runs::default();
        runs.note(FLASH + 8, 6, 3);
        assert_eq!(runs.known(FLASH + 8, 6), Some(3));
        assert_eq!(runs.known(FLASH + 8, 4), None);
        runs.note(0x2000_0000, 4, 1);
        assert_eq!(runs.known(0x2000_0000, 4), Some(1));
    }
}
