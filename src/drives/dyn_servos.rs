//! DYN servo drives.

use can_motion::{AxisConfig, AxisSnapshot, Dyn, EventKind, Instant, PollKind};
use dyn_can::{Address, DataFrame, Dialect, Request, ServoSwitch};

use super::Board;

impl Board for Dyn {
    fn disable(axis: &AxisConfig) -> Option<DataFrame> {
        let request = Request::ServoDisable(ServoSwitch::Disable);
        // The command is the same in every revision.
        let frame = request.encode(Address::Drive(axis.drive), &Dialect::V1_6A);
        frame.ok()
    }

    fn target(snapshot: &AxisSnapshot) -> i32 {
        snapshot.target_counts
    }

    fn read_at(snapshot: &AxisSnapshot) -> [Option<Instant>; 2] {
        let feedback = &snapshot.feedback;
        [
            feedback.polled_at(PollKind::Status),
            feedback.polled_at(PollKind::Position),
        ]
    }

    fn readings(axis: &AxisConfig, snapshot: &AxisSnapshot) -> homing::Inputs {
        let at = |at: Instant| at.as_us();
        let read = &snapshot.feedback;
        let position = read.position.and_then(|position| {
            Some(homing::Reading {
                value: axis.read_back.to_command_counts(position.value)?,
                at_us: at(position.at),
            })
        });
        homing::Inputs {
            sent_counts: snapshot.sent_counts,
            position,
            torque_permille: read.torque.map(|torque| homing::Reading {
                value: torque.value.permille_of_peak(),
                at_us: at(torque.at),
            }),
            switch: None,
        }
    }

    fn is_bus_error(kind: &EventKind) -> bool {
        matches!(kind, EventKind::BusError(_))
    }
}
