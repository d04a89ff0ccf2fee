//! What a call of the library answers: a set of bits (`TPCANStatus` in PCANBasic.h).

use core::fmt;

/// The answer of a call that is not simply "done".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status(pub u32);

/// Bits 10 to 12 are one number: what is wrong with a handle.
const HANDLE: u32 = 0x1C00;

impl Status {
    pub(crate) const OK: u32 = 0;
    const XMTFULL: u32 = 0x0000_0001;
    const OVERRUN: u32 = 0x0000_0002;
    const BUSLIGHT: u32 = 0x0000_0004;
    const BUSHEAVY: u32 = 0x0000_0008;
    const BUSOFF: u32 = 0x0000_0010;
    const QRCVEMPTY: u32 = 0x0000_0020;
    const QOVERRUN: u32 = 0x0000_0040;
    const QXMTFULL: u32 = 0x0000_0080;
    const NODRIVER: u32 = 0x0000_0200;
    const HWINUSE: u32 = 0x0000_0400;
    const NETINUSE: u32 = 0x0000_0800;
    const BUSPASSIVE: u32 = 0x0004_0000;
    const CAUTION: u32 = 0x0200_0000;

    /// What only says how the bus and the queues are: the channel is still there.
    const PASSING: u32 = Self::XMTFULL
        | Self::OVERRUN
        | Self::BUSLIGHT
        | Self::BUSHEAVY
        | Self::BUSOFF
        | Self::QRCVEMPTY
        | Self::QOVERRUN
        | Self::QXMTFULL
        | Self::BUSPASSIVE;

    const fn has(self, bits: u32) -> bool {
        self.0 & bits != 0
    }

    /// Nothing has been received.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.has(Self::QRCVEMPTY)
    }

    /// The controller has no room for a frame.
    #[must_use]
    pub const fn is_full(self) -> bool {
        self.has(Self::XMTFULL | Self::QXMTFULL)
    }

    /// The controller is bus-off.
    #[must_use]
    pub const fn is_bus_off(self) -> bool {
        self.has(Self::BUSOFF)
    }

    /// The controller is error passive: nobody acknowledges its frames, or the bus is disturbed.
    #[must_use]
    pub const fn is_passive(self) -> bool {
        self.has(Self::BUSHEAVY | Self::BUSPASSIVE)
    }

    /// Frames were received and lost because nobody read them.
    #[must_use]
    pub const fn is_overrun(self) -> bool {
        self.has(Self::OVERRUN | Self::QOVERRUN)
    }

    /// The adapter or its driver is gone, or the library does not know what it was asked.
    #[must_use]
    pub const fn is_lost(self) -> bool {
        self.has(!Self::PASSING)
    }

    pub(crate) const fn is_without_driver(self) -> bool {
        self.has(Self::NODRIVER)
    }

    pub(crate) const fn is_in_use(self) -> bool {
        matches!(self.0 & HANDLE, Self::HWINUSE | Self::NETINUSE)
    }

    pub(crate) const fn is_no_such_channel(self) -> bool {
        self.0 & HANDLE > Self::NETINUSE
    }

    /// Done, but not as it was asked.
    pub(crate) const fn is_caution(self) -> bool {
        self.has(Self::CAUTION)
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PCAN-Basic status {:05X}h", self.0)
    }
}

impl core::error::Error for Status {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handle_codes_are_numbers_and_no_bits() {
        // PCAN_ERROR_HWINUSE, _NETINUSE, _ILLHW, _ILLNET, _ILLCLIENT.
        let used = [0x0400, 0x0800, 0x1400, 0x1800, 0x1C00].map(|code| Status(code).is_in_use());
        assert_eq!(used, [true, true, false, false, false]);
        let none = [0x0400, 0x0800, 0x1400, 0x1800, 0x1C00, 0x20]
            .map(|code| Status(code).is_no_such_channel());
        assert_eq!(none, [false, false, true, true, true, false]);
    }

    #[test]
    fn a_bad_bus_is_no_lost_adapter() {
        for code in [0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40, 0x80, 0x4_0000] {
            assert!(!Status(code).is_lost(), "{code:X}");
        }
        for code in [0x100, 0x200, 0x1400, 0x1_0000, 0x400_0000] {
            assert!(Status(code).is_lost(), "{code:X}");
        }
    }
}
