//! Events of the master of wheels in plain words.

use can_motion::wheel::WheelEventKind;

use crate::counted::counted;
use crate::recording::{Kind, error_words, reason_words};

/// An event and its kind.
pub(super) fn words(event: WheelEventKind) -> (Kind, String) {
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
        E::Arrived { counts } => format!("the wheel arrived at {counts} counts"),
        E::NotArrived { off_counts } => {
            format!("the wheel is {off_counts} counts away from its target")
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
