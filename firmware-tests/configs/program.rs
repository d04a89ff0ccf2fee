// Two servo axes on a program of G-code, examples/programs/slot.ngc, that `motionctl keyframes` made keyframes of. To be compiled in the place
// of `src/config.rs`: `cargo fw --config firmware-tests/configs/program.rs`.

use can_motion::plan::{BitRate, BusPlan};
use can_motion::{AxisConfig, Dyn, GroupId, Limits, MasterConfig, MotorLimits, Travel};
use dyn_can::{DriveId, GearNumber};

// The motion, and the drives and gear numbers that its counts are for.
include!("slot.rs");

pub(crate) type Drives = Dyn;
#[cfg(target_os = "none")]
pub(crate) type Homing = crate::home::Nothing;

pub(crate) const AXES: usize = MOTION_DRIVES.len();
pub(crate) const GROUP: GroupId = GroupId(0);
pub(crate) const MASTER: MasterConfig = MasterConfig::DEFAULT;
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;
pub(crate) const BIT_RATE: BitRate = MASTER.bus.bit_rate;
pub(crate) const PLAN: BusPlan<'static> = BusPlan::new(&MASTER, &AXIS_CONFIGS);
const _: () = PLAN.assert_schedulable();

/// Those of the program; the axes slow down with this acceleration.
const MOTOR_LIMITS: MotorLimits = MotorLimits {
    speed_rpm: 1_500,
    acceleration_rpm_per_s: 12_000,
};

pub(crate) const AXIS_CONFIGS: [AxisConfig; AXES] = [axis(0), axis(1)];

const fn axis(index: usize) -> AxisConfig {
    let (id, gear) = MOTION_DRIVES[index];
    let (Ok(drive), Ok(gear)) = (DriveId::new(id), GearNumber::new(gear)) else {
        panic!("a drive id is 1 to 63, and a gear number 500 to 16384");
    };
    let Ok(limits) = Limits::of_motor(MOTOR_LIMITS, Travel::WHOLE, gear, CYCLE_US) else {
        panic!("MOTOR_LIMITS must make a step of 1 to 16384 counts a cycle");
    };
    AxisConfig {
        group: GROUP,
        ..AxisConfig::new(drive, gear, limits)
    }
}

const _: () = {
    let peaks_counts = MOTION.peak_step_counts(CYCLE_US);
    let mut axis = 0;
    while axis < AXES {
        assert!(
            peaks_counts[axis] <= AXIS_CONFIGS[axis].limits.max_step.get() as u64,
            "the motion is faster than MOTOR_LIMITS"
        );
        axis += 1;
    }
};
