//! Brings objects of a drive to values: compare, write, read back, save once.
//!
//! 2010h = 1 comes first, so that no write reaches the EEPROM by itself; one save (2009h = 2) at the end stores everything. That is right
//! whether or not a firmware stores each write at once (Z32), and until the save a power cycle undoes everything. The save also stores
//! what a master has left in the RAM of the drive.

use core::fmt;
use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::dictionary::{self, Access};
use zlac8030l::{NmtCommand, NmtRequest, NodeId, ObjectAddress, SdoRequest, objects};

use super::bus::Bus;
use super::error::HubError;
use super::object::{ObjectSetting, address_text, name};
use crate::counted::counted;

/// What has become of an object that differed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ChangeEnd {
    /// Written, and read back as written.
    Written,
    /// Sent, and another value was read back.
    NotTaken,
    /// The drive answered with an abort.
    Refused,
    /// Something failed meanwhile: it may be written or not.
    Unknown,
    /// Not sent.
    NotWritten,
}

impl ChangeEnd {
    const fn words(self) -> &'static str {
        match self {
            Self::Written => "written",
            Self::NotTaken => "NOT TAKEN",
            Self::Refused => "REFUSED",
            Self::Unknown => "NOT KNOWN, it may be written or not",
            Self::NotWritten => "not written",
        }
    }
}

/// An object that differs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(super) struct Change {
    object: String,
    name: String,
    pub(super) before: i64,
    pub(super) value: i64,
    /// The drive has a place for it in its EEPROM; others last until the power goes.
    stored: bool,
    /// It is in force when the drive has started anew (guide 5.3), and nothing shows whether it is.
    after_restart: bool,
    pub(super) result: ChangeEnd,
    #[serde(skip)]
    setting: Option<ObjectSetting>,
}

/// What has become of one drive.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(super) struct NodeOutcome {
    pub(super) node: u8,
    /// Objects that had their value already.
    pub(super) same: usize,
    pub(super) changes: Vec<Change>,
    pub(super) saved: bool,
    /// One for the save of all changes, none without it.
    pub(super) eeprom_writes: u32,
    /// The save was not confirmed.
    pub(super) eeprom_writes_in_doubt: u32,
    /// PDO parameters were changed, for which the drive was made pre-operational.
    pub(super) pre_operational: bool,
    /// PDOs whose mapping was closed and not opened again.
    pub(super) closed_mappings: Vec<String>,
}

impl NodeOutcome {
    /// Reads objects and notes those that differ.
    ///
    /// # Errors
    /// As [`Bus::read_number`].
    pub(super) fn compare(
        bus: &mut Bus,
        node: NodeId,
        wanted: &[ObjectSetting],
    ) -> Result<Self, HubError> {
        let mut changes = Vec::new();
        for setting in wanted {
            let entry = setting.entry;
            let before = bus.read_number(node, entry.address)?;
            if before != setting.value {
                changes.push(Change {
                    object: address_text(entry.address),
                    name: name(entry),
                    before,
                    value: setting.value,
                    stored: is_kept(entry.address),
                    after_restart: entry.address == objects::SPEED_RESOLUTION.address(),
                    result: ChangeEnd::NotWritten,
                    setting: Some(*setting),
                });
            }
        }
        Ok(Self {
            node: node.get(),
            same: wanted.len() - changes.len(),
            changes,
            saved: false,
            eeprom_writes: 0,
            eeprom_writes_in_doubt: 0,
            pre_operational: false,
            closed_mappings: Vec::new(),
        })
    }

    /// Whether nothing differs.
    pub(super) fn is_same(&self) -> bool {
        self.changes.is_empty()
    }

    /// Something is in the RAM of the drive, or may be.
    pub(super) fn has_written(&self) -> bool {
        let is_there =
            |change: &Change| matches!(change.result, ChangeEnd::Written | ChangeEnd::Unknown);
        self.changes.iter().any(is_there)
            || self.eeprom_writes > 0
            || !self.closed_mappings.is_empty()
    }

