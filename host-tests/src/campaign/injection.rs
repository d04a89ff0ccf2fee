//! Faults that a scenario injects, each at an instant.

use core::fmt;
use core::num::NonZeroU64;

use drive_sim::{
    Bench, DeviceId, DynDrive, FrameMatch, NodeId, Outage, OutageKind, ScriptedFaults,
};
use dyn_can::{Alarm, DriveId, FunctionCode};
use embedded_can::StandardId;

/// A fault at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Injection {
    /// When, in microseconds.
    pub at_us: u64,
    /// What.
    pub kind: Kind,
}

/// A fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The drive goes into an alarm and says so, once or with this period.
    Alarm {
        /// The axis.
        axis: usize,
        /// Period of the alarm frames.
        repeat_us: Option<NonZeroU64>,
    },
    /// The drive sends nothing.
    Silence {
        /// The axis.
        axis: usize,
        /// It hears nothing either.
        deaf: bool,
        /// For how long; for ever if `None`.
        for_us: Option<u64>,
    },
    /// The next reply is not sent.
    DropReply {
        /// The axis.
        axis: usize,
    },
    /// The next reply is late.
    DelayReply {
        /// The axis.
        axis: usize,
        /// By how much.
        by_us: u64,
    },
    /// The next reply is sent twice.
    DoubleReply {
        /// The axis.
        axis: usize,
    },
    /// The next reply lacks its last byte.
    ShortReply {
        /// The axis.
        axis: usize,
    },
    /// The next reply has a byte too many.
    LongReply {
        /// The axis.
        axis: usize,
    },
    /// The servo goes off by itself.
    DisableItself {
        /// The axis.
        axis: usize,
    },
    /// The power of the drive fails.
    PowerCycle {
        /// The axis.
        axis: usize,
        /// For how long.
        off_us: u64,
    },
    /// The next frames on the bus, whoever sends them, are destroyed by a bit error and repeated.
    Corrupt {
        /// How many.
        frames: u32,
        /// Where.
        at_bit: u32,
    },
    /// The next set-point of the axis has an error in the last bit of EOF: the drive gets it twice.
    RepeatSetPoint {
        /// The axis.
        axis: usize,
    },
    /// The same for the next reply of the axis with this function.
    RepeatReply {
        /// The axis.
        axis: usize,
        /// The function.
        function: FunctionCode,
    },
    /// The same for the next request to the axis with this function.
    RepeatRequest {
        /// The axis.
        axis: usize,
        /// The function.
        function: FunctionCode,
    },
    /// The drive loses the next set-point of the axis although it acknowledged it.
    LoseSetPoint {
        /// The axis.
        axis: usize,
    },
    /// The master's controller loses the next reply of the axis with this function.
    LoseReply {
        /// The axis.
        axis: usize,
        /// The function.
        function: FunctionCode,
    },
    /// Nobody can start a frame.
    Block {
        /// For how long.
        for_us: u64,
    },
    /// Every drive is off the bus, as with a plug that was pulled out: nobody acknowledges.
    Unplug {
        /// For how long.
        for_us: u64,
    },
    /// Every frame is destroyed, until the master is bus-off.
    Disturb {
        /// For how long.
        for_us: u64,
    },
    /// The application does nothing at all for so many cycles.
    MissCycles {
        /// How many.
        cycles: u64,
    },
    /// When the master next asks the drive for a position or torque, the drive sends a frame of another length with the same
    /// identifier at the same instant.
    Collide {
        /// The axis.
        axis: usize,
    },
}

/// What an injection acts on.
pub(super) struct Rig<'a> {
    pub(super) bench: &'a mut Bench<DynDrive, ScriptedFaults>,
    pub(super) master: NodeId,
    pub(super) devices: &'a [DeviceId],
    pub(super) drives: &'a [DriveId],
}

impl Kind {
    /// The axis concerned; `None` when it is the whole bus.
    pub fn axis(self) -> Option<usize> {
        match self {
            Self::Alarm { axis, .. }
            | Self::Silence { axis, .. }
            | Self::DropReply { axis }
            | Self::DelayReply { axis, .. }
            | Self::DoubleReply { axis }
            | Self::ShortReply { axis }
            | Self::LongReply { axis }
            | Self::DisableItself { axis }
            | Self::PowerCycle { axis, .. }
            | Self::RepeatSetPoint { axis }
            | Self::RepeatReply { axis, .. }
            | Self::RepeatRequest { axis, .. }
            | Self::LoseSetPoint { axis }
            | Self::LoseReply { axis, .. }
            | Self::Collide { axis } => Some(axis),
            Self::Corrupt { .. }
            | Self::Block { .. }
            | Self::Unplug { .. }
            | Self::Disturb { .. }
            | Self::MissCycles { .. } => None,
        }
    }

    /// How long drives are off the bus by it; `u64::MAX` until somebody repairs them.
    pub(super) fn absence_us(self) -> Option<u64> {
        match self {
            Self::Silence { for_us, .. } => Some(for_us.unwrap_or(u64::MAX)),
            Self::Unplug { for_us } => Some(for_us),
            _ => None,
        }
    }

