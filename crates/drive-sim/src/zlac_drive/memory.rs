//! Object values in RAM and EEPROM, and how often the EEPROM was written.
//!
//! Law: RAM starts from the EEPROM at each power-on; objects without a place there start from their defaults.

use std::collections::BTreeMap;

use zlac8030l::ObjectAddress;
use zlac8030l::dictionary::{self, Entry};

use super::config::ZlacDriveConfig;
use super::objects::{self, Address};

/// Writes of the EEPROM since the drive was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct EepromWear {
    /// RW/S writes while 2010h was 0: one cell each.
    pub single_writes: u64,
    /// 2009h = 2: everything at once.
    pub saves: u64,
    /// 2009h = 1: factory settings.
    pub restores: u64,
}

#[derive(Debug, Clone)]
pub(super) struct Memory {
    ram: BTreeMap<Address, u32>,
    eeprom: BTreeMap<Address, u32>,
    wear: EepromWear,
}

impl Memory {
    pub(super) fn new(config: &ZlacDriveConfig) -> Self {
        let mut memory = Self {
            ram: BTreeMap::new(),
            eeprom: factory(config),
            wear: EepromWear::default(),
        };
        for (address, value) in &config.stored {
            // The lower bits of a negative number are its bits in a narrower type.
            memory
                .eeprom
                .insert((address.index, address.sub), *value as u32);
        }
        memory.power_on(config);
        memory
    }

    pub(super) fn power_on(&mut self, config: &ZlacDriveConfig) {
        self.ram = defaults(config);
        self.ram.extend(&self.eeprom);
        self.set(
            objects::SOFTWARE_VERSION,
            u32::from(config.software_version),
        );
    }

    pub(super) fn get(&self, address: Address) -> u32 {
        self.ram.get(&address).copied().unwrap_or(0)
    }

    pub(super) fn signed(&self, address: Address) -> i32 {
        self.get(address) as i32
    }

    pub(super) fn set(&mut self, address: Address, value: u32) {
        self.ram.insert(address, value);
    }

    /// A write of a master: an RW/S object goes to the EEPROM too, unless 2010h is 1.
    pub(super) fn write(&mut self, entry: &Entry, value: u32) {
        let address = (entry.address.index, entry.address.sub);
        self.set(address, value);
        if entry.access.is_stored() && self.get(objects::EEPROM_UPDATE) == 0 {
            self.eeprom.insert(address, value);
            self.wear.single_writes += 1;
        }
    }

    /// 2009h. Factory settings take effect at the next power-on.
    pub(super) fn store(&mut self, command: u32, config: &ZlacDriveConfig) {
        match command {
            1 => {
                self.eeprom = factory(config);
                self.wear.restores += 1;
            }
            2 => {
                for (address, value) in &mut self.eeprom {
                    *value = self.ram.get(address).copied().unwrap_or(*value);
                }
                self.wear.saves += 1;
            }
            _ => {}
        }
        self.set(objects::STORE, 0);
    }

    pub(super) fn wear(&self) -> EepromWear {
        self.wear
    }

    pub(super) fn has_emergency_input(&self) -> bool {
        [objects::INPUT_X0, objects::INPUT_X1]
            .into_iter()
            .any(|input| self.get(input) == objects::INPUT_EMERGENCY_STOP)
    }
}

pub(super) fn row((index, sub): Address) -> Option<&'static Entry> {
    dictionary::find(ObjectAddress::new(index, sub))
}

fn defaults(config: &ZlacDriveConfig) -> BTreeMap<Address, u32> {
    let value = |entry: &Entry| entry.default.of(config.node).unwrap_or(0) as u32;
    dictionary::entries()
        .map(|entry| ((entry.address.index, entry.address.sub), value(entry)))
        .collect()
}

/// What the EEPROM has a place for: RW/S objects, and the mapping counts, without which saved entries would be worth nothing.
fn factory(config: &ZlacDriveConfig) -> BTreeMap<Address, u32> {
    let is_count =
        |(index, sub): Address| sub == 0 && matches!(index, 0x1600..=0x1603 | 0x1A00..=0x1A03);
    defaults(config)
        .into_iter()
        .filter(|(address, _)| {
            is_count(*address) || row(*address).is_some_and(|entry| entry.access.is_stored())
        })
        .collect()
}
