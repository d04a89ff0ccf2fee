//! Faults of the simulated bus and drives: read from a script, or commanded by a key of the live view.

mod entries;
mod script;

use crate::counted::counted;
use core::fmt;
use core::num::NonZeroU64;

use drive_sim::{
    Bench, DeviceId, DynDrive, FrameMatch, NodeId, Outage, OutageKind, ScriptedFaults,
};
use dyn_can::{Alarm, DriveId, FunctionCode};
use embedded_can::StandardId;

pub(crate) use script::{Script, ScriptError};

/// Something that goes wrong, or right again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// The drive goes into an alarm and says so, once or again and again.
    Alarm {
        drive: DriveId,
        alarm: Alarm,
        repeat_ns: Option<NonZeroU64>,
    },
    /// The drive hears and obeys, but sends nothing.
    Silence { drive: DriveId },
    /// The end of a silence.
    Wake { drive: DriveId },
    /// The drive is pulled off the bus; what moves goes on.
    Unplug { drive: DriveId },
    /// The drive is back on the bus.
    PlugIn { drive: DriveId },
    /// The power of the drive fails and comes back.
    PowerCycle { drive: DriveId, off_ns: u64 },
    /// The servo goes off by itself.
    Disable { drive: DriveId },
    /// The next replies are not sent.
    DropReplies { drive: DriveId, count: u32 },
    /// The next reply takes longer.
    DelayReply { drive: DriveId, by_ns: u64 },
    /// An error in the last bit of EOF: the drive gets the next set-points twice.
    RepeatSetPoint { drive: DriveId, count: u32 },
    /// The drive loses the next set-points, although it acknowledged them.
    LoseSetPoint { drive: DriveId, count: u32 },
    /// The next frames, whoever sends them, are destroyed by a bit error and repeated.
    Corrupt { frames: u32, at_bit: u32 },
    /// Nobody can start a frame.
    Block { for_ns: u64 },
    /// Every frame is destroyed: senders go towards bus-off.
    Disturb { for_ns: u64 },
    /// The application does nothing at all for so many cycles.
    MissCycles { cycles: u32 },
}

/// What a fault acts on.
pub(crate) struct Rig<'a> {
    pub(crate) bench: &'a mut Bench<DynDrive, ScriptedFaults>,
    pub(crate) master: NodeId,
    /// Drive and device of each axis.
    pub(crate) drives: &'a [DriveId],
    pub(crate) devices: &'a [DeviceId],
}

impl Fault {
    /// The drive concerned; `None` when it is the bus or the application.
    pub(crate) const fn drive(self) -> Option<DriveId> {
        match self {
            Self::Alarm { drive, .. }
            | Self::Silence { drive }
            | Self::Wake { drive }
            | Self::Unplug { drive }
            | Self::PlugIn { drive }
            | Self::PowerCycle { drive, .. }
            | Self::Disable { drive }
            | Self::DropReplies { drive, .. }
            | Self::DelayReply { drive, .. }
            | Self::RepeatSetPoint { drive, .. }
            | Self::LoseSetPoint { drive, .. } => Some(drive),
            Self::Corrupt { .. }
            | Self::Block { .. }
            | Self::Disturb { .. }
            | Self::MissCycles { .. } => None,
        }
    }

    /// Commands the fault, from this instant on. Missed cycles are up to who runs the cycles.
    pub(crate) fn apply(self, rig: &mut Rig<'_>) {
        let place = self
            .drive()
            .and_then(|drive| rig.drives.iter().position(|other| *other == drive));
        match place.and_then(|place| rig.devices.get(place)) {
            Some(&device) => self.apply_to_drive(rig, device),
            None => self.apply_to_bus(rig),
        }
    }

