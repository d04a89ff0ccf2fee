//! Objects on the command line: by address as in `2014h` and `202Fh:05`, or by name as in `rated-current`.

use core::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::dictionary::{self, Entry};
use zlac8030l::{ObjectAddress, objects};

/// The name of an object: its name in the guide in small letters, without what is in brackets.
pub(super) fn name(entry: &Entry) -> String {
    let plain = entry.name.split(['(', ',']).next().unwrap_or_default();
    let words: Vec<String> = plain
        .split(|letter: char| !letter.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    words.join("-")
}

/// An address as it is printed and read.
pub(super) fn address_text(address: ObjectAddress) -> String {
    format!("{:04X}h:{:02X}", address.index, address.sub)
}

/// Reads an object by address or by name.
///
/// # Errors
/// What is wrong with the text.
pub(super) fn object(text: &str) -> Result<&'static Entry, String> {
    match address(text) {
        Some(address) => dictionary::find(address).ok_or_else(|| {
            format!(
                "the dictionary has no object {}: `motionctl read --drives zlac` lists them",
                address_text(address)
            )
        }),
        None => by_name(text),
    }
}

fn by_name(text: &str) -> Result<&'static Entry, String> {
    let mut named = dictionary::entries().filter(|entry| name(entry) == text);
    match (named.next(), named.next()) {
        (Some(entry), None) => Ok(entry),
        (Some(entry), Some(other)) => Err(format!(
            "{text} names {} and others: give the address, as in {}",
            address_text(entry.address),
            address_text(other.address)
        )),
        (None, _) => Err(format!(
            "{text} is no object: give an address as in 2014h or 202Fh:05, or a name as in rated-current"
        )),
    }
}

/// `2014h`, `2014`, `0x2014`, `202Fh:05`.
fn address(text: &str) -> Option<ObjectAddress> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    let index = index.strip_prefix("0x").unwrap_or(index);
    let index = index.strip_suffix(['h', 'H']).unwrap_or(index);
    let is_index = index.len() == 4 && index.bytes().all(|byte| byte.is_ascii_hexdigit());
    let sub = sub.strip_suffix(['h', 'H']).unwrap_or(sub);
    Some(ObjectAddress::new(
        is_index.then(|| u16::from_str_radix(index, 16).ok())??,
        u8::from_str_radix(sub, 16).ok()?,
    ))
}

/// A value of an object: decimal, or hexadecimal with 0x.
///
/// # Errors
/// What is wrong with the text.
pub(super) fn number(text: &str) -> Result<i64, String> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let number = match digits.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => digits.parse(),
    };
    number
        .map(|number| sign * number)
        .map_err(|_| format!("expected a number such as 12 or 0x0C, got {text}"))
}

/// Why `write` and `restore` leave an object alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LeftAlone {
    /// It is read-only.
    ReadOnly,
    /// It is a command, or a target, and could move the motor or do something for good.
    Command,
    /// It takes the drive to another place on the bus.
    Identity,
    /// It tells whether the drive has lost its power since it was homed.
    Mark,
}

/// The object that [`LeftAlone::Mark`] is about.
pub(super) const MARK: ObjectAddress = ObjectAddress::new(0x1803, 4);

impl LeftAlone {
    /// Why an object is left alone; `None` for a setting.
    pub(super) fn of(entry: &Entry) -> Option<Self> {
        let commands = [
            objects::CONTROL_WORD.address(),
            objects::MODE.address(),
            objects::TARGET_SPEED.address(),
            objects::TARGET_POSITION.address(),
            objects::TARGET_TORQUE.address(),
            objects::CLEAR_FEEDBACK_POSITION.address(),
            objects::CLEAR_ABSOLUTE_POSITION.address(),
            objects::STORE.address(),
            objects::EEPROM_UPDATE.address(),
        ];
        let identity = [
            objects::CAN_NODE.address(),
            objects::CAN_BIT_RATE.address(),
            // COB-IDs of SYNC and EMCY.
            ObjectAddress::new(0x1005, 0),
            ObjectAddress::new(0x1014, 0),
        ];
        if !entry.access.is_writable() {
            Some(Self::ReadOnly)
        } else if commands.contains(&entry.address) {
            Some(Self::Command)
        } else if entry.address == MARK {
            Some(Self::Mark)
        } else if identity.contains(&entry.address) {
            Some(Self::Identity)
        } else {
            None
        }
    }

