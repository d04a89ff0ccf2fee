//! What a user of this firmware decides: drives, limits, bit rate and the built-in motion. Pins and clocks are in `board`.

use can_motion::motion::{Keyframe, KeyframeMotion};
use can_motion::plan::BusPlan;
use can_motion::{AxisConfig, GroupId, Limits, MasterConfig};
use dyn_can::{DriveId, StepLimit};

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

/// The proof, made while compiling, that the bus carries these axes in time. When it fails, the error says which frame would be late
/// and what would help.
pub(crate) const PLAN: BusPlan<'static> = BusPlan::new(&MASTER, &AXIS_CONFIGS);
const _: () = PLAN.assert_schedulable();

/// The axes in ascending order of drive id.
pub(crate) const AXIS_CONFIGS: [AxisConfig; AXES] = [axis(1), axis(2)];

/// Limits of each axis in command counts; 16384 are one turn of the motor at gear number 4096.
///
/// Slow and narrow on purpose, for the first test of a machine. The travel is the whole range of the drive because its
/// origin is not known here: set it to your machine's.
const LIMITS: Limits = Limits {
    max_step: step_limit(40),
    ramp_change: 1,
    backlog: 400,
    ..Limits::WIDEST
};

/// The built-in motion, relative to where the axes stand when it starts; it is repeated for ever, so it ends there too.
pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => {
        panic!("KEYFRAMES must start at 0 ms with distance 0, each later than the one before")
    }
};

/// A quarter of a turn and back, the two axes in opposite directions.
const KEYFRAMES: [Keyframe<AXES>; 5] = [
    keyframe(0, [0, 0]),
    keyframe(1_000, [4_096, -4_096]),
    keyframe(1_500, [4_096, -4_096]),
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
            "the motion is faster than max_step"
        );
        assert!(
            end_counts[axis] == 0,
            "the motion is repeated: end it at distance 0"
        );
        axis += 1;
    }
};

const fn axis(drive: i32) -> AxisConfig {
    let Ok(drive) = DriveId::new(drive) else {
        panic!("a drive id is 1 to 63");
    };
    AxisConfig {
        group: GROUP,
        limits: LIMITS,
        ..AxisConfig::new(drive)
    }
}

const fn step_limit(counts: i32) -> StepLimit {
    match StepLimit::new(counts) {
        Ok(limit) => limit,
        Err(_) => panic!("a step limit is 1 to 16384 counts"),
    }
}

const fn keyframe(at_ms: u32, positions_counts: [i32; AXES]) -> Keyframe<AXES> {
    Keyframe {
        at_ms,
        positions_counts,
    }
}
