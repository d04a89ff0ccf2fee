//! One servo axis that turns a quarter to and fro: what the examples have in common.
#![no_std]
#![forbid(unsafe_code)]

use can_motion::plan::{BusSetup, TxOrder};
use can_motion::{
    AxisConfig, AxisState, ConfigError, GroupId, Instant, Limits, MasterConfig, MotorLimits,
    ServoMaster, Travel,
};
use dyn_can::{DriveId, GearNumber};

const GROUP: GroupId = GroupId(0);
/// Every cycle begins so much after the one before.
pub const CYCLE_US: u32 = MasterConfig::DEFAULT.cycle_us;
/// Cycles of the way there; 16384 counts are a turn with the gear number below.
const CYCLES: i32 = 1_000;
const COUNTS_A_CYCLE: i32 = 4;

/// Why there is no master.
#[derive(Debug)]
pub struct Refused(pub &'static str);

impl From<ConfigError> for Refused {
    fn from(_: ConfigError) -> Self {
        Self("the settings of the axis cannot work")
    }
}

/// A master of drive 1, slow, within half a turn either way. `order` is that in which the controller sends what waits in it: the plan of the
/// bus counts with it.
///
/// # Errors
/// When the settings cannot work.
pub fn master(order: TxOrder) -> Result<ServoMaster<1>, Refused> {
    let wrong = "a value is out of its range";
    let drive = DriveId::new(1).map_err(|_| Refused(wrong))?;
    let gear = GearNumber::new(4_096).map_err(|_| Refused(wrong))?;
    let motor = MotorLimits {
        speed_rpm: 60,
        acceleration_rpm_per_s: 600,
    };
    let travel = Travel::of_motor_millidegrees(-180_000, 180_000, gear);
    let config = MasterConfig {
        bus: BusSetup {
            order,
            ..MasterConfig::DEFAULT.bus
        },
        ..MasterConfig::DEFAULT
    };
    let limits = Limits::of_motor(motor, travel, gear, config.cycle_us)
        .map_err(|_| Refused("the limits cannot work"))?;
    Ok(ServoMaster::new(
        config,
        &[AxisConfig::new(drive, gear, limits)],
    )?)
}

/// What the application decides in a cycle, before the frames of the cycle go out.
pub fn cycle(master: &mut ServoMaster<1>, now: Instant, count: u32) {
    // What is refused here is asked for again in the next cycle; an application would look at the reason.
    let _ = if master.all_are(GROUP, AxisState::FoundOn) {
        master.adopt(now, GROUP)
    } else if master.all_are(GROUP, AxisState::Ready) {
        master.enable(now, GROUP)
    } else if master.all_are(GROUP, AxisState::Holding) {
        master.resume(now, GROUP)
    } else {
        Ok(())
    };
    if master.all_are(GROUP, AxisState::Streaming) {
        let place = (count % (2 * CYCLES as u32)) as i32;
        let counts = COUNTS_A_CYCLE * (CYCLES - (place - CYCLES).abs());
        let _ = master.set_target(0, counts);
    }
    master.begin_cycle(now);
}