    fn apply_to_drive(self, rig: &mut Rig<'_>, device: DeviceId) {
        let node = rig.bench.node_of(device);
        let faults = rig.bench.device_mut(device).faults_mut();
        match self {
            Self::Alarm {
                alarm, repeat_ns, ..
            } => {
                faults.repeat_alarm_frames(repeat_ns);
                faults.raise_alarm(alarm);
            }
            Self::Silence { .. } => faults.fall_silent(),
            Self::Wake { .. } => faults.wake(),
            Self::Unplug { .. } => rig.bench.bus_mut().set_connected(node, false),
            Self::PlugIn { .. } => rig.bench.bus_mut().set_connected(node, true),
            Self::PowerCycle { off_ns, .. } => faults.power_cycle(off_ns),
            Self::Disable { .. } => faults.disable_itself(),
            Self::DropReplies { count, .. } => faults.drop_next_replies(u64::from(count)),
            Self::DelayReply { by_ns, .. } => faults.delay_next_reply(by_ns),
            Self::RepeatSetPoint { drive, count } => {
                let which = FrameMatch {
                    sender: Some(rig.master),
                    ..set_points_of(drive)
                };
                rig.bench
                    .bus_mut()
                    .faults_mut()
                    .duplicate_next(which, count);
            }
            Self::LoseSetPoint { drive, count } => {
                let script = rig.bench.bus_mut().faults_mut();
                script.drop_next(node, set_points_of(drive), count);
            }
            Self::Corrupt { .. }
            | Self::Block { .. }
            | Self::Disturb { .. }
            | Self::MissCycles { .. } => {}
        }
    }

    fn apply_to_bus(self, rig: &mut Rig<'_>) {
        let from_ns = rig.bench.now_ns();
        let bus = rig.bench.bus_mut();
        let (kind, for_ns) = match self {
            Self::Corrupt { frames, at_bit } => {
                bus.faults_mut()
                    .corrupt_next(FrameMatch::ANY, frames, at_bit);
                return;
            }
            Self::Block { for_ns } => (OutageKind::Blocked, for_ns),
            Self::Disturb { for_ns } => (OutageKind::Disturbed, for_ns),
            _ => return,
        };
        let outage = Outage {
            kind,
            from_ns,
            until_ns: from_ns.saturating_add(for_ns),
        };
        // An outage of no time is no outage.
        let _ = bus.add_outage(outage);
    }
}

fn set_points_of(drive: DriveId) -> FrameMatch {
    let id = drive.can_id(FunctionCode::GoRelativePosPd);
    // 6 bits of id and 5 bits of function make 11 bits.
    FrameMatch::with_id(StandardId::new(id).unwrap_or(StandardId::ZERO))
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |ns: u64| ns as f64 * 1e-6;
        match *self {
            Self::Alarm { drive, alarm, .. } => write!(f, "drive {drive} goes into alarm: {alarm}"),
            Self::Silence { drive } => write!(f, "drive {drive} falls silent"),
            Self::Wake { drive } => write!(f, "drive {drive} answers again"),
            Self::Unplug { drive } => write!(f, "drive {drive} is pulled off the bus"),
            Self::PlugIn { drive } => write!(f, "drive {drive} is back on the bus"),
            Self::PowerCycle { drive, off_ns } => {
                write!(f, "drive {drive} loses its power for {} ms", ms(off_ns))
            }
            Self::Disable { drive } => write!(f, "drive {drive} disables itself"),
            Self::DropReplies { drive, count } => {
                write!(
                    f,
                    "drive {drive} does not send its next {}",
                    counted(count, "reply", "replies")
                )
            }
            Self::DelayReply { drive, by_ns } => {
                write!(
                    f,
                    "drive {drive} sends its next reply {} ms later",
                    ms(by_ns)
                )
            }
            Self::RepeatSetPoint { drive, count } => {
                write!(
                    f,
                    "drive {drive} gets its next {} twice",
                    counted(count, "set-point", "set-points")
                )
            }
            Self::LoseSetPoint { drive, count } => {
                write!(
                    f,
                    "drive {drive} loses its next {}",
                    counted(count, "set-point", "set-points")
                )
            }
            Self::Corrupt { frames, at_bit } => {
                write!(
                    f,
                    "bit {at_bit} of the next {} is wrong",
                    counted(frames, "frame", "frames")
                )
            }
            Self::Block { for_ns } => write!(f, "the bus is blocked for {} ms", ms(for_ns)),
            Self::Disturb { for_ns } => write!(f, "the bus is disturbed for {} ms", ms(for_ns)),
            Self::MissCycles { cycles } => write!(
                f,
                "the application misses {}",
                counted(cycles, "cycle", "cycles")
            ),
        }
    }
}
