//! What happened to wheels, for the application to read.

use bus_user::BusErrorKind;
use zlac8030l::{DecodeError, Emcy, FrameError, NmtState, SdoEvent, SdoIgnored, SetUpReport};

use crate::core::event::{CommonEvent, EventLog};
use crate::core::state::{AxisState, Reason};
use crate::wheel::fault::WheelFault;

/// Where a wheel writes its events.
pub(super) type Log<'a> = EventLog<'a, WheelEventKind>;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WheelEventKind {
    /// The wheel went from one state to another.
    State {
        /// The state that it left.
        from: AxisState,
        /// The state that it entered.
        to: AxisState,
        /// Why.
        reason: Reason,
    },
    /// A fault was latched.
    Fault(WheelFault),
    /// The drive reports power that this master did not switch on. It is left alone until `disable` or `adopt`.
    FoundOn,
    /// The drive did not confirm the disable command, or it could not be sent in time; it is repeated. Reported at the first, second, fourth, eighth ... repetition.
    DisableUnconfirmed {
        /// Repetitions so far.
        repeated: u32,
    },
    /// A fault of the drive, or `clear` behind one, ended the procedure.
    ProcedureAborted,
    /// The drive is set up: what was found right and what was written.
    SetUp(SetUpReport),
    /// The drive announced a state of NMT; boot-up included.
    Nmt(NmtState),
    /// An emergency message with error code 0: an error is gone.
    EmergencyOver(Emcy),
    /// A transfer of the application ended.
    Transfer(SdoEvent),
    /// A transfer that a state needs had no answer in time.
    TransferTimeout(SdoEvent),
    /// An SDO reply was not believed.
    ReplyIgnored(SdoIgnored),
    /// A frame of the drive does not decode.
    BadFrame(DecodeError),
    /// A wheel in position mode stands where its latest target is.
    Arrived {
        /// Its position.
        counts: i32,
    },
    /// A wheel in position mode does not stand where its latest target is, and its time is over. It goes on trying.
    NotArrived {
        /// How far it is from its target: position minus target.
        off_counts: i32,
    },
    /// The target of the cycle before did not reach the controller in time.
    TargetMerged,
    /// The controller gave back a target unsent; it is sent again.
    TargetDisplaced,
    /// The controller gave back an SDO or NMT frame unsent; it is sent again.
    RequestDisplaced,
    /// A frame of no wheel of this master, or one that only a master sends.
    ForeignFrame {
        /// Its identifier.
        id: u16,
    },
    /// A frame that CANopen does not have.
    NotOurs(FrameError),
    /// The time from one cycle to the next was longer than planned by so many cycles.
    CyclesMissed(u32),
    /// The controller reports a transmit or receive error.
    BusError(BusErrorKind),
    /// The controller is bus-off.
    BusOff,
    /// The controller takes part in the bus again.
    BusRecovered,
}

impl From<CommonEvent<WheelFault>> for WheelEventKind {
    fn from(event: CommonEvent<WheelFault>) -> Self {
        match event {
            CommonEvent::State { from, to, reason } => Self::State { from, to, reason },
            CommonEvent::Fault(fault) => Self::Fault(fault),
            CommonEvent::FoundOn => Self::FoundOn,
            CommonEvent::DisableUnconfirmed { repeated } => Self::DisableUnconfirmed { repeated },
            CommonEvent::SetPointMerged => Self::TargetMerged,
            CommonEvent::CyclesMissed(cycles) => Self::CyclesMissed(cycles),
            CommonEvent::BusError(kind) => Self::BusError(kind),
            CommonEvent::BusOff => Self::BusOff,
            CommonEvent::BusRecovered => Self::BusRecovered,
        }
    }
}
