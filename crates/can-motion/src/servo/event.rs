//! What happened to servo drives and their bus, for the application to read.

use bus_plan::Warning;
use bus_user::BusErrorKind;
use dyn_can::{DecodeError, FrameError, FunctionCode, ReplyKind, Revision};

use crate::core::event::{CommonEvent, EventLog};
use crate::core::state::{AxisState, Reason};
use crate::servo::fault::Fault;
#[cfg(feature = "procedures")]
use crate::servo::procedure::ProcedureEnd;

/// Where a servo writes its events.
pub(super) type Log<'a> = EventLog<'a, EventKind>;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EventKind {
    /// The axis went from one state to another.
    State {
        /// The state that it left.
        from: AxisState,
        /// The state that it entered.
        to: AxisState,
        /// Why.
        reason: Reason,
    },
    /// A fault was latched.
    Fault(Fault),
    /// The drive reports power that this master did not switch on. It is left alone until `disable` or `adopt`.
    FoundOn,
    /// The drive did not confirm the disable command, or it could not be sent in time; it is repeated. Reported at the first, second, fourth, eighth ... repetition, up to 2^15.
    DisableUnconfirmed {
        /// Repetitions so far.
        repeated: u32,
    },
    /// The plan of the bus was admitted, but there is something to know about it.
    Plan(Warning),
    /// The drive's revision was recognised.
    Revision(Revision),
    /// The set-point of the cycle before did not reach the controller in time; what it should have carried is caught up.
    SetPointMerged,
    /// The controller gave back a set-point unsent; its step is owed again.
    SetPointDisplaced,
    /// The controller gave back a request unsent; it is asked again.
    RequestDisplaced(ReplyKind),
    /// A procedure ended.
    #[cfg(feature = "procedures")]
    Procedure(ProcedureEnd),
    /// The reply did not come in time.
    ReplyTimeout(ReplyKind),
    /// A reply came too late or twice, and was dropped.
    LateReply(FunctionCode),
    /// A reply that nobody asked for was dropped: is there a second master on the bus?
    StrayReply(FunctionCode),
    /// A reply does not decode.
    BadReply(DecodeError),
    /// A frame of a drive that is in no axis, or one given back that does not decode, was ignored.
    ForeignFrame {
        /// Its identifier.
        id: u16,
    },
    /// A frame that no drive of this family sends, or one that the controller gave back, was ignored.
    NotOurs(FrameError),
    /// The time from one cycle to the next was longer than planned by so many cycles.
    CyclesMissed(u32),
    /// The controller reports a transmit or receive error.
    BusError(BusErrorKind),
    /// The controller is bus-off: nothing is sent until it is recovered and the axes are cleared.
    BusOff,
    /// The controller takes part in the bus again.
    BusRecovered,
}

impl From<CommonEvent<Fault>> for EventKind {
    fn from(event: CommonEvent<Fault>) -> Self {
        match event {
            CommonEvent::State { from, to, reason } => Self::State { from, to, reason },
            CommonEvent::Fault(fault) => Self::Fault(fault),
            CommonEvent::FoundOn => Self::FoundOn,
            CommonEvent::DisableUnconfirmed { repeated } => Self::DisableUnconfirmed { repeated },
            CommonEvent::SetPointMerged => Self::SetPointMerged,
            CommonEvent::CyclesMissed(cycles) => Self::CyclesMissed(cycles),
            CommonEvent::BusError(kind) => Self::BusError(kind),
            CommonEvent::BusOff => Self::BusOff,
            CommonEvent::BusRecovered => Self::BusRecovered,
        }
    }
}
