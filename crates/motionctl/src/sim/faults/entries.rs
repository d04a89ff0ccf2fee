//! The tables of a fault script, one type for each kind of fault. `docs/fault-scripts.md` describes them.

use core::num::NonZeroU64;

use dyn_can::{Alarm, DriveId};
use serde::Deserialize;

use super::Fault;

const NS_PER_S: f64 = 1e9;

/// A time of the script: finite and not negative.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "f64")]
pub(super) struct Time {
    pub(super) ns: u64,
}

impl TryFrom<f64> for Time {
    type Error = String;

    fn try_from(time_s: f64) -> Result<Self, String> {
        // A day: longer than any run, and exact in nanoseconds.
        if !(0.0..=86_400.0).contains(&time_s) {
            return Err(format!("must be 0..=86400 s, got {time_s}"));
        }
        Ok(Self {
            ns: (time_s * NS_PER_S).round() as u64,
        })
    }
}

/// A drive id 1 ..= 63.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "i32")]
pub(super) struct Drive(pub(super) DriveId);

impl TryFrom<i32> for Drive {
    type Error = String;

    fn try_from(id: i32) -> Result<Self, String> {
        DriveId::new(id)
            .map(Self)
            .map_err(|error| error.to_string())
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum AlarmName {
    LostPhase,
    OverCurrent,
    Overheat,
    CommandRefused,
}

/// Once the table is read: when, what, and what ends it.
pub(super) trait Entry {
    fn at(&self) -> Time;
    fn fault(&self) -> Fault;
    fn end(&self) -> Option<(Time, Fault)> {
        None
    }
}

const fn one() -> u32 {
    1
}

/// In the middle of a frame.
const fn bit_20() -> u32 {
    20
}

macro_rules! entries {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty $(= $default:literal)?),* } => |$this:ident| $fault:expr $(, until $end:expr)?;)*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Deserialize)]
            #[serde(deny_unknown_fields)]
            pub(super) struct $name {
                at_s: Time,
                $($(#[serde(default = $default)])? $field: $type,)*
            }

            impl Entry for $name {
                fn at(&self) -> Time {
                    self.at_s
                }

                fn fault(&self) -> Fault {
                    let $this = self;
                    $fault
                }

                $(fn end(&self) -> Option<(Time, Fault)> {
                    let $this = self;
                    let after = $this.for_s?;
                    Some((Time { ns: $this.at_s.ns + after.ns }, $end))
                })?
            }
        )*
    };
}

entries! {
    AlarmEntry { drive: Drive, alarm: AlarmName, repeat_s: Option<Time> } => |this| Fault::Alarm {
        drive: this.drive.0,
        alarm: match this.alarm {
            AlarmName::LostPhase => Alarm::LostPhase,
            AlarmName::OverCurrent => Alarm::OverCurrent,
            AlarmName::Overheat => Alarm::OverheatOrOverpower,
            AlarmName::CommandRefused => Alarm::CommandRefused,
        },
        repeat_ns: this.repeat_s.and_then(|repeat| NonZeroU64::new(repeat.ns)),
    };
    SilenceEntry { drive: Drive, for_s: Option<Time> } => |this| Fault::Silence { drive: this.drive.0 },
        until Fault::Wake { drive: this.drive.0 };
    UnplugEntry { drive: Drive, for_s: Option<Time> } => |this| Fault::Unplug { drive: this.drive.0 },
        until Fault::PlugIn { drive: this.drive.0 };
    PowerCycleEntry { drive: Drive, off_s: Time } => |this| Fault::PowerCycle { drive: this.drive.0, off_ns: this.off_s.ns };
    DisableEntry { drive: Drive } => |this| Fault::Disable { drive: this.drive.0 };
    DropRepliesEntry { drive: Drive, count: u32 = "one" } => |this| Fault::DropReplies { drive: this.drive.0, count: this.count };
    DelayReplyEntry { drive: Drive, by_s: Time } => |this| Fault::DelayReply { drive: this.drive.0, by_ns: this.by_s.ns };
    RepeatSetPointEntry { drive: Drive, count: u32 = "one" } => |this| Fault::RepeatSetPoint { drive: this.drive.0, count: this.count };
    LoseSetPointEntry { drive: Drive, count: u32 = "one" } => |this| Fault::LoseSetPoint { drive: this.drive.0, count: this.count };
    CorruptEntry { frames: u32 = "one", at_bit: u32 = "bit_20" } => |this| Fault::Corrupt { frames: this.frames, at_bit: this.at_bit };
    BlockEntry { for_s: Time } => |this| Fault::Block { for_ns: this.for_s.ns };
    DisturbEntry { for_s: Time } => |this| Fault::Disturb { for_ns: this.for_s.ns };
    MissCyclesEntry { cycles: u32 = "one" } => |this| Fault::MissCycles { cycles: this.cycles };
}
