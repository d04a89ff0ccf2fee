// Two servo axes that are homed before they move: drive 1 to a hard stop in the negative direction, drive 2 to a switch in the positive one,
// on PC3. To be compiled in the place of `src/config.rs`: `cargo fw --config firmware-tests/configs/homing.rs`.

use can_motion::plan::{BitRate, BusPlan};
use can_motion::{
    AxisConfig, Dyn, GroupId, Limits, MasterConfig, MotorLimits, PollPeriods, Travel,
};
use dyn_can::{DriveId, GearNumber};
use trajectory::curve::{Keyframe, KeyframeMotion};

pub(crate) type Drives = Dyn;

pub(crate) const AXES: usize = 2;
pub(crate) const GROUP: GroupId = GroupId(0);
pub(crate) const MASTER: MasterConfig = MasterConfig::DEFAULT;
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;
pub(crate) const BIT_RATE: BitRate = MASTER.bus.bit_rate;
pub(crate) const PLAN: BusPlan<'static> = BusPlan::new(&MASTER, &AXIS_CONFIGS);
const _: () = PLAN.assert_schedulable();

/// Slow on purpose, for the first test of a machine.
const MOTOR_LIMITS: MotorLimits = MotorLimits {
    speed_rpm: 150,
    acceleration_rpm_per_s: 1_000,
};

/// Homing before the motion.
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Sequence<Machine>;

/// How each axis finds its reference.
#[cfg(target_os = "none")]
pub(crate) struct Machine;

#[cfg(target_os = "none")]
impl crate::home::Plan for Machine {
    const AXES: [Option<crate::home::AxisHoming>; AXES] = [
        Some(crate::home::AxisHoming {
            search: search(homing::Method::HardStop(homing::HardStop {
                direction: homing::Direction::Negative,
                contact_permille: 200,
                most_permille: 800,
                contact_counts: 90,
                most_counts: 2_000,
                repeat_counts: 20,
            })),
            switch_pin: None,
        }),
        Some(crate::home::AxisHoming {
            search: search(homing::Method::Switch(homing::Switch {
                direction: homing::Direction::Positive,
                operated: homing::Level::High,
                most_counts: 1_000,
                most_permille: None,
            })),
            switch_pin: Some(3),
        }),
    ];
}

/// 8 counts a cycle are 29 r/min, 2 are 7; half a turn at most, and back by 400 counts. The reference is at 0 of the axis, which may go a
/// turn from there.
#[cfg(target_os = "none")]
const fn search(method: homing::Method) -> homing::Config {
    homing::Config {
        method,
        cycle_us: CYCLE_US,
        search: speed(8.0),
        slow: speed(2.0),
        way_counts: 8_192,
        back_off_counts: 400,
        reference_counts: 0,
        travel: homing::Travel {
            min_counts: -16_384,
            max_counts: 16_384,
        },
        watch: homing::Watch {
            max_age_us: 50_000,
            ..homing::Watch::DEFAULT
        },
    }
}

/// So many counts a cycle, 0.5 more or less in each.
#[cfg(target_os = "none")]
const fn speed(counts: f32) -> trajectory::Limits {
    match trajectory::Limits::new(counts, 0.5, 0.05) {
        Ok(limits) => limits,
        Err(_) => panic!("a speed, a change of it, and a jerk that are in range"),
    }
}

pub(crate) const AXIS_CONFIGS: [AxisConfig; AXES] = [axis(1), axis(2)];

const fn axis(id: i32) -> AxisConfig {
    let (Ok(drive), Ok(gear)) = (DriveId::new(id), GearNumber::new(4_096)) else {
        panic!("a drive id is 1 to 63, and a gear number 500 to 16384");
    };
    let Ok(limits) = Limits::of_motor(MOTOR_LIMITS, Travel::WHOLE, gear, CYCLE_US) else {
        panic!("MOTOR_LIMITS must make a step of 1 to 16384 counts a cycle");
    };
    AxisConfig {
        group: GROUP,
        // What a homing reads: torque and position 100 times a second.
        polls: PollPeriods {
            position_us: Some(10_000),
            torque_us: Some(10_000),
            ..PollPeriods::DEFAULT
        },
        ..AxisConfig::new(drive, gear, limits)
    }
}

/// Relative to where the axes rest after their homing: an eighth of a turn off the reference and back.
pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => panic!("KEYFRAMES must start at 0 ms with 0, each later than the one before"),
};

const KEYFRAMES: [Keyframe<AXES>; 3] = [
    keyframe(0, [0, 0]),
    keyframe(500, [2_048, -2_048]),
    keyframe(1_000, [0, 0]),
];

const fn keyframe(at_ms: u32, positions_counts: [i32; AXES]) -> Keyframe<AXES> {
    Keyframe {
        at_ms,
        positions_counts,
    }
}
