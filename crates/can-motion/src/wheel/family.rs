//! The family of ZLAC8030L drives: what only a master of wheels has.

use core::fmt;

use zlac8030l::{
    CanopenFrame, DataFrame, FrameError, NmtRequest, NodeId, SdoRequest, Service, Sync, objects,
};

use crate::core::family::{Family, ProcedureRefusal};
use crate::core::master::Master;
use crate::core::placement::BehindFrames;
use crate::core::state::AxisState;
use crate::wheel::config::{FeedbackTiming, WheelConfig, WheelConfigError, WheelMasterConfig};
use crate::wheel::drive::Wheel;
use crate::wheel::event::WheelEventKind;
use crate::wheel::fault::WheelFault;
use crate::wheel::feedback::WheelSnapshot;
use crate::wheel::frames::WheelRequest;
use crate::wheel::plan::WheelPlan;

/// ZLAC8030L hub-motor drives: each cycle a PDO with control word and target for each drive that is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Zlac;

/// A master of at most `N` wheels.
pub type WheelMaster<const N: usize> = Master<N, Zlac>;

impl Family for Zlac {
    type Frame = DataFrame;
    type Config = WheelMasterConfig;
    type AxisConfig = WheelConfig;
    type ConfigError = WheelConfigError;
    type Plan<'a> = WheelPlan<'a>;
    type Placement = BehindFrames;
    type Drive = Wheel;
    type Request = WheelRequest;
    type Procedure = SdoRequest;
    type ProcedureError = TransferError;
    type Fault = WheelFault;
    type EventKind = WheelEventKind;
    type Snapshot = WheelSnapshot;

    const HAS_CYCLE_FRAMES: bool = true;

    fn plan<'a>(config: &WheelMasterConfig, axes: &'a [WheelConfig]) -> WheelPlan<'a> {
        WheelPlan::new(config, axes)
    }

    fn address_of(axis: &WheelConfig) -> u8 {
        axis.node.get()
    }

    fn drive(config: &WheelMasterConfig, axis: &WheelConfig, _: u32) -> Wheel {
        Wheel::new(*axis, config)
    }

    fn frame_of_bus(config: &WheelMasterConfig) -> Option<DataFrame> {
        (config.feedback == FeedbackTiming::Sync).then(|| Sync.encode())
    }

    fn address(frame: &DataFrame) -> Option<u8> {
        let node = match frame.service().ok()? {
            Service::Sync => return None,
            Service::Nmt => NmtRequest::decode(frame).ok()?.node?,
            Service::Emcy(node)
            | Service::Tpdo(_, node)
            | Service::Rpdo(_, node)
            | Service::SdoReply(node)
            | Service::SdoRequest(node)
            | Service::Heartbeat(node) => node,
        };
        Some(node.get())
    }

    fn foreign(frame: &DataFrame) -> Option<WheelEventKind> {
        Some(WheelEventKind::ForeignFrame { id: frame.id() })
    }

    fn not_ours(error: FrameError) -> Option<WheelEventKind> {
        Some(WheelEventKind::NotOurs(error))
    }
}

/// A transfer that was not started; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TransferError {
    /// There is no such wheel.
    NoSuchAxis {
        /// The wheel asked for.
        actual: usize,
    },
    /// The drive is not known yet or lost; or it is to be written to, and is not [`AxisState::Ready`].
    State {
        /// The state of the wheel.
        actual: AxisState,
    },
    /// Another transfer waits: wait for its event.
    Busy,
    /// The master itself writes this object; a second writer could move the wheel.
    Owned {
        /// The object.
        node: NodeId,
    },
    /// Saving and restoring parameters (2009h) wears the drive: it needs [`Confirmation::Given`](crate::Confirmation::Given).
    Unconfirmed,
}

impl From<ProcedureRefusal> for TransferError {
    fn from(refusal: ProcedureRefusal) -> Self {
        match refusal {
            ProcedureRefusal::NoSuchAxis { actual } => Self::NoSuchAxis { actual },
            ProcedureRefusal::Busy => Self::Busy,
            ProcedureRefusal::State { actual } => Self::State { actual },
        }
    }
}

impl fmt::Display for TransferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchAxis { actual } => write!(f, "there is no wheel {actual}"),
            Self::State { actual } => write!(
                f,
                "the wheel is {actual}: reading needs a drive that answers, writing one that is ready and not enabled"
            ),
            Self::Busy => f.write_str("another transfer of this wheel waits: wait for its event"),
            Self::Owned { node } => write!(
                f,
                "the master writes this object of node {node} itself: use set_target, enable, disable"
            ),
            Self::Unconfirmed => {
                f.write_str("saving parameters wears the drive: it needs a confirmation")
            }
        }
    }
}

impl core::error::Error for TransferError {}

/// What the master writes: control word, mode, targets, PDO parameters, supervision, and what its stops rely on.
pub(super) fn is_owned(request: &SdoRequest) -> bool {
    let address = request.address();
    let written = matches!(request, SdoRequest::Write(..));
    let owned = [
        objects::CONTROL_WORD.address(),
        objects::MODE.address(),
        objects::TARGET_SPEED.address(),
        objects::TARGET_POSITION.address(),
        objects::TARGET_TORQUE.address(),
        objects::PRODUCER_HEARTBEAT_MS.address(),
        objects::OFFLINE_TIME_MS.address(),
        objects::EEPROM_UPDATE.address(),
        objects::QUICK_STOP_OPTION.address(),
        objects::SHUTDOWN_OPTION.address(),
        objects::DISABLE_OPTION.address(),
        objects::HALT_OPTION.address(),
        objects::EMERGENCY_DECELERATION_TIME_MS.address(),
        objects::ROTATION.address(),
        objects::HOLDING_BRAKE.address(),
    ];
    let is_pdo = matches!(
        address.index,
        0x1400..=0x1403 | 0x1600..=0x1603 | 0x1800..=0x1803 | 0x1A00..=0x1A03
    );
    written && (is_pdo || owned.contains(&address))
}
