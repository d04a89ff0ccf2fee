//! How a simulated drive is set up: everything that the documents leave open is a field here.

use dyn_can::{
    ConfigByte, Dialect, DriveId, GearNumber, IntegrationGain, MainGain, MaxAcceleration, MaxSpeed,
    OnPosRange, ParamGroup1, ParamGroup2, ParamGroup3, RangeError, Revision, SpeedGain,
    StoredDriveId, TorqueFilter,
};

use super::gains::ServoLoop;
use super::mechanics::Mechanics;
use super::settings::{
    CoastDeceleration, PositionAfterPower, PositionOverflow, RangeErrors, Reaction, ReadBackUnit,
    ResponseDelay, ServoDynamics,
};

/// 150 ms from power-on to the first command (DYN2 manual A1.8 section 3.2; D58).
pub const POWER_ON_DELAY_NS: u64 = 150_000_000;

/// Position error of the lost phase alarm in motor steps of 16384 a turn: 180 degrees (1.6A section 6, #9; D47).
pub const LOST_PHASE_STEPS: u32 = 8_192;

/// A number checked while compiling: the panic is a compiler error and cannot happen at run time.
macro_rules! checked {
    ($type:ty, $value:literal) => {
        const {
            match <$type>::new($value) {
                Ok(value) => value,
                Err(_) => panic!("the literal is out of range"),
            }
        }
    };
}

/// A simulated drive's EEPROM, timing, mechanics and reading of the documents.
///
/// Start from [`Self::new`] or [`Self::fresh`] and change fields.
#[derive(Debug, Clone, PartialEq)]
pub struct DynDriveConfig {
    /// Stored drive id; [`StoredDriveId::NONE`] on a fresh drive, which listens and answers on identifier 0 (D2).
    pub id: StoredDriveId,
    /// Revision and reading of the documents. What may go to identifier 0 is not taken from here: a drive obeys every broadcast.
    pub dialect: Dialect,
    /// From the end of a request to the moment the reply waits for the bus. No document has a figure (D65).
    pub response_delay: ResponseDelay,
    /// Seed of the response delays.
    pub seed: u64,
    /// From power-on, which is at 0 ns and after each power cycle, until the drive hears and acts. 0 is allowed.
    pub power_on_delay_ns: u64,
    /// Unit of the position that General_Read reports.
    pub read_back: ReadBackUnit,
    /// What General_Read reports beyond 28 bit.
    pub overflow: PositionOverflow,
    /// Gains and torque filter; they change the motion where [`Self::servo_loop`] says so.
    pub group1: ParamGroup1,
    /// Max speed and max acceleration.
    pub group2: ParamGroup2,
    /// On-position range, gear number and line number.
    pub group3: ParamGroup3,
    /// Configuration byte.
    pub config_byte: ConfigByte,
    /// How fast the motor can follow.
    pub dynamics: ServoDynamics,
    /// How the motor answers to its reference.
    pub servo_loop: ServoLoop,
    /// What the shaft meets on its way.
    pub mechanics: Mechanics,
    /// Deceleration of a free motor, by friction.
    pub coast: CoastDeceleration,
    /// Position that the drive reports at 0 ns, in command counts.
    pub start_position_counts: i64,
    /// Whether the servo is on after power-on (DYN2 manual A1.8 section 3.2: it is). Bit 5 of the configuration switches it off too.
    pub enabled_after_power_on: bool,
    /// Following error in motor steps (16384 a turn) beyond which the lost phase alarm comes; `None` for never.
    pub lost_phase_steps: Option<u32>,
    /// Position after a power cycle in relative mode.
    pub position_after_power: PositionAfterPower,
    /// Data byte of the reply to Drive_Reset, which no document explains; `None` for silence (D35).
    pub reset_reply: Option<u8>,
    /// Reaction where the documents promise none: wrong length, unknown magic byte, function of the other revision (D39).
    pub unspecified: Reaction,
    /// Which numbers out of range raise a data error (D66).
    pub range_errors: RangeErrors,
}

impl DynDriveConfig {
    /// A drive as it leaves commissioning: revision 1.6A, factory configuration (position servo, RS232 mode), servo on after power-on,
    /// replies after 100 us, read-back in command counts.
    pub const fn new(id: DriveId) -> Self {
        Self {
            // A drive id is 1 ..= 63 and always fits, so that the second arm is never taken.
            id: match StoredDriveId::new(id.get() as i32) {
                Ok(id) => id,
                Err(_) => StoredDriveId::NONE,
            },
            ..Self::fresh()
        }
    }

    /// The same drive before it was given an id.
    pub const fn fresh() -> Self {
        Self {
            id: StoredDriveId::NONE,
            dialect: Dialect::V1_6A,
            response_delay: ResponseDelay::fixed(100_000),
            seed: 0,
            power_on_delay_ns: POWER_ON_DELAY_NS,
            read_back: ReadBackUnit::CommandCounts,
            overflow: PositionOverflow::Wrap28Bit,
            group1: ParamGroup1 {
                main_gain: checked!(MainGain, 20),
                speed_gain: checked!(SpeedGain, 20),
                integration_gain: checked!(IntegrationGain, 10),
                torque_filter: checked!(TorqueFilter, 127),
            },
            group2: ParamGroup2 {
                max_speed: checked!(MaxSpeed, 60),
                max_acceleration: checked!(MaxAcceleration, 60),
            },
            group3: ParamGroup3 {
                on_pos_range: checked!(OnPosRange, 20),
                gear_number: checked!(GearNumber, 4096),
                line_number: None,
            },
            config_byte: ConfigByte::from_byte(0),
            dynamics: ServoDynamics::FromParameters,
            servo_loop: ServoLoop::Smooth,
            mechanics: Mechanics::FREE,
            coast: CoastDeceleration::DEFAULT,
            start_position_counts: 0,
            enabled_after_power_on: true,
            lost_phase_steps: Some(LOST_PHASE_STEPS),
            position_after_power: PositionAfterPower::Zero,
            reset_reply: Some(0),
            unspecified: Reaction::Ignore,
            range_errors: RangeErrors::EveryValue,
        }
    }

    /// The same drive with the recommended reading of another revision.
    #[must_use]
    pub const fn with_revision(mut self, revision: Revision) -> Self {
        self.dialect = Dialect::of(revision);
        self
    }

    /// A drive with id `number`, otherwise [`Self::new`].
    ///
    /// # Errors
    /// [`RangeError`] outside 1 ..= 63.
    pub fn numbered(number: i32) -> Result<Self, RangeError> {
        DriveId::new(number).map(Self::new)
    }
}
