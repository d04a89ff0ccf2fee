//! What must have a row. Codes and objects come from the tables of the codecs; settings and chapters are listed here, from the documents.

use dyn_can::{FunctionCode, Revision};
use dyn_serial::{ReplyFunction, RequestFunction};
use zlac8030l::dictionary;

/// What the page says of a table.
pub(crate) struct Required {
    pub(crate) heading: &'static str,
    /// Columns in front of the answers.
    pub(crate) keys: &'static [&'static str],
    pub(crate) answers: Answers,
    pub(crate) rows: Vec<Expected>,
}

/// What the other columns are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answers {
    /// One cell for each layer.
    Layers,
    /// Where it is, and what is missing.
    WhereAndMissing,
}

/// One row, or one part of a row that names several objects.
#[derive(Debug, Clone)]
pub(crate) struct Expected {
    /// The first cell.
    pub(crate) key: String,
    /// The other key cells, where they are known.
    pub(crate) others: Vec<Option<String>>,
    /// The last name in the codec, where one message belongs to it.
    pub(crate) codec: Option<String>,
}

/// Settings of DYN servo drives: parameters, then bits of the configuration byte, the status byte and data bytes with a meaning
/// (1.6A sections 5 and 6, DYN2 manual A1.8 sections 5.1 and 7.3).
const DYN_SETTINGS: [&str; 42] = [
    "main gain",
    "speed gain",
    "integration gain",
    "torque filter constant",
    "max speed",
    "max acceleration",
    "on-position range",
    "gear number",
    "line number",
    "drive id",
    "config b1-b0 = 0",
    "config b1-b0 = 1",
    "config b1-b0 = 2",
    "config b1-b0 = 3",
    "config b2",
    "config b4-b3 = 0",
    "config b4-b3 = 1",
    "config b4-b3 = 2",
    "config b5",
    "config b7-b6",
    "status b0",
    "status b1",
    "status b4-b2 = 1",
    "status b4-b2 = 2",
    "status b4-b2 = 3",
    "status b4-b2 = 4",
    "status b4-b2 = 5-7",
    "status b5",
    "status b7-b6",
    "0x00 FF, AB",
    "0x0E 1B",
    "0x0E 1E",
    "0x18 FF",
    "0x18 EE",
    "0x19 00",
    "0x19 FF",
    "0x1B FE",
    "0x1D FF",
    "0x1D EE",
    "identifier",
    "broadcast id 0",
    "bit rates",
];

/// Sections of the CAN specifications; both revisions have the same.
const CAN_CHAPTERS: [&str; 6] = ["1", "2", "3", "4", "5", "6"];

/// Sections of the DYN2 manual A1.8, by their place: some are printed with another number (M16).
const MANUAL_CHAPTERS: [&str; 44] = [
    "A.1", "A.2", "A.3", "1.1", "1.2", "1.3", "2.1", "2.2", "2.3", "2.4", "2.5", "3.1", "3.2",
    "3.3", "4.1", "4.2", "4.3", "4.4", "4.5", "4.6", "5.1", "5.2", "6.1", "6.2", "7", "7.1",
    "7.2.1", "7.2.2", "7.2.3", "7.2.4", "7.2.5", "7.2.6", "7.3", "7.4.1", "7.4.2", "7.5", "7.6",
    "7.7", "7.8", "7.9", "8", "9", "App. A", "App. B",
];

/// Sections of the ZLAC8030L guide V1.00.
const GUIDE_CHAPTERS: [&str; 29] = [
    "1", "2.1", "2.2", "3.1", "3.2", "3.3.1", "3.3.2", "3.3.3", "3.4", "4.1", "4.2", "4.3", "4.4",
    "4.5", "4.6", "5.1", "5.2", "5.3", "5.4.1", "5.4.2", "5.5.1", "5.5.2", "6.1", "6.2", "6.3",
    "7.1", "7.2", "7.3", "8",
];

/// Section 9 is the dictionary.
const GUIDE_DICTIONARY: &str = "9";

