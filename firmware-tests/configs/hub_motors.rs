// Two ZLAC8030L hub motors, nodes 1 and 2: slow on purpose, for the first test of a machine. To be compiled in the place of
// `src/config.rs`: `cargo fw --config firmware-tests/configs/hub_motors.rs`.

use can_motion::GroupId;
use can_motion::plan::BitRate;
use can_motion::wheel::{
    WheelConfig, WheelLimits, WheelMasterConfig, WheelMode, WheelPlan, Zlac,
};
use trajectory::curve::{Keyframe, KeyframeMotion};
use zlac8030l::NodeId;

/// The family of the drives.
pub(crate) type Drives = Zlac;

/// No homing before the motion: wheels have no reference.
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Nothing;

/// Number of wheels.
pub(crate) const AXES: usize = 2;
/// The wheels move and stop together.
pub(crate) const GROUP: GroupId = GroupId(0);

/// 100 Hz, 500 kbit/s, feedback every 10 ms: the bit rate is the one that the drives are set to (200Eh: 100, 125, 250, 500 or 1000 kbit/s).
pub(crate) const MASTER: WheelMasterConfig = WheelMasterConfig::DEFAULT;

/// Time from one cycle to the next in microseconds.
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;

/// Bit rate of the bus.
pub(crate) const BIT_RATE: BitRate = MASTER.bit_rate;

/// Whether the bus carries these wheels is checked at the start: without room nothing is enabled, and the log says why.
pub(crate) const PLAN: WheelPlan<'static> = WheelPlan::new(&MASTER, &AXIS_CONFIGS);

/// Fastest speed in r/min, and how much it changes in a cycle.
const MAX_RPM: u16 = 60;
const CHANGE_RPM: u32 = 1;

/// The wheels in ascending order of node. The motor on the other side of a vehicle turns the other way: `counter_clockwise`.
pub(crate) const AXIS_CONFIGS: [WheelConfig; AXES] = [wheel(1, false), wheel(2, true)];

/// The built-in motion: speeds in r/min, repeated for ever, so it ends with 0. Forward and back again, then on the spot.
pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => panic!("KEYFRAMES must start at 0 ms with speed 0, each later than the one before"),
};

const KEYFRAMES: [Keyframe<AXES>; 7] = [
    speeds(0, [0, 0]),
    speeds(1_000, [30, 30]),
    speeds(2_000, [0, 0]),
    speeds(3_000, [-30, -30]),
    speeds(4_000, [0, 0]),
    speeds(5_000, [20, -20]),
    speeds(6_000, [0, 0]),
];

const _: () = {
    let mut frame = 0;
    while frame < KEYFRAMES.len() {
        let mut wheel = 0;
        while wheel < AXES {
            let rpm = KEYFRAMES[frame].positions_counts[wheel];
            assert!(
                rpm.unsigned_abs() <= MAX_RPM as u32,
                "a speed is beyond MAX_RPM"
            );
            let is_last = frame == KEYFRAMES.len() - 1;
            assert!(!is_last || rpm == 0, "the motion is repeated: end it at 0");
            wheel += 1;
        }
        frame += 1;
    }
};

const fn wheel(node: i32, counter_clockwise: bool) -> WheelConfig {
    let Ok(node) = NodeId::new(node) else {
        panic!("a node is 1 to 127");
    };
    WheelConfig {
        group: GROUP,
        counter_clockwise,
        ..WheelConfig::new(
            node,
            WheelMode::Velocity,
            WheelLimits::speed(MAX_RPM, CHANGE_RPM),
        )
    }
}

/// Time in milliseconds and speed of each wheel in r/min.
const fn speeds(at_ms: u32, rpm: [i32; AXES]) -> Keyframe<AXES> {
    Keyframe {
        at_ms,
        positions_counts: rpm,
    }
}
