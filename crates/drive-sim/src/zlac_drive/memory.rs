//! Object values in RAM and EEPROM, and how often the EEPROM was written.
//!
//! Specification: RAM starts from the EEPROM at each power-on; objects without a place there start from their defaults.

use std::collections::BTreeMap;

use can_frame::BitRate;
use zlac8030l::dictionary::{self, Entry};
use zlac8030l::{NodeId, ObjectAddress};

use super::config::ZlacDriveConfig;
use super::objects::{self, Address};

/// Node numbers below come from the DIP switch alone (guide section 9, 200Dh).
const LEAST_STORED_NODE: u8 = 4;

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
            eeprom: factory(config.node),
            wear: EepromWear::default(),
        };
        // Stored when the drive was commissioned.
        let node = u32::from(config.node.get().max(LEAST_STORED_NODE));
        memory.eeprom.insert(objects::NODE_NUMBER, node);
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
        self.ram = defaults(self.stored_node(config));
        self.ram.extend(&self.eeprom);
        self.set(
            objects::SOFTWARE_VERSION,
            u32::from(config.software_version),
        );
    }

    /// The node number of the next start: 200Dh, where the DIP switch leaves it open.
    pub(super) fn stored_node(&self, config: &ZlacDriveConfig) -> NodeId {
        let stored = self.eeprom.get(&objects::NODE_NUMBER).copied().unwrap_or(0);
        let stored = NodeId::new(stored as i32).unwrap_or(config.node);
        if config.node.get() < LEAST_STORED_NODE {
            config.node
        } else {
            stored
        }
    }

    /// Whether the bit rate in force is that of the bus; its code counts from the fastest (200Eh).
    pub(super) fn has_bit_rate(&self, bus: BitRate) -> bool {
        const KBIT_PER_S: [u32; 5] = [1_000, 500, 250, 125, 100];
        let stored = KBIT_PER_S.get(self.get(objects::BIT_RATE) as usize);
        stored == Some(&bus.kbit_per_s())
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
                self.eeprom = factory(config.node);
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

fn defaults(node: NodeId) -> BTreeMap<Address, u32> {
    let value = |entry: &Entry| entry.default.of(node).unwrap_or(0) as u32;
    dictionary::entries()
        .map(|entry| ((entry.address.index, entry.address.sub), value(entry)))
        .collect()
}

/// What the EEPROM has a place for: RW/S objects, and the mapping counts, without which saved entries would be worth nothing.
fn factory(node: NodeId) -> BTreeMap<Address, u32> {
    let is_count =
        |(index, sub): Address| sub == 0 && matches!(index, 0x1600..=0x1603 | 0x1A00..=0x1A03);
    defaults(node)
        .into_iter()
        .filter(|(address, _)| {
            is_count(*address) || row(*address).is_some_and(|entry| entry.access.is_stored())
        })
        .collect()
}
