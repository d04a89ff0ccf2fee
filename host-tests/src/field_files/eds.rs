//! The electronic data sheet of the ZLAC8030L (CiA 306-1): the dictionary of the codec, section by section.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use zlac8030l::DataType;
use zlac8030l::dictionary::{self, Access, Default, Entry};

/// Object codes of CiA 301.
const VARIABLE: u8 = 0x7;
const RECORD: u8 = 0x9;
/// Objects of which CiA 301 says that every device has them.
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];
const MANUFACTURER: std::ops::Range<u16> = 0x2000..0x6000;
/// The date of the guide that the table was read from; a data sheet needs one, and today's would change with every build.
const DATE: &str = "01-01-2026";

/// What a data sheet cannot say otherwise.
const COMMENTS: [&str; 9] = [
    "Made of the dictionary of the crate zlac8030l: 194 objects of the vendor's CANopen guide V1.00.",
    "Not the vendor's file: names are this project's, numbers are the guide's.",
    "The drives also know 100 kbit/s, for which a data sheet has no key.",
    "The PDOs begin at 0: RPDO0 is 1400h, identifier 200h + node (errata Z20).",
    "The COB-IDs of PDOs are read-only: mapping changes in pre-operational, count 0 first (Z20).",
    "Event timers and inhibit times count 0.5 ms by the guide, 1 ms and 0.1 ms by CiA 301 (Z11).",
    "Writes of what has a place in the EEPROM wear it unless 2010h is 1 (Z32).",
    "Sub-index 0 of some records counts more entries than the guide lists (Z23); here it is the highest listed.",
    "Sub-index 0 of manufacturer's records is U16 in the guide and UNSIGNED8 here, as CiA 301 has it.",
];

/// The text of the file.
#[must_use]
pub fn electronic_data_sheet() -> String {
    let mut objects: BTreeMap<u16, Vec<&Entry>> = BTreeMap::new();
    for entry in dictionary::entries() {
        objects.entry(entry.address.index).or_default().push(entry);
    }
    let mut text = String::new();
    write(&mut text, &objects).expect("a string has room");
    text
}

fn write(to: &mut String, objects: &BTreeMap<u16, Vec<&Entry>>) -> fmt::Result {
    write_head(to)?;
    writeln!(to, "[Comments]\nLines={}", COMMENTS.len())?;
    for (number, line) in (1..).zip(COMMENTS) {
        writeln!(to, "Line{number}={line}")?;
    }
    let is_manufacturers = |index: u16| MANUFACTURER.contains(&index);
    let is_mandatory = |index: u16| MANDATORY.contains(&index);
    let all = || objects.keys().copied();
    write_list(
        to,
        "MandatoryObjects",
        all().filter(|&index| is_mandatory(index)),
    )?;
    let optional = all().filter(|&index| !is_mandatory(index) && !is_manufacturers(index));
    write_list(to, "OptionalObjects", optional)?;
    write_list(
        to,
        "ManufacturerObjects",
        all().filter(|&index| is_manufacturers(index)),
    )?;
    objects
        .iter()
        .try_for_each(|(index, entries)| write_object(to, *index, entries))
}

fn write_head(to: &mut String) -> fmt::Result {
    writeln!(
        to,
        "[FileInfo]\nFileName=zlac8030l.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n\
         Description=ZLAC8030L hub-motor drive\nCreationTime=12:00AM\nCreationDate={DATE}\nCreatedBy=\n\
         ModificationTime=12:00AM\nModificationDate={DATE}\nModifiedBy=\n"
    )?;
    let value = |index, sub| default_of(index, sub).unwrap_or(0);
    writeln!(
        to,
        "[DeviceInfo]\nVendorName=ZLTECH\nVendorNumber={:#X}\nProductName=ZLAC8030L\nProductNumber={:#X}\nRevisionNumber=0\n\
         OrderCode=\nBaudRate_10=0\nBaudRate_20=0\nBaudRate_50=0\nBaudRate_125=1\nBaudRate_250=1\nBaudRate_500=1\n\
         BaudRate_800=0\nBaudRate_1000=1\nSimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=0\n\
         DynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO=4\nNrOfTXPDO=4\nLSS_Supported=0\n",
        value(0x1018, 1),
        value(0x1018, 2),
    )?;
    // The guide says nothing of dummy mapping.
    writeln!(to, "[DummyUsage]")?;
    for number in 1..=7 {
        writeln!(to, "Dummy{number:04}=0")?;
    }
    writeln!(to)
}

