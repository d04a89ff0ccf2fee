//! What a user of this firmware decides: drives, limits, bit rate and the built-in motion. Pins and clocks are in `board`.

use can_motion::plan::{BitRate, BusPlan};
use can_motion::{AxisConfig, Dyn, GroupId, Limits, MasterConfig, MotorLimits, Travel};
use dyn_can::units::command_counts_per_turn;
use dyn_can::{DriveId, GearNumber};
use trajectory::curve::{Keyframe, KeyframeMotion};

/// The family of the drives. `firmware-tests/configs/hub_motors.rs` is a configuration of the other one, ZLAC8030L hub motors.
pub(crate) type Drives = Dyn;

/// Homing before the motion: none. `firmware-tests/configs/homing.rs` is a configuration with one.
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Nothing;

/// Number of axes.
pub(crate) const AXES: usize = 2;
/// All axes move and stop together.
pub(crate) const GROUP: GroupId = GroupId(0);

/// Cycle, requests per cycle, waiting times and bit rate: 1 kHz, one request, 1 Mbit/s.
///
/// The bit rate is the one that the drives are set to: they know 10, 20, 50, 125, 250, 500, 800 and 1000 kbit/s (CAN specification 1.6A,
/// section 1). One that the board's clock cannot make exactly stops the build.
pub(crate) const MASTER: MasterConfig = MasterConfig::DEFAULT;

/// Time from one cycle to the next in microseconds.
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;

/// Bit rate of the bus.
pub(crate) const BIT_RATE: BitRate = MASTER.bus.bit_rate;

/// The proof, made while compiling, that the bus carries these axes in time. When it fails, the error says which frame would be late
/// and what would help.
pub(crate) const PLAN: BusPlan<'static> = BusPlan::new(&MASTER, &AXIS_CONFIGS);
const _: () = PLAN.assert_schedulable();

/// The drives in ascending order of id, each with its gear number: what is stored in the drive, 500 to 16384 (CAN specification 1.6A,
/// `Set_Gear_Number`). A turn of the motor is 4 times as many command counts. A drive with another gear number is not enabled.
const DRIVES: [(DriveId, GearNumber); AXES] = [drive(1, 4_096), drive(2, 4_096)];

/// Fastest speed and fastest change of speed of the motors; slow on purpose, for the first test of a machine. The axes slow down and
/// catch up with that change; the motion must keep the speed, which is checked below.
const MOTOR_LIMITS: MotorLimits = MotorLimits {
    speed_rpm: 150,
    acceleration_rpm_per_s: 1_000,
};

/// Where an axis may go, in command counts from the origin of its drive. The whole range, because the origin is not known here: set it
/// to your machine's ends.
const TRAVEL: Travel = Travel::WHOLE;

const fn limits(gear: GearNumber) -> Limits {
    match Limits::of_motor(MOTOR_LIMITS, TRAVEL, gear, CYCLE_US) {
        Ok(limits) => limits,
        Err(_) => panic!(
            "MOTOR_LIMITS must make a step of 1 to 16384 counts a cycle, which changes by 1/256 to 16384 counts"
        ),
    }
}

/// The built-in motion, relative to where the axes stand when it starts; it is repeated for ever, so it ends there too.
pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => {
        panic!("KEYFRAMES must start at 0 ms with angle 0, each later than the one before")
    }
};

/// Time in milliseconds and angle of each motor in degrees: a quarter of a turn and back, the two axes in opposite directions.
const KEYFRAMES: [Keyframe<AXES>; 5] = [
    keyframe(0, [0, 0]),
    keyframe(1_000, [90, -90]),
    keyframe(1_500, [90, -90]),
    keyframe(2_500, [0, 0]),
    keyframe(3_000, [0, 0]),
];

const _: () = {
    let peaks_counts = MOTION.peak_step_counts(MASTER.cycle_us);
    let end_counts = KEYFRAMES[KEYFRAMES.len() - 1].positions_counts;
    let mut axis = 0;
    while axis < AXES {
        let limit = AXIS_CONFIGS[axis].limits.max_step.get() as u64;
        assert!(
            peaks_counts[axis] <= limit,
            "the motion is faster than MOTOR_LIMITS"
        );
        assert!(
            end_counts[axis] == 0,
            "the motion is repeated: end it at angle 0"
        );
        axis += 1;
    }
};

/// The axes, made of what is above.
pub(crate) const AXIS_CONFIGS: [AxisConfig; AXES] = {
    let mut axes = [axis(0); AXES];
    let mut index = 1;
    while index < AXES {
        axes[index] = axis(index);
        index += 1;
    }
    axes
};

const fn axis(index: usize) -> AxisConfig {
    let (drive, gear) = DRIVES[index];
    AxisConfig {
        group: GROUP,
        ..AxisConfig::new(drive, gear, limits(gear))
    }
}

const fn drive(id: i32, gear: i32) -> (DriveId, GearNumber) {
    match (DriveId::new(id), GearNumber::new(gear)) {
        (Ok(id), Ok(gear)) => (id, gear),
        (Err(_), _) => panic!("a drive id is 1 to 63"),
        (_, Err(_)) => panic!("a gear number is 500 to 16384"),
    }
}

const fn keyframe(at_ms: u32, degrees: [i32; AXES]) -> Keyframe<AXES> {
    let mut positions_counts = [0; AXES];
    let mut axis = 0;
    while axis < AXES {
        let counts = degrees[axis] as i64 * command_counts_per_turn(DRIVES[axis].1) as i64 / 360;
        assert!(
            counts == counts as i32 as i64,
            "an angle is beyond the range of a drive"
        );
        positions_counts[axis] = counts as i32;
        axis += 1;
    }
    Keyframe {
        at_ms,
        positions_counts,
    }
}
