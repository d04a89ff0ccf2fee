//! Where the records lie.

use core::ptr;

use record_store::{Area, Flash, Reading};

use super::chip;

/// Bytes of an area: what two pages of the STM32G474 have. Of the sectors of the STM32F405 the first bytes are used.
const AREA_BYTES: usize = 4_096;

/// The settings, and the faults.
pub(super) const SETTINGS: Place = Place(chip::SETTINGS);
pub(super) const FAULTS: Place = Place(chip::FAULTS);

/// What the status register of the flash said of an operation that failed.
#[derive(Clone, Copy)]
pub(super) struct ChipError(pub(super) u32);

/// Two areas, by their addresses.
pub(super) struct Place([u32; 2]);

impl Place {
    fn address(&self, area: Area, offset: usize) -> u32 {
        let [first, second] = self.0;
        let base = match area {
            Area::First => first,
            Area::Second => second,
        };
        base + offset as u32
    }
}

impl Flash for Place {
    type Error = ChipError;
    const UNIT: usize = chip::UNIT;
    const AREA_BYTES: usize = AREA_BYTES;

    fn read(&mut self, area: Area, offset: usize, bytes: &mut [u8]) -> Result<Reading, ChipError> {
        let address = self.address(area, offset);
        Ok(chip::watch(|| {
            for (byte, at) in bytes.iter_mut().zip(address..) {
                // SAFETY: an address of the flash within the area; nothing is known to the compiler about what lies there.
                *byte = unsafe { ptr::read_volatile(at as *const u8) };
            }
        }))
    }

    fn program(&mut self, area: Area, offset: usize, bytes: &[u8]) -> Result<(), ChipError> {
        let address = self.address(area, offset);
        let operation = chip::Operation::begin()?;
        for (unit, at) in bytes
            .chunks_exact(chip::UNIT)
            .zip((address..).step_by(chip::UNIT))
        {
            operation.program(at, unit)?;
        }
        Ok(())
    }

    fn erase(&mut self, area: Area) -> Result<(), ChipError> {
        let address = self.address(area, 0);
        chip::Operation::begin()?.erase(address)
    }
}
