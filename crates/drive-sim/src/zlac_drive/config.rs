//! How a simulated hub-motor drive is set up: everything that the guide leaves open is a field here.

use zlac8030l::{NodeId, ObjectAddress};

use crate::dyn_drive::ResponseDelay;

/// What a drive does when it has heard nothing for the time in 2000h; the guide does not say (Z41).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfflineReaction {
    /// Nothing.
    Nothing,
    /// As by control word 2.
    QuickStop,
    /// As by control word 0: the wheel coasts.
    PowerOff,
}

/// Deviations from CiA 301 and CiA 402 that the guide prints or allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ZlacQuirks {
    /// A write of 6081h:00 is confirmed with sub-index 01 (Z1).
    pub profile_speed_confirmed_as_sub_1: bool,
    /// Emergency messages go out on 080h (Z21).
    pub emcy_on_sync_identifier: bool,
    /// The status word has bits 0 to 3 alone, as described, and not the fault and switch-on-disabled bits of CiA 402 (Z37).
    pub status_word_without_cia402_bits: bool,
    /// Torque mode is 6 and not 4 (Z4).
    pub torque_mode_is_6: bool,
    /// Replies to reads have specifier 42h, which leaves their size open.
    pub replies_without_size: bool,
}

/// A simulated drive's EEPROM, timing, mechanics and reading of the guide. Start from [`Self::new`] and change fields.
#[derive(Debug, Clone, PartialEq)]
pub struct ZlacDriveConfig {
    /// Node number.
    pub node: NodeId,
    /// From the end of an SDO request to the moment the reply waits for the bus. No document has a figure.
    pub response_delay: ResponseDelay,
    /// Seed of the response delays.
    pub seed: u64,
    /// From power-on, which is at 0 ns and after each power cycle, to the boot-up message.
    pub boot_delay_ns: u64,
    /// 2025h; no document lists one.
    pub software_version: u16,
    /// What stands in the EEPROM in place of the defaults.
    pub stored: Vec<(ObjectAddress, i64)>,
    /// Unit of event timers in microseconds: 500 in the guide, 1000 in CiA 301 (Z11).
    pub event_timer_unit_us: u64,
    /// Unit of inhibit times in microseconds: 500 in the guide, 100 in CiA 301 (Z11).
    pub inhibit_time_unit_us: u64,
    /// What happens after the offline time.
    pub offline_reaction: OfflineReaction,
    /// Whether control word 0 brakes first where 605Ch says so. The guide calls it "Stop"; in CiA 402 the shaft is free at once (Z43).
    pub brakes_before_power_off: bool,
    /// The most that the motor can do, in r/min a second.
    pub motor_acceleration_rpm_s: f64,
    /// Deceleration of a free wheel, in r/min a second.
    pub coast_deceleration_rpm_s: f64,
    /// Deviations.
    pub quirks: ZlacQuirks,
}

impl ZlacDriveConfig {
    /// A drive as it leaves the factory, with another node number: replies after 200 us, boot-up after 100 ms, quick stop when the
    /// master falls silent.
    pub const fn new(node: NodeId) -> Self {
        Self {
            node,
            response_delay: ResponseDelay::fixed(200_000),
            seed: 0,
            boot_delay_ns: 100_000_000,
            software_version: 0x0021,
            stored: Vec::new(),
            event_timer_unit_us: 500,
            inhibit_time_unit_us: 500,
            offline_reaction: OfflineReaction::QuickStop,
            brakes_before_power_off: false,
            motor_acceleration_rpm_s: 5_000.0,
            coast_deceleration_rpm_s: 200.0,
            quirks: ZlacQuirks {
                profile_speed_confirmed_as_sub_1: false,
                emcy_on_sync_identifier: false,
                status_word_without_cia402_bits: false,
                torque_mode_is_6: false,
                replies_without_size: false,
            },
        }
    }
}
