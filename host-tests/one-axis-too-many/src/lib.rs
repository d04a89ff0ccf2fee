//! The configuration of a firmware, as in `src/config.rs` of the project: 15 axes at 1 kHz do not fit on 1 Mbit/s.

#![no_std]

use can_motion::plan::BusPlan;
use can_motion::{AxisConfig, Limits, MasterConfig, PollPeriods, StepChange, Travel};
use dyn_can::{DriveId, GearNumber, StepLimit};

const AXES: usize = if cfg!(feature = "fits") { 14 } else { 15 };

pub const MASTER: MasterConfig = MasterConfig::DEFAULT;

pub const AXIS_CONFIGS: [AxisConfig; AXES] = {
    let mut axes = [axis(1); AXES];
    let mut index = 1;
    while index < AXES {
        axes[index] = axis(index as i32 + 1);
        index += 1;
    }
    axes
};

const _: () = BusPlan::new(&MASTER, &AXIS_CONFIGS).assert_schedulable();

const fn axis(drive: i32) -> AxisConfig {
    let (Ok(drive), Ok(gear)) = (DriveId::new(drive), GearNumber::new(4_096)) else {
        panic!("a drive id is 1 to 63, a gear number 500 to 16384");
    };
    // Steps of every length, so set-points of the longest.
    let limits = Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE);
    AxisConfig {
        polls: PollPeriods::OFF,
        unwatched: true,
        ..AxisConfig::new(drive, gear, limits)
    }
}