    /// Writes what differs, reads it back, and saves it. The user has agreed.
    ///
    /// # Errors
    /// The first thing that did not succeed, after which nothing more is written; the outcome tells how far it came.
    pub(super) fn write(
        &mut self,
        bus: &mut Bus,
        node: NodeId,
        saves: bool,
    ) -> Result<(), HubError> {
        if self.is_same() {
            return Ok(());
        }
        let update_before = bus.read(node, objects::EEPROM_UPDATE)?;
        protect(bus, node)?;
        self.close_mappings(bus, node)?;
        for place in self.order() {
            self.write_one(bus, node, place)?;
        }
        if saves && self.changes.iter().any(|change| change.stored) {
            self.save(bus, node)?;
        }
        let update = objects::EEPROM_UPDATE.write(update_before);
        bus.write(node, update)
    }

    /// PDO parameters change in pre-operational only, and a mapping while its count is 0 (guide section 6, Z20).
    fn close_mappings(&mut self, bus: &mut Bus, node: NodeId) -> Result<(), HubError> {
        let addresses: Vec<ObjectAddress> = self.settings().map(|set| set.entry.address).collect();
        if !addresses.iter().any(|address| is_pdo(*address)) {
            return Ok(());
        }
        bus.command(NmtRequest {
            command: NmtCommand::PreOperational,
            node: Some(node),
        })?;
        self.pre_operational = true;
        let mappings: BTreeSet<u16> = addresses
            .iter()
            .filter(|address| is_mapping(**address))
            .map(|address| address.index)
            .collect();
        for index in mappings {
            let count = ObjectAddress::new(index, 0);
            let present = bus.read_number(node, count)?;
            let is_listed = addresses.contains(&count);
            if let Some(setting) = setting_of(count, present).filter(|_| !is_listed) {
                // Opened for its entries and closed again as it was.
                self.changes.push(Change {
                    object: address_text(count),
                    name: name(setting.entry),
                    before: present,
                    value: present,
                    stored: true,
                    after_restart: false,
                    result: ChangeEnd::NotWritten,
                    setting: Some(setting),
                });
            }
            if let Some(zero) = setting_of(count, 0) {
                // Noted first: a write that is not confirmed may have arrived.
                self.closed_mappings.push(address_text(count));
                bus.write(node, request(&zero)?)?;
            }
        }
        Ok(())
    }

    fn settings(&self) -> impl Iterator<Item = ObjectSetting> + '_ {
        self.changes.iter().filter_map(|change| change.setting)
    }

    /// Counts of mappings behind their entries, everything else by address.
    fn order(&self) -> Vec<usize> {
        let key = |place: &usize| {
            let setting = self.changes[*place].setting;
            let address = setting.map_or(ObjectAddress::new(0, 0), |set| set.entry.address);
            let is_count = is_mapping(address) && address.sub == 0;
            (address.index, is_count, address.sub)
        };
        let mut order: Vec<usize> = (0..self.changes.len()).collect();
        order.sort_by_key(key);
        order
    }

    fn write_one(&mut self, bus: &mut Bus, node: NodeId, place: usize) -> Result<(), HubError> {
        let change = &mut self.changes[place];
        let Some(setting) = change.setting else {
            return Ok(());
        };
        let address = setting.entry.address;
        change.result = ChangeEnd::Unknown;
        match bus.write(node, request(&setting)?) {
            // Whether it arrived is read back.
            Ok(()) | Err(HubError::WriteInDoubt { .. }) => {}
            Err(error @ HubError::Refused { .. }) => {
                change.result = ChangeEnd::Refused;
                return Err(error);
            }
            Err(error) => return Err(error),
        }
        let actual = bus.read_number(node, address)?;
        if actual == setting.value {
            change.result = ChangeEnd::Written;
            let object = change.object.clone();
            self.closed_mappings.retain(|closed| *closed != object);
            return Ok(());
        }
        change.result = ChangeEnd::NotTaken;
        Err(HubError::NotTaken {
            node,
            address,
            expected: setting.value,
            actual,
        })
    }

    fn save(&mut self, bus: &mut Bus, node: NodeId) -> Result<(), HubError> {
        let save = objects::STORE.write(objects::STORE_SAVE_ALL);
        let saved = bus.write(node, save);
        match saved {
            Ok(()) => {
                self.saved = true;
                self.eeprom_writes = 1;
            }
            Err(_) => self.eeprom_writes_in_doubt = 1,
        }
        saved
    }
}

