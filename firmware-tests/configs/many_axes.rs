// A configuration for the tests: as many axes as the variable FIRMWARE_TEST_AXES says, with drive ids from 1.

use can_motion::plan::{BitRate, BusPlan};
use can_motion::{AxisConfig, Dyn, GroupId, Limits, MasterConfig, PollPeriods, StepChange, Travel};
use dyn_can::{DriveId, GearNumber, StepLimit};
use trajectory::curve::{Keyframe, KeyframeMotion};

pub(crate) type Drives = Dyn;
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Nothing;

pub(crate) const AXES: usize = number(env!("FIRMWARE_TEST_AXES"));
pub(crate) const GROUP: GroupId = GroupId(0);
pub(crate) const MASTER: MasterConfig = MasterConfig::DEFAULT;
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;
pub(crate) const BIT_RATE: BitRate = MASTER.bus.bit_rate;

pub(crate) const PLAN: BusPlan<'static> = BusPlan::new(&MASTER, &AXIS_CONFIGS);
const _: () = PLAN.assert_schedulable();

/// With more axes a bus of 1 Mbit/s has no room for polls beside the set-points of a 1 kHz cycle.
const MOST_WITH_POLLS: usize = 11;

pub(crate) const AXIS_CONFIGS: [AxisConfig; AXES] = {
    let mut axes = [axis(1); AXES];
    let mut index = 0;
    while index < AXES {
        axes[index] = axis(index as i32 + 1);
        index += 1;
    }
    axes
};

pub(crate) const MOTION: KeyframeMotion<'static, AXES> = match KeyframeMotion::new(&KEYFRAMES) {
    Ok(motion) => motion,
    Err(_) => panic!("the keyframes make no motion"),
};

const KEYFRAMES: [Keyframe<AXES>; 3] = [keyframe(0, 0), keyframe(500, 20_000), keyframe(1_000, 0)];

const fn axis(drive: i32) -> AxisConfig {
    let (Ok(drive), Ok(gear)) = (DriveId::new(drive), GearNumber::new(4_096)) else {
        panic!("a drive id is 1 to 63, a gear number 500 to 16384");
    };
    let (Ok(max_step), Some(change)) = (StepLimit::new(200), StepChange::from_counts(2)) else {
        panic!("a step limit and its change are 1 to 16384 counts");
    };
    let limits = Limits::new(max_step, change, Travel::WHOLE);
    let is_watched = AXES <= MOST_WITH_POLLS;
    AxisConfig {
        group: GROUP,
        polls: if is_watched {
            PollPeriods::DEFAULT
        } else {
            PollPeriods::OFF
        },
        unwatched: !is_watched,
        ..AxisConfig::new(drive, gear, limits)
    }
}

const fn keyframe(at_ms: u32, counts: i32) -> Keyframe<AXES> {
    Keyframe {
        at_ms,
        positions_counts: [counts; AXES],
    }
}

const fn number(digits: &str) -> usize {
    let (digits, mut value, mut at) = (digits.as_bytes(), 0, 0);
    while at < digits.len() {
        value = 10 * value + (digits[at] - b'0') as usize;
        at += 1;
    }
    value
}