/// The number that the guide prints as default.
fn default_of(index: u16, sub: u8) -> Option<i64> {
    let address = zlac8030l::ObjectAddress::new(index, sub);
    match dictionary::find(address)?.default {
        Default::Value(value) => Some(value),
        Default::CanId(_) | Default::Unstated => None,
    }
}

fn write_list(to: &mut String, name: &str, indices: impl Iterator<Item = u16>) -> fmt::Result {
    let indices: Vec<u16> = indices.collect();
    writeln!(to, "\n[{name}]\nSupportedObjects={}", indices.len())?;
    for (number, index) in (1..).zip(indices) {
        writeln!(to, "{number}=0x{index:04X}")?;
    }
    Ok(())
}

fn write_object(to: &mut String, index: u16, entries: &[&Entry]) -> fmt::Result {
    if let [only] = entries {
        writeln!(to, "\n[{index:04X}]")?;
        return write_variable(to, only, None);
    }
    let highest = entries.iter().map(|entry| entry.address.sub).max();
    writeln!(
        to,
        "\n[{index:04X}]\nParameterName={}\nObjectType=0x{RECORD:X}\nSubNumber={}",
        record_name(entries),
        entries.len(),
    )?;
    for entry in entries {
        writeln!(to, "\n[{index:04X}sub{:X}]", entry.address.sub)?;
        let count = highest.filter(|_| entry.address.sub == 0);
        write_variable(to, entry, count)?;
    }
    Ok(())
}

/// What the entries of a record have in common: the name of sub-index 0 up to its last comma.
fn record_name<'a>(entries: &[&'a Entry]) -> &'a str {
    let name = entries.first().map_or("", |entry| entry.name);
    name.rsplit_once(", ").map_or(name, |(common, _)| common)
}

/// `count` is the number of entries of a record, at its sub-index 0.
fn write_variable(to: &mut String, entry: &Entry, count: Option<u8>) -> fmt::Result {
    let unit = if entry.unit.is_empty() {
        String::new()
    } else {
        format!(" [{}]", entry.unit)
    };
    let access = match entry.access {
        Access::Ro => "ro",
        Access::Rw | Access::RwS => "rw",
    };
    writeln!(
        to,
        "ParameterName={}{unit}\nObjectType=0x{VARIABLE:X}\nDataType=0x{:04X}\nAccessType={access}",
        entry.name,
        data_type(count.map_or(entry.data_type, |_| DataType::U8)),
    )?;
    match (count, entry.default) {
        // A mapping has as many entries as are in use.
        (Some(highest), _) if !entry.access.is_writable() => {
            writeln!(to, "DefaultValue={highest}")?;
        }
        (_, Default::Value(value)) => writeln!(to, "DefaultValue={value}")?,
        (_, Default::CanId(base)) => writeln!(to, "DefaultValue=$NODEID+0x{base:X}")?,
        (_, Default::Unstated) => {}
    }
    if count.is_none() && (entry.min, entry.max) != (entry.data_type.min(), entry.data_type.max()) {
        writeln!(to, "LowLimit={}\nHighLimit={}", entry.min, entry.max)?;
    }
    writeln!(to, "PDOMapping={}", u8::from(entry.mappable))
}

/// Numbers of CiA 301, table of data types.
const fn data_type(of: DataType) -> u16 {
    match of {
        DataType::I8 => 0x0002,
        DataType::I16 => 0x0003,
        DataType::I32 => 0x0004,
        DataType::U8 => 0x0005,
        DataType::U16 => 0x0006,
        DataType::U32 => 0x0007,
    }
}