    /// What to do in place of writing it.
    pub(super) fn advice(self, address: ObjectAddress) -> &'static str {
        let is = |object: ObjectAddress| address == object;
        match self {
            Self::Mark => {
                "it is reserved, and `motionctl home --drives zlac --origins` notes there that the drive has had power since"
            }
            Self::ReadOnly => "it is read-only: choose another object",
            Self::Identity
                if is(objects::CAN_NODE.address()) || is(objects::CAN_BIT_RATE.address()) =>
            {
                "it takes the drive to another place on the bus: use `motionctl assign-id --drives zlac`, which looks who else is there"
            }
            Self::Identity => {
                "it would give the drive identifiers of others, and this tool expects those of CiA 301"
            }
            Self::Command
                if is(objects::STORE.address()) || is(objects::EEPROM_UPDATE.address()) =>
            {
                "`write` saves by itself, and `motionctl reset --drives zlac --factory` restores the factory settings"
            }
            Self::Command
                if is(objects::CLEAR_FEEDBACK_POSITION.address())
                    || is(objects::CLEAR_ABSOLUTE_POSITION.address()) =>
            {
                "use `motionctl origin --drives zlac`"
            }
            Self::Command => {
                "it is a command that could move the motor: use `motionctl enable`, `jog` or `speed` with --drives zlac, which stop it again"
            }
        }
    }
}

/// An object that shall have a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ObjectSetting {
    pub(super) entry: &'static Entry,
    pub(super) value: i64,
}

impl ObjectSetting {
    /// A setting that was checked against the dictionary, and against what must not be written.
    ///
    /// # Errors
    /// What is wrong: expected, actual, what to do.
    pub(super) fn new(entry: &'static Entry, value: i64) -> Result<Self, String> {
        let address = address_text(entry.address);
        if let Some(reason) = LeftAlone::of(entry) {
            return Err(format!(
                "{address} ({}) is not written: {}",
                entry.name,
                reason.advice(entry.address)
            ));
        }
        entry
            .check(value)
            .map(|_| Self { entry, value })
            .map_err(|_| {
                format!(
                    "{address} ({}) must be {}..={}, got {value}",
                    entry.name, entry.min, entry.max
                )
            })
    }

    /// `OBJECT=VALUE`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let (left, value) = text
            .split_once('=')
            .ok_or_else(|| format!("expected OBJECT=VALUE, as in 2014h=120, got {text}"))?;
        Self::new(object(left.trim())?, number(value.trim())?)
    }
}

impl fmt::Display for ObjectSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = address_text(self.entry.address);
        write!(f, "{address} = {}", self.value)
    }
}

/// The settings of a drive, in the order of their addresses.
pub(super) fn settings() -> impl Iterator<Item = &'static Entry> {
    dictionary::entries().filter(|entry| LeftAlone::of(entry).is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_have_addresses_and_names() {
        for text in [
            "2014h",
            "2014",
            "0x2014",
            "2014h:00",
            "2014:0",
            "rated-current",
        ] {
            let entry = object(text).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(entry.address, ObjectAddress::new(0x2014, 0), "{text}");
        }
        let sub = object("202Fh:05").map(|entry| entry.name);
        assert_eq!(sub, Ok("speed resolution divider"));
        assert_eq!(
            object("speed-resolution-divider").map(|entry| entry.name),
            sub
        );
        for wrong in [
            "2024h",
            "202Fh:09",
            "rated",
            "",
            "2014h:",
            "20140",
            "hardware-version",
        ] {
            assert!(object(wrong).is_err(), "{wrong}");
        }
        let message = object("hardware-version").expect_err("two have it");
        assert!(message.contains("1009h:00"), "{message}");
    }

    #[test]
    fn most_settings_have_a_name_of_their_own() {
        let names: Vec<String> = settings()
            .filter(|entry| entry.address.index >= 0x2000)
            .map(name)
            .collect();
        let unique = |name: &&String| names.iter().filter(|other| other == name).count() == 1;
        // 2030h:04 and :05 are both not connected.
        assert_eq!(names.len() - names.iter().filter(unique).count(), 2);
    }

    #[test]
    fn what_moves_or_stores_is_not_written() {
        for (text, word) in [
            ("6040h=15", "could move"),
            ("60FFh=10", "could move"),
            ("2009h=1", "--factory"),
            ("2005h=1", "origin"),
            ("200Dh=7", "assign-id"),
            ("6041h=0", "read-only"),
            ("2014h=151", "0..=150, got 151"),
            ("2014h", "OBJECT=VALUE"),
            ("2014h=a", "such as 12"),
        ] {
            let error = ObjectSetting::parse(text).expect_err(text);
            assert!(error.contains(word), "{text}: {error}");
        }
        assert!(ObjectSetting::parse("2011h=-20").is_ok());
        assert!(ObjectSetting::parse("1600h:01=0x60400010").is_ok());
    }
}