/// No RW/S write reaches the EEPROM by itself from here on.
///
/// # Errors
/// [`HubError::NotTaken`], or as [`Bus::write`].
pub(super) fn protect(bus: &mut Bus, node: NodeId) -> Result<(), HubError> {
    let off = objects::EEPROM_UPDATE_OFF;
    bus.write(node, objects::EEPROM_UPDATE.write(off))?;
    let actual = bus.read(node, objects::EEPROM_UPDATE)?;
    if actual == off {
        return Ok(());
    }
    Err(HubError::NotTaken {
        node,
        address: objects::EEPROM_UPDATE.address(),
        expected: off.into(),
        actual: actual.into(),
    })
}

/// The write of a setting.
///
/// # Errors
/// [`HubError::Input`] for a value that the object cannot hold.
pub(super) fn request(setting: &ObjectSetting) -> Result<SdoRequest, HubError> {
    let made = setting.entry.write(setting.value);
    made.map_err(|error| HubError::Input(error.to_string()))
}

fn setting_of(address: ObjectAddress, value: i64) -> Option<ObjectSetting> {
    let entry = dictionary::find(address)?;
    Some(ObjectSetting { entry, value })
}

fn is_mapping(address: ObjectAddress) -> bool {
    matches!(address.index, 0x1600..=0x1603 | 0x1A00..=0x1A03)
}

fn is_pdo(address: ObjectAddress) -> bool {
    is_mapping(address) || matches!(address.index, 0x1400..=0x1403 | 0x1800..=0x1803)
}

/// The drive keeps it over a power cycle, once it is saved. A saved mapping is worth nothing without its count (Z18).
fn is_kept(address: ObjectAddress) -> bool {
    let is_stored = dictionary::find(address).is_some_and(|entry| entry.access == Access::RwS);
    is_stored || is_mapping(address)
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (object, name) = (&self.object, &self.name);
        write!(f, "{object} {name}: {} -> {}", self.before, self.value)
    }
}

impl fmt::Display for NodeOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let same = counted(self.same as u64, "object", "objects");
        writeln!(f, "node {}: {same} the same", self.node)?;
        for change in &self.changes {
            writeln!(
                f,
                "  {change}  {}{}",
                change.result.words(),
                if change.stored {
                    ""
                } else {
                    ", until the power goes"
                }
            )?;
        }
        let was_written = |change: &&Change| change.result == ChangeEnd::Written;
        for change in self.changes.iter().filter(was_written) {
            if change.after_restart {
                writeln!(
                    f,
                    "  {} counts when the drive has been switched off and on: do that before a wheel turns, or it turns at other speeds than it is told",
                    change.object
                )?;
            }
        }
        if self.pre_operational {
            writeln!(f, "  the drive is pre-operational now, as after power-on")?;
        }
        for closed in &self.closed_mappings {
            writeln!(
                f,
                "  {closed} is 0 NOW: its PDO does not run until it is written again, or the power goes"
            )?;
        }
        write!(f, "  EEPROM writes: {}", self.eeprom_writes)?;
        match self.eeprom_writes_in_doubt {
            0 => Ok(()),
            more => write!(f, ", and perhaps {more} more"),
        }
    }
}
