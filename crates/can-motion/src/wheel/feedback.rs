//! The latest feedback of a wheel, and the wheel at one moment.

use zlac8030l::{FaultCode, NmtState, NodeId, StatusWord};

use crate::core::facts::Facts;
use crate::core::family::GroupId;
use crate::core::snapshot::{Counters, Stamped};
use crate::core::state::AxisState;
use crate::wheel::fault::WheelFault;

/// The latest feedback; `None` before the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelFeedback {
    /// Status word 6041h.
    pub status: Option<Stamped<StatusWord>>,
    /// Fault bits 603Fh, with the status.
    pub fault_code: Option<Stamped<FaultCode>>,
    /// Speed 606Ch in 0.1 r/min, with the status.
    pub speed_decirpm: Option<Stamped<i32>>,
    /// Position 6064h in counts.
    pub position_counts: Option<Stamped<i32>>,
    /// Torque 6077h as the drive counts it: 0.1 A by the text, mA by the printed range (Z25). With the position.
    pub torque: Option<Stamped<i16>>,
    /// Temperature of the motor 2026h:01 in 0.1 degC (Z6, Z7), by [`WheelPolls`](crate::wheel::WheelPolls).
    pub motor_decidegrees: Option<Stamped<i16>>,
    /// Temperature of the driver 2026h:02 in 0.1 degC (Z6, Z7), by [`WheelPolls`](crate::wheel::WheelPolls).
    pub driver_decidegrees: Option<Stamped<i16>>,
    /// Voltage of the supply 2029h in 0.01 V, by [`WheelPolls`](crate::wheel::WheelPolls).
    pub bus_centivolts: Option<Stamped<u16>>,
    /// State of NMT by the latest heartbeat.
    pub nmt: Option<Stamped<NmtState>>,
}

/// One wheel at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelSnapshot {
    /// The drive.
    pub node: NodeId,
    /// The group that it stops with.
    pub group: GroupId,
    /// Where the wheel is in its life: a view of the facts.
    pub state: AxisState,
    /// The facts.
    pub facts: Facts,
    /// The latched fault.
    pub fault: Option<WheelFault>,
    /// What the application wants: 1/n r/min or counts, by the mode.
    pub target: i32,
    /// What the latest accepted frame said, in the same unit.
    pub sent: i32,
    /// The latest feedback.
    pub feedback: WheelFeedback,
    /// What happened so far.
    pub counters: Counters,
}
