//! Events of the master of wheels in plain words.

use can_motion::wheel::WheelEventKind;

use super::event::Kind;
use super::words::{error_words, reason_words};
use crate::counted::counted;

/// An event and its kind.
pub(crate) fn wheel_words(event: WheelEventKind) -> (Kind, String) {
    use WheelEventKind as E;
    let kind = match event {
        E::State { .. } => Kind::State,
        E::Fault(_) | E::BusOff => Kind::Fault,
        _ => Kind::Notice,
    };
    let text = match event {
        E::State { from, to, reason } => format!("{from} -> {to} ({})", reason_words(reason)),
        E::Fault(fault) => fault.to_string(),
        E::FoundOn => "the drive is enabled, and this master did not enable it".to_owned(),
        E::DisableUnconfirmed { repeated } => format!(
            "the drive did not confirm that it is disabled; told again, {} so far",
            counted(repeated, "time", "times")
        ),
        E::ProcedureAborted => "a fault ended the procedure".to_owned(),
        E::SetUp(_) => "the drive is set up".to_owned(),
        E::Nmt(state) => format!("the drive announces that it is {state}"),
        E::EmergencyOver(_) => "the drive reports that an error is gone".to_owned(),
        E::Transfer(transfer) => format!("{}: {}", transfer.request, transfer.end),
        E::TransferTimeout(transfer) => format!("no reply to this request: {}", transfer.request),
        E::ReplyIgnored(_) => "an SDO reply was dropped: nothing that was asked for".to_owned(),
        E::BadFrame(error) => format!("a frame of the drive does not decode: {error}"),
        E::Arrived { counts } => format!("the wheel arrived; its position in counts is {counts}"),
        E::NotArrived { off_counts } => {
            format!("the wheel did not arrive; position minus target in counts is {off_counts}")
        }
        E::TargetMerged => "a target missed its cycle; the next one has gone".to_owned(),
        E::TargetDisplaced => {
            "the controller gave a target back unsent; it is sent again".to_owned()
        }
        E::RequestDisplaced => {
            "the controller gave a request back unsent; it is sent again".to_owned()
        }
        E::ForeignFrame { id } => {
            format!("a frame of no wheel of this motion, identifier 0x{id:03X}")
        }
        E::NotOurs(error) => format!("a frame that CANopen does not have: {error}"),
        E::CyclesMissed(missed) => format!("missed: {}", counted(missed, "cycle", "cycles")),
        E::BusError(kind) => format!("the controller reports {}", error_words(kind)),
        E::BusOff => "the controller of the master is bus-off".to_owned(),
        E::BusRecovered => "the controller is back on the bus".to_owned(),
        _ => "an event that this tool does not know".to_owned(),
    };
    (kind, text)
}

#[cfg(test)]
mod tests {
    use can_motion::wheel::WheelFault;
    use can_motion::{AxisState, BusErrorKind, Reason};
    use zlac8030l::{
        DecodeError, Emcy, FaultCode, FrameError, NmtState, ObjectAddress, SdoEnd, SdoEvent,
        SdoIgnored, SdoRequest, SetUpReport,
    };

    use super::*;
    use crate::plain_words::events_are_plain;

    fn every_event() -> [WheelEventKind; 23] {
        use WheelEventKind as E;
        let transfer = SdoEvent {
            request: SdoRequest::Read(ObjectAddress::new(0x603F, 0)),
            end: SdoEnd::TimedOut,
        };
        let over = Emcy {
            error_code: 0,
            error_register: 0,
            manufacturer: [0; 5],
        };
        [
            E::State {
                from: AxisState::Ready,
                to: AxisState::Streaming,
                reason: Reason::Command,
            },
            E::Fault(WheelFault::Drive(FaultCode::new(4))),
            E::FoundOn,
            E::DisableUnconfirmed { repeated: 1 },
            E::ProcedureAborted,
            E::SetUp(SetUpReport::default()),
            E::Nmt(NmtState::Operational),
            E::EmergencyOver(over),
            E::Transfer(transfer),
            E::TransferTimeout(transfer),
            E::ReplyIgnored(SdoIgnored::Foreign),
            E::BadFrame(DecodeError::Service { can_id: 0x7FF }),
            E::Arrived { counts: 1 },
            E::NotArrived { off_counts: -2 },
            E::TargetMerged,
            E::TargetDisplaced,
            E::RequestDisplaced,
            E::ForeignFrame { id: 0x123 },
            E::NotOurs(FrameError::Remote { id: 0x123 }),
            E::CyclesMissed(1),
            E::BusError(BusErrorKind::Stuff),
            E::BusOff,
            E::BusRecovered,
        ]
    }

    #[test]
    fn every_event_has_plain_words() {
        let source = include_str!("../../../can-motion/src/wheel/event.rs");
        events_are_plain((source, "WheelEventKind"), &every_event(), |event| {
            wheel_words(*event).1
        });
    }
}
