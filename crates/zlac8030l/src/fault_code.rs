//! Fault code 603Fh: one bit a fault, several at once possible (guide sections 8 and 9).

use core::fmt;

/// The fault code as the drive sent it; bits without a meaning are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultCode(u16);

/// The faults in the order of their bits.
const NAMES: [&str; 13] = [
    "over-voltage",
    "under-voltage",
    "over-current",
    "overload",
    "current out of tolerance (reserved)",
    "encoder out of tolerance",
    "speed out of tolerance (reserved)",
    "reference voltage",
    "EEPROM",
    "Hall",
    "motor over-temperature",
    // The fault table and the dictionary disagree (Z24).
    "driver over-temperature (dictionary) or encoder (fault table)",
    "encoder (dictionary)",
];

impl FaultCode {
    /// A fault code as received.
    #[must_use]
    pub const fn new(code: u16) -> Self {
        Self(code)
    }

    /// The code on the wire.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }

    /// Any bit is set, described or not.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        self.0 != 0
    }

    /// The faults in words, lowest bit first.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        (0_u32..)
            .zip(NAMES)
            .filter(move |(bit, _)| self.0 & 1 << bit != 0)
            .map(|(_, name)| name)
    }

    /// The bits that the guide does not describe.
    #[must_use]
    pub const fn undocumented_bits(self) -> u16 {
        self.0 & !0x1FFF
    }
}

impl fmt::Display for FaultCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h", self.0)?;
        for (place, name) in self.names().enumerate() {
            f.write_str(if place == 0 { ": " } else { ", " })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_is_named_or_kept() {
        for code in 0..=u16::MAX {
            let fault = FaultCode::new(code);
            let bits = (code & 0x1FFF).count_ones() as usize;
            assert_eq!(fault.names().count(), bits);
            assert_eq!(fault.undocumented_bits(), code & 0xE000);
            assert_eq!(fault.is_fault(), code != 0);
        }
        assert_eq!(
            std::format!("{}", FaultCode::new(0x0204)),
            "0204h: over-current, Hall"
        );
    }

    #[test]
    fn what_a_drive_sent_is_kept() {
        for code in [0, 1, 0x0204, u16::MAX] {
            assert_eq!(FaultCode::new(code).get(), code);
        }
        let names: std::vec::Vec<_> = FaultCode::new(0x0105).names().collect();
        assert_eq!(names, ["over-voltage", "over-current", "EEPROM"]);
    }
}