/// Every table of the page.
pub(crate) fn required() -> Vec<Required> {
    let layers = |heading, keys, rows| Required {
        heading,
        keys,
        answers: Answers::Layers,
        rows,
    };
    let chapters = |heading, chapters: &mut dyn Iterator<Item = &'static str>| Required {
        heading,
        keys: &["Section", "Subject"],
        answers: Answers::WhereAndMissing,
        rows: chapters.map(|chapter| free(chapter, 1)).collect(),
    };
    vec![
        layers(
            "DYN CAN: function codes",
            &["Code", "Function", "Revision"],
            FunctionCode::ALL.map(can_function).to_vec(),
        ),
        layers(
            "DYN232M: host to drive",
            &["Code", "Function"],
            RequestFunction::ALL.iter().map(serial_request).collect(),
        ),
        layers(
            "DYN232M: drive to host",
            &["Code", "Function"],
            ReplyFunction::ALL.iter().map(serial_reply).collect(),
        ),
        layers(
            "DYN drives: parameters, bits and data bytes",
            &["Setting", "Meaning"],
            DYN_SETTINGS.map(|setting| free(setting, 1)).to_vec(),
        ),
        layers(
            "ZLAC8030L: objects",
            &["Object", "Name"],
            dictionary::entries().map(object).collect(),
        ),
        chapters("CAN specification 1.2A", &mut CAN_CHAPTERS.into_iter()),
        chapters("CAN specification 1.6A", &mut CAN_CHAPTERS.into_iter()),
        chapters("DYN2 manual A1.8", &mut MANUAL_CHAPTERS.into_iter()),
        chapters(
            "ZLAC8030L guide V1.00",
            &mut GUIDE_CHAPTERS.into_iter().chain([GUIDE_DICTIONARY]),
        ),
    ]
}

fn free(key: &str, others: usize) -> Expected {
    Expected {
        key: key.to_owned(),
        others: vec![None; others],
        codec: None,
    }
}

fn can_function(function: FunctionCode) -> Expected {
    let exists = |revision| {
        function.admit_request(revision).is_ok() || function.admit_reply(revision).is_ok()
    };
    let revision = match (exists(Revision::V1_2A), exists(Revision::V1_6A)) {
        (true, true) => "both",
        (true, false) => "1.2A",
        (false, true) => "1.6A",
        // The factory's own, which neither a master nor a drive of either revision sends to the other.
        (false, false) => "both",
    };
    let is_sent = exists(Revision::V1_2A) || exists(Revision::V1_6A);
    Expected {
        key: format!("0x{:02X}", function as u8),
        others: vec![Some(function.name().to_owned()), Some(revision.to_owned())],
        codec: is_sent.then(|| format!("{function:?}")),
    }
}

fn serial_request(function: &RequestFunction) -> Expected {
    Expected {
        key: format!("0x{:02X}", function.code()),
        others: vec![Some(function.name().to_owned())],
        codec: (*function != RequestFunction::ForMotorDefine).then(|| format!("{function:?}")),
    }
}

fn serial_reply(function: &ReplyFunction) -> Expected {
    Expected {
        key: format!("0x{:02X}", function.code()),
        others: vec![Some(function.name().to_owned())],
        codec: None,
    }
}

fn object(entry: &dictionary::Entry) -> Expected {
    Expected {
        key: object_key(entry.address.index, entry.address.sub),
        others: vec![Some(entry.name.to_owned())],
        codec: None,
    }
}

/// An object as the page writes it.
pub(crate) fn object_key(index: u16, sub: u8) -> String {
    format!("{index:04X}h:{sub:02X}")
}

/// The objects of a first cell: `1017h:00`, or a range of indices, sub-indices or both, as in `1400h-1403h:02-05`.
pub(crate) fn objects_of(cell: &str) -> Option<Vec<String>> {
    let hex = |text: &str, digits| {
        (text.len() == digits)
            .then(|| u16::from_str_radix(text, 16).ok())
            .flatten()
    };
    let (indices, subs) = cell.split_once(':')?;
    let (first, last) = indices.split_once('-').unwrap_or((indices, indices));
    let index = |text: &str| hex(text.strip_suffix('h')?, 4);
    let (first_sub, last_sub) = subs.split_once('-').unwrap_or((subs, subs));
    let (subs, indices) = (
        hex(first_sub, 2)?..=hex(last_sub, 2)?,
        index(first)?..=index(last)?,
    );
    let keys = indices.flat_map(|index| {
        let of_index = subs.clone();
        of_index.map(move |sub| format!("{index:04X}h:{sub:02X}"))
    });
    Some(keys.collect())
}
