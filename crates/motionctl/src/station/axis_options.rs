//! The options that say how the drives of a real bus report their position.

use can_motion::{
    AxisConfig, DialectChoice, Limits, PollPeriods, ReadBackScale, StepChange, Travel,
};
use clap::ValueEnum;
use dyn_can::{ByteOrder, Dialect, DriveId, GearNumber, Group3ReplyOrder, StepLimit};

/// How the drives report their position.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct AxisOptions {
    /// Unit of the position that the drives report. The documents do not say: turn a shaft once and compare.
    #[arg(long, value_enum, default_value_t)]
    read_back: ReadBack,
    #[command(flatten)]
    replies: ReplyOptions,
}

/// How replies are read that can be read in two ways.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct ReplyOptions {
    /// Byte order of gear and line number in the reply of a drive of revision 1.2A. Only needed when a drive is refused because both
    /// orders give a legal number; the vendor's tool shows which is right.
    #[arg(long, value_enum)]
    group3_order: Option<OrderOption>,
}

/// A byte order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrderOption {
    /// Most significant byte first.
    MsbFirst,
    /// Least significant byte first.
    LsbFirst,
}

impl ReplyOptions {
    fn dialect(self) -> DialectChoice {
        let order = match self.group3_order {
            None => return DialectChoice::Detect,
            Some(OrderOption::MsbFirst) => ByteOrder::MsbFirst,
            Some(OrderOption::LsbFirst) => ByteOrder::LsbFirst,
        };
        DialectChoice::Fixed(Dialect {
            group3_reply_order_1_2a: Group3ReplyOrder::Fixed(order),
            ..Dialect::V1_2A
        })
    }
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

impl From<ReplyOptions> for AxisOptions {
    /// For commands that read and do not move.
    fn from(replies: ReplyOptions) -> Self {
        Self {
            replies,
            ..Self::default()
        }
    }
}

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
            dialect: self.replies.dialect(),
            ..AxisConfig::new(drive, gear, Limits { travel, ..limits })
        }
    }
}
