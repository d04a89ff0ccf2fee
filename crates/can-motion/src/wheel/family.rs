//! The family of ZLAC8030L drives: what only a master of wheels has.

use zlac8030l::{CanopenFrame, DataFrame, FrameError, NmtRequest, SdoRequest, Service, Sync};

use crate::core::family::Family;
use crate::core::master::Master;
use crate::core::placement::BehindFrames;
use crate::wheel::config::{FeedbackTiming, WheelConfig, WheelConfigError, WheelMasterConfig};
use crate::wheel::drive::Wheel;
use crate::wheel::event::WheelEventKind;
use crate::wheel::fault::WheelFault;
use crate::wheel::feedback::WheelSnapshot;
use crate::wheel::plan::WheelPlan;
use crate::wheel::request::WheelRequest;
use crate::wheel::transfer::TransferError;
use crate::wheel::zlac_family::Zlac;

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
