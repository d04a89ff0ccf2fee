//! Abort codes of SDO transfers in words (CiA 301; the guide lists none, Z33).

use core::fmt;

/// A 32-bit abort code, known or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AbortCode(u32);

macro_rules! abort_codes {
    ($($code:literal $name:ident $text:literal,)*) => {
        impl AbortCode {
            $(
                #[doc = concat!($text, ".")]
                pub const $name: Self = Self($code);
            )*

            /// Every code that CiA 301 lists.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// The meaning in words; `None` for a code that CiA 301 does not list.
            #[must_use]
            pub const fn text(self) -> Option<&'static str> {
                match self.0 {
                    $($code => Some($text),)*
                    _ => None,
                }
            }
        }
    };
}

abort_codes! {
    0x0503_0000 TOGGLE_BIT "toggle bit not alternated",
    0x0504_0000 TIMEOUT "SDO protocol timed out",
    0x0504_0001 COMMAND_SPECIFIER "command specifier not valid or unknown",
    0x0504_0002 BLOCK_SIZE "invalid block size",
    0x0504_0003 SEQUENCE_NUMBER "invalid sequence number",
    0x0504_0004 CRC "CRC error",
    0x0504_0005 OUT_OF_MEMORY "out of memory",
    0x0601_0000 ACCESS "unsupported access to an object",
    0x0601_0001 WRITE_ONLY "read of a write-only object",
    0x0601_0002 READ_ONLY "write to a read-only object",
    0x0602_0000 NO_SUCH_OBJECT "object does not exist",
    0x0604_0041 NOT_MAPPABLE "object cannot be mapped to the PDO",
    0x0604_0042 PDO_LENGTH "mapped objects exceed the length of the PDO",
    0x0604_0043 PARAMETER_INCOMPATIBLE "general parameter incompatibility",
    0x0604_0047 INTERNAL_INCOMPATIBLE "general internal incompatibility in the device",
    0x0606_0000 HARDWARE "access failed because of a hardware error",
    0x0607_0010 LENGTH "length mismatch of the parameter",
    0x0607_0012 TOO_LONG "parameter too long",
    0x0607_0013 TOO_SHORT "parameter too short",
    0x0609_0011 NO_SUCH_SUB_INDEX "sub-index does not exist",
    0x0609_0030 VALUE_RANGE "value range exceeded",
    0x0609_0031 VALUE_TOO_HIGH "value too high",
    0x0609_0032 VALUE_TOO_LOW "value too low",
    0x0609_0036 MAX_LESS_THAN_MIN "maximum less than minimum",
    0x060A_0023 NO_RESOURCE "resource not available",
    0x0800_0000 GENERAL "general error",
    0x0800_0020 CANNOT_TRANSFER "data cannot be transferred or stored",
    0x0800_0021 LOCAL_CONTROL "data cannot be transferred or stored because of local control",
    0x0800_0022 DEVICE_STATE "data cannot be transferred or stored in the present device state",
    0x0800_0023 NO_DICTIONARY "no object dictionary is present",
    0x0800_0024 NO_DATA "no data available",
}

impl AbortCode {
    /// A code as received.
    #[must_use]
    pub const fn new(code: u32) -> Self {
        Self(code)
    }

    /// The code.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.text().unwrap_or("unknown abort code");
        write!(f, "{text} ({:08X}h)", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes_have_words_and_unknown_codes_survive() {
        assert_eq!(
            std::format!("{}", AbortCode::new(0x0601_0002)),
            "write to a read-only object (06010002h)"
        );
        assert_eq!(
            std::format!("{}", AbortCode::new(0xDEAD_BEEF)),
            "unknown abort code (DEADBEEFh)"
        );
        for code in AbortCode::ALL {
            assert!(code.text().is_some());
        }
    }
}
