//! The options that say how the drives of a real bus report their position.

use can_motion::{AxisConfig, Limits, PollPeriods, ReadBackScale, StepChange, Travel};
use clap::ValueEnum;
use dyn_can::{DriveId, GearNumber, StepLimit};

/// How the drives report their position.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct AxisOptions {
    /// Unit of the position that the drives report. The documents do not say: turn a shaft once and compare.
    #[arg(long, value_enum, default_value_t)]
    read_back: ReadBack,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum ReadBack {
    /// Command counts: 4 times the gear number a turn.
    #[default]
    Command,
    /// Movement positions: 65536 a turn, whatever the gear number.
    #[value(alias = "encoder")]
    Movement,
    /// Motor steps: 16384 a turn, whatever the gear number.
    Motor,
}

/// The smallest limits, of an axis that is not moved.
const STILL: Limits = match StepLimit::new(1) {
    Ok(step) => Limits::new(step, StepChange::MIN, Travel::WHOLE),
    Err(_) => panic!("1 is a step"),
};

impl AxisOptions {
    /// The scale of the position of a drive with this gear number.
    pub(crate) const fn scale(&self, gear: GearNumber) -> ReadBackScale {
        match self.read_back {
            ReadBack::Command => ReadBackScale::COMMAND_COUNTS,
            ReadBack::Movement => ReadBackScale::movement_positions(gear),
            ReadBack::Motor => ReadBackScale::motor_steps(gear),
        }
    }

    /// An axis that is not moved, wherever it stands.
    pub(crate) fn still(&self, drive: DriveId, gear: GearNumber, polls: PollPeriods) -> AxisConfig {
        self.axis(drive, gear, STILL, polls)
    }

    /// An axis with its limits; its travel ends at the latest where the position cannot be read back any more.
    pub(crate) fn axis(
        &self,
        drive: DriveId,
        gear: GearNumber,
        limits: Limits,
        polls: PollPeriods,
    ) -> AxisConfig {
        let read_back = self.scale(gear);
        let reach = |end: i32| {
            let most = i64::from(end) * i64::from(read_back.command_counts)
                / i64::from(read_back.read_back_counts);
            i32::try_from(most).unwrap_or(end)
        };
        let Travel {
            min_counts,
            max_counts,
        } = Travel::WHOLE;
        let travel = Travel {
            min_counts: limits.travel.min_counts.max(reach(min_counts)),
            max_counts: limits.travel.max_counts.min(reach(max_counts)),
        };
        AxisConfig {
            polls,
            unwatched: polls.status_us.is_none(),
            read_back,
            ..AxisConfig::new(drive, gear, Limits { travel, ..limits })
        }
    }
}
