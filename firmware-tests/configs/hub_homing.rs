// Two ZLAC8030L hub motors that move axes and are homed before they move: node 1 to a hard stop in the negative direction, node 2 to a
// switch in the positive one, on PC3. To be compiled in the place of `src/config.rs`:
// `cargo fw --config firmware-tests/configs/hub_homing.rs`.

use can_motion::GroupId;
use can_motion::plan::BitRate;
use can_motion::wheel::{WheelConfig, WheelLimits, WheelMasterConfig, WheelMode, WheelPlan, Zlac};
use trajectory::curve::{Keyframe, KeyframeMotion};
use zlac8030l::NodeId;

pub(crate) type Drives = Zlac;

pub(crate) const AXES: usize = 2;
pub(crate) const GROUP: GroupId = GroupId(0);
pub(crate) const MASTER: WheelMasterConfig = WheelMasterConfig::DEFAULT;
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;
pub(crate) const BIT_RATE: BitRate = MASTER.bit_rate;
pub(crate) const PLAN: WheelPlan<'static> = WheelPlan::new(&MASTER, &AXIS_CONFIGS);

/// Homing before the motion.
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Sequence<Machine>;

/// How each axis finds its reference.
#[cfg(target_os = "none")]
pub(crate) struct Machine;

/// Torques are thousandths of 30 A. A drive is told a place every second cycle and makes a profile to it, so it lags more than a servo.
#[cfg(target_os = "none")]
impl crate::home::Plan for Machine {
    const AXES: [Option<crate::home::AxisHoming>; AXES] = [
        Some(crate::home::AxisHoming {
            search: search(homing::Method::HardStop(homing::HardStop {
                direction: homing::Direction::Negative,
                contact_permille: 150,
                most_permille: 800,
                contact_counts: 170,
                most_counts: 1_024,
                repeat_counts: 40,
            })),
            switch_pin: None,
        }),
        Some(crate::home::AxisHoming {
            search: search(homing::Method::Switch(homing::Switch {
                direction: homing::Direction::Positive,
                operated: homing::Level::High,
                most_counts: 1_024,
                most_permille: None,
            })),
            switch_pin: Some(3),
        }),
    ];
}

/// 10 counts a cycle are 15 r/min, 2.5 are 4; half a turn at most, and back by 200 counts. The reference is at 0 of the axis, which may go
/// a turn from there.
#[cfg(target_os = "none")]
const fn search(method: homing::Method) -> homing::Config {
    homing::Config {
        method,
        cycle_us: CYCLE_US,
        search: speed(10.0),
        slow: speed(2.5),
        way_counts: 2_048,
        back_off_counts: 200,
        reference_counts: 0,
        travel: homing::Travel {
            min_counts: -4_096,
            max_counts: 4_096,
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
    match trajectory::Limits::new(counts, 0.5, 0.1) {
        Ok(limits) => limits,
        Err(_) => panic!("a speed, a change of it, and a jerk that are in range"),
    }
}

pub(crate) const AXIS_CONFIGS: [WheelConfig; AXES] = [axis(1), axis(2)];

/// Profiles of the drive at 25 r/min; 40 counts a cycle at most.
const fn axis(node: i32) -> WheelConfig {
    let Ok(node) = NodeId::new(node) else {
        panic!("a node is 1 to 127");
    };
    WheelConfig {
        group: GROUP,
        ramp_ms: 1_000,
        ..WheelConfig::new(
            node,
            WheelMode::Position {
                profile_speed_rpm: 25,
            },
            WheelLimits::position(-1_000_000, 1_000_000, 40, 4),
        )
    }
}

/// Relative to where the axes rest after their homing: an eighth of a turn off the reference and back.
pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => panic!("KEYFRAMES must start at 0 ms with 0, each later than the one before"),
};

const KEYFRAMES: [Keyframe<AXES>; 3] = [
    keyframe(0, [0, 0]),
    keyframe(1_000, [512, -512]),
    keyframe(2_000, [0, 0]),
];

const fn keyframe(at_ms: u32, positions_counts: [i32; AXES]) -> Keyframe<AXES> {
    Keyframe {
        at_ms,
        positions_counts,
    }
}
