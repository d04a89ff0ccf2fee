//! Acceptance filters (RM0090, section 32.7.4).

use drive_sim::Frame;

use super::register_frame::{filter16, identifier_register};

/// Filter banks of CAN1 and CAN2 together.
const BANKS: usize = 28;
/// FMR after a reset: initialisation of the filters, CAN1 has banks 0 to 13.
const FMR_RESET: u32 = 0x2A1C_0E01;
const FMR_INIT: u32 = 1;

/// The filter banks.
#[derive(Debug, Clone)]
pub(super) struct Filters {
    master: u32,
    list_mode: u32,
    scale_32: u32,
    to_fifo_1: u32,
    active: u32,
    banks: [[u32; 2]; BANKS],
}

impl Default for Filters {
    fn default() -> Self {
        Self {
            master: FMR_RESET,
            list_mode: 0,
            scale_32: 0,
            to_fifo_1: 0,
            active: 0,
            banks: [[0; 2]; BANKS],
        }
    }
}

/// How urgently a filter decides when several pass a frame: 32 bit before 16, list before mask, then the lower number.
type Rank = (bool, bool, usize);

impl Filters {
    /// The FIFO that takes a frame; `None` when no filter passes it.
    ///
    /// Nothing passes while the filters are being set up. CAN1 has the banks below the one where CAN2's begin.
    #[must_use]
    pub(super) fn fifo_for(&self, frame: &Frame) -> Option<usize> {
        if self.master & FMR_INIT != 0 {
            return None;
        }
        let banks_of_can1 = (self.master as usize >> 8 & 0x3F).min(BANKS);
        let passing = (0..banks_of_can1)
            .filter(|&bank| self.has(self.active, bank) && self.passes(bank, frame));
        let decides = passing.min_by_key(|&bank| self.rank(bank))?;
        Some(usize::from(self.has(self.to_fifo_1, decides)))
    }

    fn has(&self, register: u32, bank: usize) -> bool {
        register >> bank & 1 != 0
    }

    fn rank(&self, bank: usize) -> Rank {
        (
            !self.has(self.scale_32, bank),
            !self.has(self.list_mode, bank),
            bank,
        )
    }

    fn passes(&self, bank: usize, frame: &Frame) -> bool {
        let [first, second] = self.banks[bank];
        let (wide, narrow) = (identifier_register(frame), filter16(frame));
        match (
            self.has(self.list_mode, bank),
            self.has(self.scale_32, bank),
        ) {
            // Bit 0 is reserved in a 32-bit filter.
            (false, true) => (wide ^ first) & second & !1 == 0,
            (true, true) => [first, second].iter().any(|id| (wide ^ id) & !1 == 0),
            (false, false) => [first, second]
                .iter()
                .any(|pair| (narrow ^ pair & 0xFFFF) & (pair >> 16) == 0),
            (true, false) => [first, second]
                .iter()
                .any(|pair| narrow == pair & 0xFFFF || narrow == pair >> 16),
        }
    }

    /// Reads a register by its offset in the controller.
    #[must_use]
    pub(super) fn read(&self, offset: u32) -> u32 {
        match offset {
            0x200 => self.master,
            0x204 => self.list_mode,
            0x20C => self.scale_32,
            0x214 => self.to_fifo_1,
            0x21C => self.active,
            0x240..0x320 => self.banks[(offset as usize - 0x240) / 8][(offset as usize & 4) / 4],
            _ => 0,
        }
    }

    /// Writes a register.
    pub(super) fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x200 => self.master = value,
            0x204 => self.list_mode = value,
            0x20C => self.scale_32 = value,
            0x214 => self.to_fifo_1 = value,
            0x21C => self.active = value,
            0x240..0x320 => {
                self.banks[(offset as usize - 0x240) / 8][(offset as usize & 4) / 4] = value
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use embedded_can::{ExtendedId, Frame as _, StandardId};

    use super::*;

    fn standard(id: u16) -> Frame {
        Frame::new(StandardId::new(id).unwrap(), &[]).unwrap()
    }

    /// One bank in 32-bit mask mode that passes a function code to FIFO 1, one in 16-bit mask mode that passes the rest to FIFO 0.
    fn two_banks() -> Filters {
        let mut filters = Filters::default();
        filters.write(0x240, 0x1D << 21);
        filters.write(0x244, 0x1F << 21 | 0b110);
        filters.write(0x248, 0x0018_0000);
        filters.write(0x24C, 0x0018_0000);
        filters.write(0x20C, 1);
        filters.write(0x214, 1);
        filters.write(0x21C, 0b11);
        filters.write(0x200, FMR_RESET & !FMR_INIT);
        filters
    }

    #[test]
    fn nothing_passes_out_of_reset() {
        assert_eq!(Filters::default().fifo_for(&standard(0x3D)), None);
    }

    #[test]
    fn the_32_bit_filter_decides_where_both_pass() {
        let filters = two_banks();
        assert_eq!(filters.fifo_for(&standard(0x3D)), Some(1));
        assert_eq!(filters.fifo_for(&standard(0x3A)), Some(0));
    }

    #[test]
    fn extended_and_remote_frames_are_kept_out() {
        let filters = two_banks();
        let extended = Frame::new(ExtendedId::new(0x3D).unwrap(), &[]).unwrap();
        let remote = Frame::new_remote(StandardId::new(0x3A).unwrap(), 0).unwrap();
        assert_eq!(
            (filters.fifo_for(&extended), filters.fifo_for(&remote)),
            (None, None)
        );
    }
}
