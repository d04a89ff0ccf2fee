//! How a simulated hub-motor drive is set up: everything that the guide leaves open is a field here.

use can_frame::BitRate;
use zlac8030l::{NodeId, ObjectAddress};

use super::mechanics::ZlacMechanics;
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
    /// 6074h counts 0.1 A and 6077h mA, as their ranges say, and not the other way round, as their texts say (Z25).
    pub torque_units_by_range: bool,
}

/// What a drive measures besides its wheel; [`ZlacFaults`](super::ZlacFaults) changes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ZlacSurroundings {
    /// 2026h:01 in 0.1 degC (Z6). At the threshold 2013h:01 the drive trips.
    pub motor_decidegrees: i16,
    /// 2026h:02 in 0.1 degC.
    pub driver_decidegrees: i16,
    /// 2029h in 0.01 V. No document lists the limits at which a drive trips, so none is simulated.
    pub bus_centivolts: u16,
}

impl ZlacSurroundings {
    /// A drive on 48 V in a room of 25 degC.
    pub const DEFAULT: Self = Self {
        motor_decidegrees: 250,
        driver_decidegrees: 300,
        bus_centivolts: 4_800,
    };
}

/// A simulated drive's EEPROM, timing, mechanics and reading of the guide. Start from [`Self::new`] and change fields.
#[derive(Debug, Clone, PartialEq)]
pub struct ZlacDriveConfig {
    /// Node number. From 4 on it is what 200Dh stores; a lower one comes from the DIP switch, and 200Dh does not change it.
    pub node: NodeId,
    /// Bit rate of the bus. A drive that stores another one (200Eh) sends and hears nothing from its start on; a real one also disturbs the
    /// others. `None`: whatever is stored is that of the bus.
    pub bus_bit_rate: Option<BitRate>,
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
    /// Deceleration of a wheel whose phases are short-circuited after an alarm (202Fh:01), in r/min a second.
    pub shorted_deceleration_rpm_s: f64,
    /// Deceleration by the holding brake, in r/min a second.
    pub brake_deceleration_rpm_s: f64,
    /// What stands beside the shaft, and how its loops answer.
    pub mechanics: ZlacMechanics,
    /// Temperatures and voltage at first.
    pub surroundings: ZlacSurroundings,
    /// Deviations.
    pub quirks: ZlacQuirks,
}

impl ZlacDriveConfig {
    /// A drive as it leaves the factory, with another node number: replies after 200 us, boot-up after 100 ms, quick stop when the
    /// master falls silent.
    pub const fn new(node: NodeId) -> Self {
        Self {
            node,
            bus_bit_rate: None,
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
            shorted_deceleration_rpm_s: 1_000.0,
            brake_deceleration_rpm_s: 4_000.0,
            mechanics: ZlacMechanics::FREE,
            surroundings: ZlacSurroundings::DEFAULT,
            quirks: ZlacQuirks {
                profile_speed_confirmed_as_sub_1: false,
                emcy_on_sync_identifier: false,
                status_word_without_cia402_bits: false,
                torque_mode_is_6: false,
                replies_without_size: false,
                torque_units_by_range: false,
            },
        }
    }
}