    /// Whether both keep the same drives off the bus: the first that ends does not bring them back.
    pub(super) fn absents_the_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Silence { axis, .. }, Self::Silence { axis: of, .. }) => axis == of,
            (Self::Unplug { .. }, Self::Unplug { .. }) => true,
            _ => false,
        }
    }

    /// How long no frame of the master gets through by it.
    pub(super) fn outage_us(self) -> u64 {
        match self {
            Self::Block { for_us } | Self::Unplug { for_us } => for_us,
            _ => 0,
        }
    }

    /// Whether the drive may ignore or not hear set-points from now on, without a frame on the bus that shows it.
    pub(super) fn makes_drive_ignore(self) -> bool {
        matches!(
            self,
            Self::Alarm { .. }
                | Self::Silence { deaf: true, .. }
                | Self::DisableItself { .. }
                | Self::PowerCycle { .. }
        )
    }

    /// The absence is over.
    pub(super) fn end(self, rig: &mut Rig<'_>) {
        match self {
            Self::Silence { axis, .. } => {
                rig.bench.device_mut(rig.devices[axis]).faults_mut().wake()
            }
            Self::Unplug { .. } => plug(rig.bench, rig.devices, true),
            _ => {}
        }
    }

    /// Commands the fault. Missed cycles and collisions are up to the runner.
    pub(super) fn apply(self, rig: &mut Rig<'_>) {
        if let Some(axis) = self.axis() {
            self.apply_to_drive(rig.bench.device_mut(rig.devices[axis]));
            self.apply_to_frames(rig, axis);
        } else {
            self.apply_to_bus(rig);
        }
    }

    fn apply_to_drive(self, drive: &mut DynDrive) {
        let faults = drive.faults_mut();
        match self {
            Self::Alarm { repeat_us, .. } => {
                faults.repeat_alarm_frames(repeat_us.map(|us| us.saturating_mul(THOUSAND)));
                faults.raise_alarm(Alarm::OverCurrent);
            }
            Self::Silence { deaf: true, .. } => faults.leave_bus(),
            Self::Silence { deaf: false, .. } => faults.fall_silent(),
            Self::DropReply { .. } => faults.drop_next_replies(1),
            Self::DelayReply { by_us, .. } => faults.delay_next_reply(by_us * 1_000),
            Self::DoubleReply { .. } => faults.duplicate_next_reply(),
            Self::ShortReply { .. } => faults.truncate_next_reply(),
            Self::LongReply { .. } => faults.lengthen_next_reply(),
            Self::DisableItself { .. } => faults.disable_itself(),
            Self::PowerCycle { off_us, .. } => faults.power_cycle(off_us * 1_000),
            _ => {}
        }
    }

    fn apply_to_frames(self, rig: &mut Rig<'_>, axis: usize) {
        let node = rig.bench.node_of(rig.devices[axis]);
        let (drive, master) = (rig.drives[axis], rig.master);
        let which = |sender, function| FrameMatch {
            sender: Some(sender),
            ..FrameMatch::with_id(id_of(drive, function))
        };
        let faults = rig.bench.bus_mut().faults_mut();
        match self {
            Self::RepeatSetPoint { .. } => {
                faults.duplicate_next(which(master, FunctionCode::GoRelativePosPd), 1);
            }
            Self::RepeatReply { function, .. } => faults.duplicate_next(which(node, function), 1),
            Self::RepeatRequest { function, .. } => {
                faults.duplicate_next(which(master, function), 1);
            }
            Self::LoseSetPoint { .. } => {
                faults.drop_next(node, which(master, FunctionCode::GoRelativePosPd), 1);
            }
            Self::LoseReply { function, .. } => {
                faults.drop_next(master, which(node, function), 1);
            }
            _ => {}
        }
    }

    fn apply_to_bus(self, rig: &mut Rig<'_>) {
        let from_ns = rig.bench.now_ns();
        let outage = |kind, for_us: u64| Outage {
            kind,
            from_ns,
            until_ns: from_ns + for_us * 1_000,
        };
        let outage = match self {
            Self::Corrupt { frames, at_bit } => {
                let faults = rig.bench.bus_mut().faults_mut();
                faults.corrupt_next(FrameMatch::ANY, frames, at_bit);
                return;
            }
            Self::Unplug { .. } => {
                plug(rig.bench, rig.devices, false);
                return;
            }
            Self::Block { for_us } => outage(OutageKind::Blocked, for_us),
            Self::Disturb { for_us } => outage(OutageKind::Disturbed, for_us),
            _ => return,
        };
        let bus = rig.bench.bus_mut();
        bus.add_outage(outage)
            .expect("the generator draws no outage of length 0");
    }
}

fn plug(bench: &mut Bench<DynDrive, ScriptedFaults>, devices: &[DeviceId], is_in: bool) {
    for &device in devices {
        let node = bench.node_of(device);
        bench.bus_mut().set_connected(node, is_in);
    }
}

const THOUSAND: NonZeroU64 = NonZeroU64::new(1_000).expect("1000 is not 0");

/// The identifier of a function of a drive.
pub(super) fn id_of(drive: DriveId, function: FunctionCode) -> StandardId {
    // 6 bits of id and 5 bits of function make 11 bits.
    StandardId::new(drive.can_id(function)).unwrap_or(StandardId::ZERO)
}

impl fmt::Display for Injection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} us: {:?}", self.at_us, self.kind)
    }
}
