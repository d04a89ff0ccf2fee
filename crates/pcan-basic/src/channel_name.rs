//! The names of channels, as in PCANBasic.h.

use core::fmt;
use core::str::FromStr;

/// What a name begins with.
const USB: &str = "PCAN_USBBUS";

/// A channel of a PCAN-USB: `PCAN_USBBUS1` to `PCAN_USBBUS16`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChannelName(u8);

/// Not the name of a channel.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected PCAN_USBBUS1 to PCAN_USBBUS16, got {0}")]
pub struct BadName(String);

impl ChannelName {
    /// The handle (`TPCANHandle`): the first eight have other numbers than those that came later.
    pub(crate) const fn handle(self) -> u16 {
        let number = self.0 as u16;
        if number <= 8 {
            0x50 + number
        } else {
            0x500 + number
        }
    }
}

impl FromStr for ChannelName {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let number = text.strip_prefix(USB);
        number
            .filter(|number| !number.starts_with(['0', '+']))
            .and_then(|number| number.parse().ok())
            .filter(|number| (1..=16).contains(number))
            .map(Self)
            .ok_or_else(|| BadName(text.to_owned()))
    }
}

impl fmt::Display for ChannelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{USB}{}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_handles_are_those_of_the_header() {
        for (name, handle) in [
            ("PCAN_USBBUS1", 0x51),
            ("PCAN_USBBUS8", 0x58),
            ("PCAN_USBBUS9", 0x509),
            ("PCAN_USBBUS16", 0x510),
        ] {
            let channel: ChannelName = name.parse().unwrap();
            assert_eq!(
                (channel.handle(), channel.to_string().as_str()),
                (handle, name)
            );
        }
        for name in [
            "",
            "PCAN_USBBUS",
            "PCAN_USBBUS0",
            "PCAN_USBBUS17",
            "PCAN_USBBUS01",
            "PCAN_USBBUS+1",
            "can0",
            "51h",
        ] {
            assert_eq!(name.parse::<ChannelName>(), Err(BadName(name.to_owned())));
        }
    }
}
