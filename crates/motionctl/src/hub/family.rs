//! Which command lines are for hub motors, and the words that make no sense for them.

use core::fmt;
use std::ffi::{OsStr, OsString};

use crate::exit::{self, Coded};

/// Words that have one command line for both families, and read `--drives zlac` themselves.
const SHARED: [&str; 2] = ["sim", "completions"];

/// Words of servo drives that hub motors do not have, and why.
const REFUSED: [(&str, &str); 2] = [
    (
        "probe",
        "finds out the byte order of a DYN drive. CANopen lays down that the lowest byte comes first, so there is nothing to find out: use `motionctl read --drives zlac`",
    ),
    (
        "limits",
        "measures how many servo axes a bus carries. `motionctl plan --drives zlac` works it out for hub motors",
    ),
];

/// A word that hub motors do not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotForHubMotors {
    word: &'static str,
    reason: &'static str,
}

impl fmt::Display for NotForHubMotors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "`{}` is not for hub motors: it {}. Nothing was sent",
            self.word, self.reason
        )
    }
}

impl std::error::Error for NotForHubMotors {}

impl Coded for NotForHubMotors {
    fn exit_code(&self) -> u8 {
        exit::BAD_INPUT
    }
}

/// Whether a command line is for hub motors.
pub(crate) fn is_meant(words: &[OsString]) -> bool {
    let is_shared = |word: &OsString| SHARED.iter().any(|shared| word == OsStr::new(shared));
    let Some(word) = words.get(1) else {
        return false;
    };
    let names_family = |text: &OsStr| {
        text.to_str()
            .is_some_and(|text| text == "zlac" || text.starts_with("zlac:"))
    };
    let options = words.get(2..).unwrap_or_default();
    let behind = options.iter().skip(1);
    let pairs = options.iter().zip(behind);
    !is_shared(word)
        && (pairs
            .into_iter()
            .any(|(option, value)| option == "--drives" && names_family(value))
            || options.iter().any(|option| {
                option
                    .to_str()
                    .and_then(|text| text.strip_prefix("--drives="))
                    .is_some_and(|value| names_family(OsStr::new(value)))
            }))
}

/// The refusal of a word that hub motors do not have.
pub(super) fn refusal(words: &[OsString]) -> Option<NotForHubMotors> {
    let word = words.get(1)?;
    let mut refused = REFUSED.into_iter();
    let (word, reason) = refused.find(|(refused, _)| word == OsStr::new(refused))?;
    Some(NotForHubMotors { word, reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn the_family_is_named_by_the_drives() {
        for meant in [
            "motionctl read --drives zlac --can can0",
            "motionctl bench --slcan x --drives zlac:4,5",
            "motionctl probe --drives=zlac",
        ] {
            assert!(is_meant(&words(meant)), "{meant}");
        }
        for other in [
            "motionctl",
            "motionctl read",
            "motionctl --drives zlac",
            "motionctl sim --drives zlac",
            "motionctl enable --drives 1,2",
            "motionctl enable --slcan zlac",
            "motionctl enable --drives zlacs",
        ] {
            assert!(!is_meant(&words(other)), "{other}");
        }
    }

    #[test]
    fn words_without_a_meaning_say_why() {
        let text = refusal(&words("motionctl probe --drives zlac"))
            .expect("a refusal")
            .to_string();
        assert!(text.contains("lowest byte comes first"), "{text}");
        assert_eq!(refusal(&words("motionctl read --drives zlac")), None);
    }
}
