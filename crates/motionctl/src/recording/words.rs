//! Events of the master in plain words.

use can_motion::{BusErrorKind, EventKind, ProcedureEnd, Reason};

use super::event::Kind;
use crate::counted::counted;

/// An event and its kind.
pub(crate) fn servo_words(event: EventKind) -> (Kind, String) {
    use EventKind as E;
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
        E::Plan(warning) => warning.to_string(),
        E::Revision(revision) => format!("the drive has revision {revision}"),
        E::SetPointMerged => "a set-point missed its cycle; its step is in the next".to_owned(),
        E::SetPointDisplaced => {
            "the controller gave a set-point back unsent; its step is owed again".to_owned()
        }
        E::RequestDisplaced(kind) => format!(
            "the controller gave {} back unsent; it is asked again",
            kind.function()
        ),
        E::Procedure(end) => procedure_words(end),
        E::ReplyTimeout(kind) => format!("no reply to {}", kind.function()),
        E::LateReply(function) => {
            format!("a reply to {function} came late or twice and was dropped")
        }
        E::StrayReply(function) => format!("nobody asked for this {function}"),
        E::BadReply(error) => format!("a reply does not decode: {error}"),
        E::ForeignFrame { id } => {
            format!("a frame of no drive of this motion, identifier 0x{id:03X}")
        }
        E::NotOurs(error) => format!("a frame that no drive sends: {error}"),
        E::CyclesMissed(missed) => format!("missed: {}", counted(missed, "cycle", "cycles")),
        E::BusError(kind) => format!("the controller reports {}", error_words(kind)),
        E::BusOff => "the controller of the master is bus-off".to_owned(),
        E::BusRecovered => "the controller is back on the bus".to_owned(),
        _ => "an event that this tool does not know".to_owned(),
    };
    (kind, text)
}

pub(super) const fn reason_words(reason: Reason) -> &'static str {
    match reason {
        Reason::Command => "command",
        Reason::Reading => "reading",
        Reason::Sent => "sent",
        Reason::Displaced => "displaced",
        Reason::Elapsed => "time is over",
        Reason::Standstill => "standstill",
        Reason::MoveEnded => "the motion of the drive itself ended",
        Reason::Group => "the group is ready",
        Reason::Fault => "fault",
    }
}

pub(super) const fn error_words(kind: BusErrorKind) -> &'static str {
    match kind {
        BusErrorKind::Overrun => "an overrun: replies were lost",
        BusErrorKind::Bit => "a bit error",
        BusErrorKind::Stuff => "a stuff error",
        BusErrorKind::Crc => "a checksum error",
        BusErrorKind::Form => "a form error",
        BusErrorKind::Acknowledge => "that nobody acknowledges",
        _ => "an error",
    }
}

fn procedure_words(end: ProcedureEnd) -> String {
    match end {
        ProcedureEnd::Read(reply) => format!("{} was read", reply.function()),
        ProcedureEnd::Unchanged => "the drive has these values already: nothing was written".into(),
        ProcedureEnd::Written => "written, and read back as written".into(),
        ProcedureEnd::Sent => "the command was sent".into(),
        ProcedureEnd::NotTaken(reply) => {
            format!("written, and {} reads back other values", reply.function())
        }
        ProcedureEnd::Refused => "the drive refused the values with a data error".into(),
        ProcedureEnd::NoReply => "the drive did not answer the procedure".into(),
        ProcedureEnd::Aborted => "a fault ended the procedure".into(),
    }
}

#[cfg(test)]
mod tests {
    use can_motion::plan::Warning;
    use can_motion::{AxisState, Fault};
    use dyn_can::{DecodeError, FrameError, FunctionCode, Reply, ReplyKind, Revision};

    use super::*;
    use crate::plain_words::events_are_plain;

    fn every_event() -> Vec<EventKind> {
        use EventKind as E;
        let reply = Reply::DiagnosticCounter(1);
        let ends = [
            ProcedureEnd::Read(reply),
            ProcedureEnd::Unchanged,
            ProcedureEnd::Written,
            ProcedureEnd::Sent,
            ProcedureEnd::NotTaken(reply),
            ProcedureEnd::Refused,
            ProcedureEnd::NoReply,
            ProcedureEnd::Aborted,
        ];
        let errors = [
            BusErrorKind::Overrun,
            BusErrorKind::Bit,
            BusErrorKind::Stuff,
            BusErrorKind::Crc,
            BusErrorKind::Form,
            BusErrorKind::Acknowledge,
            BusErrorKind::Other,
        ];
        let reasons = [
            Reason::Command,
            Reason::Reading,
            Reason::Sent,
            Reason::Displaced,
            Reason::Elapsed,
            Reason::Standstill,
            Reason::MoveEnded,
            Reason::Group,
            Reason::Fault,
        ];
        let mut events = vec![
            E::Fault(Fault::Lost),
            E::FoundOn,
            E::DisableUnconfirmed { repeated: 1 },
            E::DisableUnconfirmed { repeated: 4 },
            E::Plan(Warning::HighIdentifiers { drive: 63 }),
            E::Plan(Warning::PollsStretched { permille: 1_500 }),
            E::Revision(Revision::V1_2A),
            E::SetPointMerged,
            E::SetPointDisplaced,
            E::RequestDisplaced(ReplyKind::Torque),
            E::ReplyTimeout(ReplyKind::Position),
            E::LateReply(FunctionCode::ReadDriveStatus),
            E::StrayReply(FunctionCode::ReadDriveStatus),
            E::BadReply(DecodeError::SelectorUnknown),
            E::ForeignFrame { id: 0x123 },
            E::NotOurs(FrameError::Remote { id: 0x123 }),
            E::CyclesMissed(1),
            E::CyclesMissed(2),
            E::BusOff,
            E::BusRecovered,
        ];
        events.extend(ends.map(E::Procedure));
        events.extend(errors.map(E::BusError));
        events.extend(reasons.map(|reason| E::State {
            from: AxisState::Ready,
            to: AxisState::Streaming,
            reason,
        }));
        events
    }

    #[test]
    fn every_event_has_plain_words() {
        let source = include_str!("../../../can-motion/src/servo/event.rs");
        events_are_plain((source, "EventKind"), &every_event(), |event| {
            servo_words(*event).1
        });
    }
}
