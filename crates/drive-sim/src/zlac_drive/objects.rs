//! Addresses of the objects that do something, as the guide prints them.

/// Index and sub-index.
pub(super) type Address = (u16, u8);

pub(super) const ERROR_REGISTER: Address = (0x1001, 0);
pub(super) const HEARTBEAT: Address = (0x1017, 0);
pub(super) const OFFLINE_TIME: Address = (0x2000, 0);
pub(super) const ROTATION: Address = (0x2001, 0);
pub(super) const INPUT_LEVELS: Address = (0x2003, 0);
pub(super) const OUTPUT_LEVELS: Address = (0x2004, 0);
pub(super) const CLEAR_FEEDBACK: Address = (0x2005, 0);
pub(super) const CLEAR_ABSOLUTE: Address = (0x2006, 0);
pub(super) const STORE: Address = (0x2009, 0);
pub(super) const MAX_SPEED: Address = (0x200A, 0);
pub(super) const ENCODER_LINES: Address = (0x200B, 0);
pub(super) const POLE_PAIRS: Address = (0x200C, 0);
pub(super) const NODE_NUMBER: Address = (0x200D, 0);
pub(super) const BIT_RATE: Address = (0x200E, 0);
pub(super) const EEPROM_UPDATE: Address = (0x2010, 0);
pub(super) const TEMPERATURE_LIMIT: Address = (0x2013, 1);
pub(super) const MAX_CURRENT: Address = (0x2015, 0);
pub(super) const SPEED_KP: Address = (0x201D, 0);
pub(super) const SPEED_KI: Address = (0x201E, 0);
pub(super) const POSITION_KP: Address = (0x2020, 0);
pub(super) const SOFTWARE_VERSION: Address = (0x2025, 0);
pub(super) const MOTOR_TEMPERATURE: Address = (0x2026, 1);
pub(super) const DRIVER_TEMPERATURE: Address = (0x2026, 2);
pub(super) const MOTOR_STATUS: Address = (0x2027, 0);
pub(super) const HALL_INPUTS: Address = (0x2028, 0);
pub(super) const BUS_VOLTAGE: Address = (0x2029, 0);
pub(super) const ALARM_PWM: Address = (0x202F, 1);
pub(super) const EMERGENCY_RELEASES: Address = (0x202F, 3);
pub(super) const PARKING: Address = (0x202F, 4);
pub(super) const SPEED_RESOLUTION: Address = (0x202F, 5);
pub(super) const INPUT_INVERSION: Address = (0x2030, 1);
pub(super) const INPUT_X0: Address = (0x2030, 2);
pub(super) const INPUT_X1: Address = (0x2030, 3);
pub(super) const OUTPUT_INVERSION: Address = (0x2030, 0x0C);
pub(super) const OUTPUT_Y0: Address = (0x2030, 0x0D);
pub(super) const HOLDING_BRAKE: Address = (0x2030, 0x0E);
pub(super) const OUTPUT_Y1: Address = (0x2030, 0x0F);
pub(super) const FAULT_CODE: Address = (0x603F, 0);
pub(super) const CONTROL_WORD: Address = (0x6040, 0);
pub(super) const STATUS_WORD: Address = (0x6041, 0);
pub(super) const QUICK_STOP_OPTION: Address = (0x605A, 0);
pub(super) const SHUTDOWN_OPTION: Address = (0x605B, 0);
pub(super) const DISABLE_OPTION: Address = (0x605C, 0);
pub(super) const HALT_OPTION: Address = (0x605D, 0);
pub(super) const MODE: Address = (0x6060, 0);
pub(super) const MODE_DISPLAY: Address = (0x6061, 0);
pub(super) const ACTUAL_POSITION: Address = (0x6064, 0);
pub(super) const ACTUAL_SPEED: Address = (0x606C, 0);
pub(super) const TARGET_TORQUE: Address = (0x6071, 0);
pub(super) const TORQUE_DEMAND: Address = (0x6074, 0);
pub(super) const ACTUAL_TORQUE: Address = (0x6077, 0);
pub(super) const TARGET_POSITION: Address = (0x607A, 0);
pub(super) const PROFILE_SPEED: Address = (0x6081, 0);
pub(super) const START_STOP_SPEED: Address = (0x6082, 0);
pub(super) const ACCELERATION_TIME: Address = (0x6083, 0);
pub(super) const DECELERATION_TIME: Address = (0x6084, 0);
pub(super) const EMERGENCY_TIME: Address = (0x6085, 0);
pub(super) const TORQUE_SLOPE: Address = (0x6087, 0);
pub(super) const TARGET_SPEED: Address = (0x60FF, 0);

/// Function of an input that stops the motor.
pub(super) const INPUT_EMERGENCY_STOP: u32 = 9;
