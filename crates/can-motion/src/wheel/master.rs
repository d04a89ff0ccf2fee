//! The family of ZLAC8030L drives: what only a master of wheels has.

use core::fmt;

use zlac8030l::{
    CanopenFrame, DataFrame, FrameError, NmtRequest, NodeId, SdoRequest, Service, Sync, objects,
};

use super::axis::Wheel;
use super::config::{FeedbackTiming, WheelConfig, WheelConfigError, WheelMasterConfig};
use super::event::WheelEventKind;
use super::fault::WheelFault;
use super::feedback::WheelSnapshot;
use super::send::WheelRequest;
use crate::command::TargetError;
use crate::family::{CycleConfig, Family};
use crate::life::AxisState;
use crate::master::Master;

/// ZLAC8030L hub-motor drives: each cycle a PDO with control word and target for each drive that is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Zlac;

/// A master of at most `N` wheels.
pub type WheelMaster<const N: usize> = Master<N, Zlac>;

impl Family for Zlac {
    type Frame = DataFrame;
    type Config = WheelMasterConfig;
    type Axis = Wheel;
    type SetPoint = i32;
    type Request = WheelRequest;
    type Fault = WheelFault;
    type EventKind = WheelEventKind;
    type Snapshot = WheelSnapshot;

    const STOPS_BY_FRAME: bool = true;

    fn cycle_frame(config: &WheelMasterConfig) -> Option<DataFrame> {
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

    fn foreign(frame: &DataFrame) -> WheelEventKind {
        WheelEventKind::ForeignFrame { id: frame.id() }
    }

    fn not_ours(error: FrameError) -> WheelEventKind {
        WheelEventKind::NotOurs(error)
    }
}

impl CycleConfig for WheelMasterConfig {
    fn cycle_us(&self) -> u32 {
        self.cycle_us
    }

    fn requests_per_cycle(&self) -> u8 {
        self.requests_per_cycle
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
    /// The drive is not known yet, or lost.
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
    /// Saving and restoring parameters (2009h) needs a wheel that is not enabled.
    Enabled,
}

impl fmt::Display for TransferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchAxis { actual } => write!(f, "there is no wheel {actual}"),
            Self::State { actual } => write!(f, "the wheel is {actual}: wait until it is ready"),
            Self::Busy => f.write_str("another transfer of this wheel waits: wait for its event"),
            Self::Owned { node } => write!(
                f,
                "the master writes this object of node {node} itself: use set_target, enable, disable"
            ),
            Self::Enabled => f.write_str("disable the wheel before its parameters are saved"),
        }
    }
}

impl core::error::Error for TransferError {}

/// What the master writes: control word, mode, targets, PDO parameters, supervision.
fn is_owned(request: &SdoRequest) -> bool {
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
    ];
    let is_pdo = matches!(
        address.index,
        0x1400..=0x1403 | 0x1600..=0x1603 | 0x1800..=0x1803 | 0x1A00..=0x1A03
    );
    written && (is_pdo || owned.contains(&address))
}

impl<const N: usize> Master<N, Zlac> {
    /// A master for these wheels, in ascending order of node.
    ///
    /// # Errors
    /// [`WheelConfigError`] when the configuration cannot work.
    pub fn wheels(
        config: WheelMasterConfig,
        wheels: &[WheelConfig],
    ) -> Result<Self, WheelConfigError> {
        config.validate(wheels, N)?;
        let mut master = Self::empty(config);
        for wheel in wheels {
            master.add(wheel.node.get(), Wheel::new(*wheel, &config));
        }
        Ok(master)
    }

    /// Sets the target of a wheel: a speed in 1/n r/min, or an absolute position in counts, by its mode.
    ///
    /// # Errors
    /// [`TargetError`] when the wheel does not stream or the target leaves its range; nothing changes then.
    pub fn set_target(&mut self, axis: usize, target: i32) -> Result<(), TargetError> {
        let Some(wheel) = self.axes.get_mut(axis) else {
            return Err(TargetError::NoSuchAxis {
                axes: N,
                actual: axis,
            });
        };
        if wheel.state != AxisState::Streaming {
            return Err(TargetError::NotStreaming { state: wheel.state });
        }
        let (min, max) = (wheel.config.limits.min, wheel.config.limits.max);
        if target < min || target > max {
            return Err(TargetError::Travel {
                min,
                max,
                actual: target,
            });
        }
        wheel.books.set_target(target);
        Ok(())
    }

    /// Reads or writes an object beside the cycle; its end is an event. Since 2010h is 1, a write does not wear the drive.
    ///
    /// # Errors
    /// [`TransferError`] when it may not run now; nothing changes then.
    pub fn transfer(&mut self, axis: usize, request: SdoRequest) -> Result<(), TransferError> {
        let place = self.axes.get_mut(axis);
        let wheel = place.ok_or(TransferError::NoSuchAxis { actual: axis })?;
        if !wheel.state.may_poll() || wheel.is_lost() {
            return Err(TransferError::State {
                actual: wheel.state,
            });
        }
        if is_owned(&request) {
            return Err(TransferError::Owned {
                node: wheel.config.node,
            });
        }
        let stores = request.address() == objects::STORE.address();
        if stores && (wheel.may_be_enabled || wheel.state.is_enabled()) {
            return Err(TransferError::Enabled);
        }
        if wheel.wanted.is_some() {
            return Err(TransferError::Busy);
        }
        wheel.wanted = Some(request);
        Ok(())
    }
}
