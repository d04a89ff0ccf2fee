//! PDOs: mapping, reception, transmission by event, timer and SYNC (guide section 6).
//!
//! Specification: nothing moves by PDO outside operational; a PDO of another length than its mapping is ignored.

use super::ZlacDrive;
use super::config::ZlacDriveConfig;
use super::memory::{Memory, row};
use super::network::NodeState;
use super::objects::Address;
use super::sdo_server::STATE;

/// Object cannot be mapped; mapping too long; mapping written while it is in force.
const NOT_MAPPABLE: u32 = 0x0604_0041;
const PDO_LENGTH: u32 = 0x0604_0042;
const ACCESS: u32 = 0x0601_0000;

/// Shortest time between two looks at values that are sent when they change.
const LOOK_NS: u64 = 1_000_000;

/// One PDO to the master.
#[derive(Debug, Clone, Default)]
struct Transmit {
    /// When its timer runs out, or its values are looked at again.
    due_ns: Option<u64>,
    sent: Option<Vec<u8>>,
    syncs: u32,
}

#[derive(Debug, Clone, Default)]
pub(super) struct ProcessData {
    transmit: [Transmit; 4],
}

impl ProcessData {
    pub(super) fn next_event_ns(&self) -> Option<u64> {
        self.transmit.iter().filter_map(|pdo| pdo.due_ns).min()
    }

    /// Timers start with operational and end with it.
    pub(super) fn restart(
        &mut self,
        now_ns: u64,
        operational: bool,
        memory: &Memory,
        config: &ZlacDriveConfig,
    ) {
        for (number, pdo) in (0_u16..).zip(&mut self.transmit) {
            *pdo = Transmit::default();
            if operational {
                pdo.due_ns = period_ns(number, memory, config).map(|period_ns| now_ns + period_ns);
            }
        }
    }
}

/// Time between two transmissions, or looks; `None` for a PDO that is off or waits for SYNC.
fn period_ns(number: u16, memory: &Memory, config: &ZlacDriveConfig) -> Option<u64> {
    let of = |index: u16, sub: u8| memory.get((index + number, sub));
    let inhibit_ns = u64::from(of(0x1800, 3)) * config.inhibit_time_unit_us * 1_000;
    let timer_ns = u64::from(of(0x1800, 5)) * config.event_timer_unit_us * 1_000;
    if of(0x1A00, 0) == 0 {
        return None;
    }
    match of(0x1800, 2) {
        254 => Some(inhibit_ns.max(LOOK_NS)),
        255 => (timer_ns != 0).then_some(timer_ns),
        _ => None,
    }
}

/// Whether an object describes a mapping.
pub(super) fn is_mapping((index, _): Address) -> bool {
    matches!(index, 0x1600..=0x1603 | 0x1A00..=0x1A03)
}

/// The mapped objects of a mapping object, with their bytes.
fn mapped(memory: &Memory, index: u16, count: u32) -> Vec<(Address, u8)> {
    (1..=count as u8)
        .map(|sub| {
            let [bits, sub_index, low, high] = memory.get((index, sub)).to_le_bytes();
            ((u16::from_le_bytes([low, high]), sub_index), bits / 8)
        })
        .collect()
}

impl ZlacDrive {
    /// Whether a mapping may be written now, and makes sense.
    pub(super) fn check_mapping(&self, address: Address, value: u32) -> Result<(), u32> {
        let (index, sub) = address;
        if !is_mapping(address) {
            return Ok(());
        }
        if self.network.state() == NodeState::Operational {
            return Err(STATE);
        }
        if sub != 0 {
            return if self.memory.get((index, 0)) == 0 {
                Ok(())
            } else {
                Err(ACCESS)
            };
        }
        let objects = if value <= 4 {
            mapped(&self.memory, index, value)
        } else {
            return Err(PDO_LENGTH);
        };
        let fits = |(address, bytes): &(Address, u8)| {
            row(*address).is_some_and(|entry| entry.mappable && entry.data_type.bytes() == *bytes)
        };
        if !objects.iter().all(fits) {
            return Err(NOT_MAPPABLE);
        }
        let length: u32 = objects.iter().map(|(_, bytes)| u32::from(*bytes)).sum();
        if length > 8 { Err(PDO_LENGTH) } else { Ok(()) }
    }

    pub(super) fn on_rpdo(&mut self, now_ns: u64, number: usize, data: &[u8]) {
        if self.network.state() != NodeState::Operational {
            return;
        }
        let index = 0x1600 + number as u16;
        let objects = mapped(&self.memory, index, self.memory.get((index, 0)));
        let length: usize = objects.iter().map(|(_, bytes)| usize::from(*bytes)).sum();
        if length == 0 || length != data.len() {
            return;
        }
        self.books.rpdos += 1;
        let mut rest = data;
        for (address, bytes) in objects {
            let (value, behind) = rest.split_at(usize::from(bytes));
            rest = behind;
            let mut word = [0; 4];
            word[..value.len()].copy_from_slice(value);
            if let Some(entry) = row(address) {
                self.apply(now_ns, entry, u32::from_le_bytes(word));
            }
        }
    }

    pub(super) fn on_sync(&mut self, now_ns: u64) {
        if self.network.state() != NodeState::Operational {
            return;
        }
        for number in 0..4 {
            let kind = self.memory.get((0x1800 + number as u16, 2));
            let syncs = &mut self.process_data.transmit[number].syncs;
            *syncs += 1;
            if (1..=240).contains(&kind) && *syncs >= kind {
                *syncs = 0;
                self.send_tpdo(now_ns, number, false);
            } else if kind == 0 {
                self.send_tpdo(now_ns, number, true);
            }
        }
    }

    pub(super) fn run_process_data(&mut self, now_ns: u64) {
        for number in 0..4 {
            if self.process_data.transmit[number]
                .due_ns
                .is_none_or(|due_ns| due_ns > now_ns)
            {
                continue;
            }
            let period_ns = period_ns(number as u16, &self.memory, &self.config);
            self.process_data.transmit[number].due_ns =
                period_ns.map(|period_ns| now_ns + period_ns);
            let on_change = self.memory.get((0x1800 + number as u16, 2)) == 254;
            self.send_tpdo(now_ns, number, on_change);
        }
    }

    fn send_tpdo(&mut self, now_ns: u64, number: usize, on_change: bool) {
        let index = 0x1A00 + number as u16;
        let objects = mapped(&self.memory, index, self.memory.get((index, 0)));
        let mut data = Vec::new();
        for (address, bytes) in objects {
            let value = self.read(now_ns, address).to_le_bytes();
            data.extend_from_slice(&value[..usize::from(bytes)]);
        }
        let last = &mut self.process_data.transmit[number].sent;
        if data.is_empty() || on_change && last.as_ref() == Some(&data) {
            return;
        }
        *last = Some(data.clone());
        self.books.tpdos += 1;
        let id = 0x180 + 0x100 * number as u16 + self.node();
        self.outbox.at_once(now_ns, (id, data));
    }
}
