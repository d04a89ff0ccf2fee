//! The records in the flash of a board: put there before it starts, and read without it.

use core::convert::Infallible;

use board_settings::{LONGEST, Settings};
use record_store::{Area, Flash, Reading, Store};

use crate::chip::Chip;
use crate::flash::FlashContent;

/// Bytes of an area that the firmware uses.
const AREA_BYTES: u32 = 4_096;

/// The records of the settings in the flash of a board.
pub type SettingsRecords = Store<Records, LONGEST>;

/// Two areas in the flash of a board.
#[derive(Debug)]
pub struct Records {
    content: FlashContent,
    areas: [u32; 2],
    unit: u32,
}

/// The settings in a flash: sectors 1 and 2 of the STM32F405, pages 0 to 3 of the second bank of the STM32G474.
#[must_use]
pub const fn settings_of(content: FlashContent, chip: &Chip) -> SettingsRecords {
    let (areas, unit) = if chip.flash.banks == 1 {
        ([0x0800_4000, 0x0800_8000], 4)
    } else {
        ([0x0804_0000, 0x0804_1000], 8)
    };
    Store::new(Records {
        content,
        areas,
        unit,
    })
}

/// The bytes of settings.
///
/// # Panics
/// Never: there is room for the longest.
#[must_use]
pub fn bytes_of(settings: &Settings) -> Vec<u8> {
    let mut room = [0; LONGEST];
    settings.write(&mut room).expect("enough room").to_vec()
}

/// The latest settings in a flash.
#[must_use]
pub fn latest(records: &mut SettingsRecords) -> Option<Vec<u8>> {
    let mut room = [0; LONGEST];
    match records.read(0, &mut room) {
        Ok(found) => found.map(<[u8]>::to_vec),
        Err(error) => panic!("{error}"),
    }
}

impl Records {
    /// The whole flash.
    #[must_use]
    pub fn content(&self) -> FlashContent {
        self.content.clone()
    }

    const fn address(&self, area: Area, offset: usize) -> u32 {
        self.areas[area as usize] + offset as u32
    }
}

impl Flash for Records {
    type Error = Infallible;
    // Records of the board have whole double words everywhere, and more than this chip needs.
    const UNIT: usize = 8;
    const AREA_BYTES: usize = AREA_BYTES as usize;

    fn read(&mut self, area: Area, offset: usize, bytes: &mut [u8]) -> Result<Reading, Infallible> {
        let first = self.address(area, offset);
        let range = first..first + bytes.len() as u32;
        let found = self.content.read(range.clone()).expect("flash is there");
        bytes.copy_from_slice(found);
        let is_damaged = self
            .content
            .damaged()
            .any(|word| word < range.end && word + self.unit > range.start);
        Ok(if is_damaged && self.unit == 8 {
            Reading::Unreadable
        } else {
            Reading::Good
        })
    }

    fn program(&mut self, area: Area, offset: usize, bytes: &[u8]) -> Result<(), Infallible> {
        let is_there = self.content.write(self.address(area, offset), bytes);
        assert!(is_there, "flash is there");
        Ok(())
    }

    fn erase(&mut self, area: Area) -> Result<(), Infallible> {
        self.program(area, 0, &[0xFF; AREA_BYTES as usize])
    }
}
