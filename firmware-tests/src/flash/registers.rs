//! The registers: where each chip has them, and unlocking the control register.

use super::{CR_LOCK, CR_MASS_ERASE, CR_START, Flash, Registers};

pub(super) const BUSY: u32 = 1 << 16;
/// Keys of the control register.
pub(super) const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// How far the control register is unlocked.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Keys {
    #[default]
    None,
    First,
    /// A wrong one: locked until the next reset.
    Wrong,
}

/// A register of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Key,
    OptionKey,
    Status,
    Control,
    Errors,
}

impl Flash {
    /// Whether a write of this register has to wait for the end of an operation.
    #[must_use]
    pub fn holds_up(&self, offset: u32) -> bool {
        self.is_changing() && self.place(offset) == Some(Place::Control)
    }

    pub(super) fn place(&self, offset: u32) -> Option<Place> {
        let places = [
            Place::Key,
            Place::OptionKey,
            Place::Status,
            Place::Control,
            Place::Errors,
        ];
        let offsets: &[u32] = match self.part.registers {
            Registers::Sectors => &[0x04, 0x08, 0x0C, 0x10],
            Registers::Pages => &[0x08, 0x0C, 0x10, 0x14, 0x18],
        };
        let at = offsets.iter().position(|of| *of == offset)?;
        Some(places[at])
    }

    /// Reads a register; `None` when it is none of these.
    #[must_use]
    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match self.place(offset)? {
            Place::Key | Place::OptionKey => 0,
            Place::Status if self.is_changing() => self.status | BUSY,
            Place::Status => self.status,
            Place::Control => self.control,
            Place::Errors => self.errors,
        })
    }

    /// Writes a register; false when it is none of these. `options` are the option bytes.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled: mass erase, fast programming, a single bank.
    pub fn write(&mut self, offset: u32, value: u32, options: u32, now_ns: u64) -> bool {
        let Some(place) = self.place(offset) else {
            return false;
        };
        match place {
            Place::Key => self.take_key(value),
            Place::OptionKey => self.take_option_key(value),
            Place::Status => self.status &= !(value & !BUSY),
            Place::Control => self.write_control(value, options, now_ns),
            Place::Errors => self.write_errors(value),
        }
        true
    }

    fn take_key(&mut self, key: u32) {
        let locked = self.control & CR_LOCK != 0;
        self.keys = match (self.keys, locked) {
            (Keys::None, true) if key == KEYS[0] => Keys::First,
            (Keys::First, true) if key == KEYS[1] => {
                self.control &= !CR_LOCK;
                Keys::None
            }
            _ => Keys::Wrong,
        };
    }

    fn write_control(&mut self, value: u32, options: u32, now_ns: u64) {
        if self.control & CR_LOCK != 0 {
            return;
        }
        self.control = value;
        if value & CR_START != 0 {
            assert_eq!(
                value & CR_MASS_ERASE,
                0,
                "a mass erase of the flash is not modelled"
            );
            match self.part.registers {
                Registers::Sectors => self.start_sectors(options, now_ns),
                Registers::Pages => self.start_pages(options, now_ns),
            }
            if self.operation.is_none() {
                self.control &= !CR_START;
            }
        }
    }
}
