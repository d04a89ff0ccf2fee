//! The options that say how the drives of a real bus report their position.

use can_motion::{AxisConfig, Limits, PollPeriods, ReadBackScale};
use clap::ValueEnum;
use dyn_can::{DriveId, StepLimit};

/// How the drives report their position.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct AxisOptions {
    /// Unit of the position that the drives report. The documents do not say (D44): turn a shaft once and compare.
    #[arg(long, value_enum, default_value_t)]
    read_back: ReadBack,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum ReadBack {
    /// Command counts: 16384 a turn at gear number 4096.
    #[default]
    Command,
    /// Encoder counts: 65536 a turn.
    Encoder,
}

impl AxisOptions {
    /// The scale of the position.
    pub(crate) const fn scale(&self) -> ReadBackScale {
        match self.read_back {
            ReadBack::Command => ReadBackScale::COMMAND_COUNTS,
            ReadBack::Encoder => ReadBackScale::ENCODER_COUNTS,
        }
    }

    /// An axis with the whole travel that the protocol can read back.
    pub(crate) fn axis(
        &self,
        drive: DriveId,
        max_step: StepLimit,
        polls: PollPeriods,
    ) -> AxisConfig {
        let (read_back, widest) = (self.scale(), Limits::WIDEST);
        let per_count = i32::try_from(read_back.read_back_counts).unwrap_or(i32::MAX);
        AxisConfig {
            limits: Limits {
                max_step,
                travel_min: widest.travel_min / per_count,
                travel_max: widest.travel_max / per_count,
                ..widest
            },
            polls,
            read_back,
            ..AxisConfig::new(drive)
        }
    }
}
