//! What a drive stores: EEPROM, working copies, and the wear of the EEPROM.
//!
//! Specification: Set_Param_Group1, Set_Param_Group3, Set_Drive_Config, Assign_Drive_ID and Set_Origin write the EEPROM; Set_Param_Group2 does so
//! for its first ten writes after power-on and changes RAM only afterwards (1.6A section 6, #17; DYN2 manual A1.8 section 7). A
//! working copy is gone with the power.

use dyn_can::{
    ConfigByte, DriveConfig, ParamGroup1, ParamGroup2, ParamGroup3, SetParamGroup1, SetParamGroup2,
    SetParamGroup3, StoredDriveId,
};

use super::config::DynDriveConfig;

/// Writes of group 2 after power-on that go to the EEPROM.
pub const STORED_GROUP2_WRITES: u8 = 10;

/// Requests that wrote the EEPROM, by kind. A group that keeps every value writes nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EepromWrites {
    /// By Set_Origin.
    pub origin: u64,
    /// By Assign_Drive_ID.
    pub drive_id: u64,
    /// By Set_Drive_Config.
    pub config: u64,
    /// By Set_Param_Group1.
    pub group1: u64,
    /// By Set_Param_Group2.
    pub group2: u64,
    /// By Set_Param_Group3.
    pub group3: u64,
}

impl EepromWrites {
    /// All of them.
    pub const fn total(&self) -> u64 {
        self.origin + self.drive_id + self.config + self.group1 + self.group2 + self.group3
    }
}

/// One copy of everything that is both stored and in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Bank {
    pub(super) id: StoredDriveId,
    pub(super) config: ConfigByte,
    pub(super) group1: ParamGroup1,
    pub(super) group2: ParamGroup2,
    pub(super) group3: ParamGroup3,
}

/// Working copy, EEPROM and registers that start empty at power-on.
#[derive(Debug, Clone)]
pub(super) struct Registers {
    pub(super) ram: Bank,
    eeprom: Bank,
    pub(super) writes: EepromWrites,
    group2_writes_left: u8,
    pub(super) diagnostic_counter: u8,
    /// New id of revision 1.2A and the instant from which it counts.
    pub(super) coming_id: Option<(u64, StoredDriveId)>,
    /// Targets loaded for Sync_Trigger.
    pub(super) loaded_absolute: Option<i32>,
    pub(super) loaded_relative: Option<i32>,
}

impl Registers {
    pub(super) fn new(config: &DynDriveConfig) -> Self {
        let bank = Bank {
            id: config.id,
            config: config.config_byte,
            group1: config.group1,
            group2: config.group2,
            group3: config.group3,
        };
        Self {
            ram: bank,
            eeprom: bank,
            writes: EepromWrites::default(),
            group2_writes_left: STORED_GROUP2_WRITES,
            diagnostic_counter: 0,
            coming_id: None,
            loaded_absolute: None,
            loaded_relative: None,
        }
    }

    /// Power-on: working copies come from the EEPROM, the rest is empty.
    pub(super) fn power_on(&mut self) {
        self.ram = self.eeprom;
        self.group2_writes_left = STORED_GROUP2_WRITES;
        self.diagnostic_counter = 0;
        self.coming_id = None;
        self.loaded_absolute = None;
        self.loaded_relative = None;
    }

    pub(super) fn store_id(&mut self, id: StoredDriveId) {
        self.eeprom.id = id;
        self.writes.drive_id += 1;
    }

    pub(super) fn store_config(&mut self, config: DriveConfig) {
        self.ram.config = ConfigByte::from_byte(config.to_byte());
        self.eeprom.config = self.ram.config;
        self.writes.config += 1;
    }

    pub(super) fn store_group1(&mut self, set: SetParamGroup1) {
        if set == SetParamGroup1::default() {
            return;
        }
        let group = &mut self.ram.group1;
        group.main_gain = set.main_gain.unwrap_or(group.main_gain);
        group.speed_gain = set.speed_gain.unwrap_or(group.speed_gain);
        group.integration_gain = set.integration_gain.unwrap_or(group.integration_gain);
        group.torque_filter = set.torque_filter.unwrap_or(group.torque_filter);
        self.eeprom.group1 = *group;
        self.writes.group1 += 1;
    }

    pub(super) fn store_group2(&mut self, set: SetParamGroup2) {
        if set == SetParamGroup2::default() {
            return;
        }
        let group = &mut self.ram.group2;
        group.max_speed = set.max_speed.unwrap_or(group.max_speed);
        group.max_acceleration = set.max_acceleration.unwrap_or(group.max_acceleration);
        if self.group2_writes_left > 0 {
            self.group2_writes_left -= 1;
            self.eeprom.group2 = *group;
            self.writes.group2 += 1;
        }
    }

    pub(super) fn store_group3(&mut self, set: SetParamGroup3) {
        if set == SetParamGroup3::default() {
            return;
        }
        let group = &mut self.ram.group3;
        group.on_pos_range = set.on_pos_range.unwrap_or(group.on_pos_range);
        group.gear_number = set.gear_number.unwrap_or(group.gear_number);
        group.line_number = set.line_number.or(group.line_number);
        self.eeprom.group3 = *group;
        self.writes.group3 += 1;
    }

    /// The value of the next read; each read counts.
    pub(super) fn count_diagnostic(&mut self) -> u8 {
        let value = self.diagnostic_counter;
        self.diagnostic_counter = value.wrapping_add(1);
        value
    }

    /// Puts a new id into use when its time has come.
    pub(super) fn settle_id(&mut self, now_ns: u64) {
        if let Some((at_ns, id)) = self.coming_id
            && at_ns <= now_ns
        {
            self.ram.id = id;
            self.coming_id = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::MaxSpeed;

    fn speed(value: i32) -> SetParamGroup2 {
        SetParamGroup2 {
            max_speed: MaxSpeed::new(value).ok(),
            max_acceleration: None,
        }
    }

    #[test]
    fn eleventh_write_of_group_2_is_lost_with_the_power() {
        let mut registers = Registers::new(&DynDriveConfig::fresh());
        (1..=11).for_each(|value| registers.store_group2(speed(value)));
        assert_eq!(registers.writes.group2, 10);
        assert_eq!(registers.ram.group2.max_speed.get(), 11);
        registers.power_on();
        assert_eq!(registers.ram.group2.max_speed.get(), 10);
        registers.store_group2(speed(99));
        assert_eq!(registers.writes.group2, 11);
    }

    #[test]
    fn keeping_every_value_writes_nothing() {
        let mut registers = Registers::new(&DynDriveConfig::fresh());
        registers.store_group1(SetParamGroup1::default());
        registers.store_group2(SetParamGroup2::default());
        registers.store_group3(SetParamGroup3::default());
        assert_eq!(registers.writes.total(), 0);
    }

    #[test]
    fn diagnostic_counter_follows_255_with_0() {
        let mut registers = Registers::new(&DynDriveConfig::fresh());
        let read: Vec<u8> = (0..257).map(|_| registers.count_diagnostic()).collect();
        assert_eq!((read[0], read[1], read[255], read[256]), (0, 1, 255, 0));
    }
}
