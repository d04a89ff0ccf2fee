//! The objects that a master uses, with their types. The whole dictionary is [`crate::dictionary`].

use crate::typed_object::Object;

macro_rules! objects {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $index:literal, $sub:literal;)*) => {
        $($(#[$doc])* pub const $name: Object<$type> = Object::new($index, $sub);)*

        #[cfg(test)]
        const ALL: &[(crate::ObjectAddress, crate::DataType)] = &[
            $(($name.address(), <$type as crate::ObjectValue>::DATA_TYPE),)*
        ];
    };
}

objects! {
    /// 40192h: CiA 402, servo drive.
    DEVICE_TYPE: u32 = 0x1000, 0;
    /// Any bit set: an error.
    ERROR_REGISTER: u8 = 0x1001, 0;
    /// Software version in CiA 301; the guide calls it hardware version and prints U16 (Z22).
    DEVICE_VERSION: u16 = 0x100A, 0;
    /// ms between heartbeats, 0 for none.
    PRODUCER_HEARTBEAT_MS: u16 = 0x1017, 0;
    /// 100h.
    VENDOR_ID: u32 = 0x1018, 1;
    /// 1.
    PRODUCT_CODE: u32 = 0x1018, 2;
    /// ms without communication; what happens then is not stated (Z41).
    OFFLINE_TIME_MS: u16 = 0x2000, 0;
    /// Sense of rotation, seen from the shaft: 0 clockwise, 1 counter-clockwise.
    ROTATION: u16 = 0x2001, 0;
    /// 1 clears the position that is read back.
    CLEAR_FEEDBACK_POSITION: u16 = 0x2005, 0;
    /// 1 clears the position of absolute moves.
    CLEAR_ABSOLUTE_POSITION: u16 = 0x2006, 0;
    /// 1 restores the factory settings, 2 saves everything to the EEPROM.
    STORE: u16 = 0x2009, 0;
    /// Largest speed of the motor in r/min; the ramps are times to it.
    MAX_SPEED_RPM: u16 = 0x200A, 0;
    /// Lines of the encoder; four counts each.
    ENCODER_LINES: u16 = 0x200B, 0;
    /// Node number 4 to 127, where the DIP switch leaves it open; the guide does not say when it counts.
    CAN_NODE: u16 = 0x200D, 0;
    /// Code of the bit rate: the place in [`crate::BIT_RATES`]; the guide does not say when it counts.
    CAN_BIT_RATE: u16 = 0x200E, 0;
    /// 0: each write of an RW/S object wears the EEPROM; 1: it does not (Z32).
    EEPROM_UPDATE: u16 = 0x2010, 0;
    /// Software version.
    SOFTWARE_VERSION: u16 = 0x2025, 0;
    /// 0.1 degC, signed (Z6, Z7).
    MOTOR_TEMPERATURE: i16 = 0x2026, 1;
    /// 0.1 degC, signed (Z6, Z7).
    DRIVER_TEMPERATURE: i16 = 0x2026, 2;
    /// 0.01 V.
    BUS_VOLTAGE: u16 = 0x2029, 0;
    /// 1: the phases are shorted on an alarm.
    ALARM_PWM: u16 = 0x202F, 1;
    /// What an emergency stop input does with the shaft: 0 locks it, 1 releases it (Z8, Z31).
    EMERGENCY_INPUT_RELEASES: u16 = 0x202F, 3;
    /// 1: parking, at most 3 A (Z8).
    PARKING: u16 = 0x202F, 4;
    /// n: the target speed counts 1/n r/min; after saving and a restart (Z8, Z9, Z34).
    SPEED_RESOLUTION: u16 = 0x202F, 5;
    /// Function of input X0: 0 none, 9 emergency stop.
    INPUT_X0: u16 = 0x2030, 2;
    /// Function of input X1: 0 none, 9 emergency stop.
    INPUT_X1: u16 = 0x2030, 3;
    /// Holding brake B0: 0 open, 1 closed.
    HOLDING_BRAKE: u16 = 0x2030, 0x0E;
    /// Fault bits, see [`crate::FaultCode`].
    FAULT_CODE: u16 = 0x603F, 0;
    /// See [`crate::ControlWord`].
    CONTROL_WORD: u16 = 0x6040, 0;
    /// See [`crate::StatusWord`].
    STATUS_WORD: u16 = 0x6041, 0;
    /// 5 normal stop, 6 fast stop, 7 emergency stop; energised in all three.
    QUICK_STOP_OPTION: i16 = 0x605A, 0;
    /// 0 or 1; the guide prints "normal stop" for its default, 1 (Z44).
    SHUTDOWN_OPTION: i16 = 0x605B, 0;
    /// 0 or 1; the guide prints "normal stop" for its default, 1 (Z44).
    DISABLE_OPTION: i16 = 0x605C, 0;
    /// 0, 2 or 3; its default, 1, is not in the list of the guide (Z44).
    HALT_OPTION: i16 = 0x605D, 0;
    /// See [`crate::Mode`].
    MODE: i8 = 0x6060, 0;
    /// The mode in use.
    MODE_DISPLAY: i8 = 0x6061, 0;
    /// Counts; 4096 a turn with the 1024 lines of 200Bh.
    ACTUAL_POSITION: i32 = 0x6064, 0;
    /// 0.1 r/min.
    ACTUAL_SPEED: i32 = 0x606C, 0;
    /// mA (Z3).
    TARGET_TORQUE: i16 = 0x6071, 0;
    /// 0.1 A by the text, mA by the printed range (Z25).
    ACTUAL_TORQUE: i16 = 0x6077, 0;
    /// Counts, see [`crate::MoveKind`] for its limits.
    TARGET_POSITION: i32 = 0x607A, 0;
    /// r/min, 1 ..= 1000.
    PROFILE_SPEED: u32 = 0x6081, 0;
    /// ms, a time and no acceleration (Z38).
    ACCELERATION_TIME_MS: u32 = 0x6083, 0;
    /// ms, a time and no deceleration (Z38).
    DECELERATION_TIME_MS: u32 = 0x6084, 0;
    /// ms, of an emergency stop.
    EMERGENCY_DECELERATION_TIME_MS: u32 = 0x6085, 0;
    /// mA/s.
    TORQUE_SLOPE: u32 = 0x6087, 0;
    /// r/min, or 1/n r/min by [`SPEED_RESOLUTION`].
    TARGET_SPEED: i32 = 0x60FF, 0;
}

/// The value of [`INPUT_X0`] and [`INPUT_X1`] for an emergency stop input.
pub const INPUT_EMERGENCY_STOP: u16 = 9;

/// The value of [`STORE`] that saves every parameter to the EEPROM.
pub const STORE_SAVE_ALL: u16 = 2;

/// Value of [`STORE`] that restores the factory settings.
pub const STORE_FACTORY_SETTINGS: u16 = 1;

/// The value of [`EEPROM_UPDATE`] with which writes do not wear the EEPROM.
pub const EEPROM_UPDATE_OFF: u16 = 1;

#[cfg(test)]
mod tests {
    #[test]
    fn types_agree_with_the_dictionary() {
        for (address, data_type) in super::ALL {
            let entry = crate::dictionary::find(*address).unwrap();
            assert_eq!(entry.data_type, *data_type, "{address}");
        }
    }
}
