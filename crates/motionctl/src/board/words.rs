//! What a board says, in words.

use board_link::message::{BoardState, Event, FaultEntry, Reason, Refused};
use board_link::segment::StreamPhase;
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::Alarm;

use super::info::AxisReport;
use crate::table::align_numbers;

/// A refusal, with what to do.
pub(super) fn refusal(refused: &Refused) -> String {
    match board_settings::Refusal::of_board(refused) {
        Some(refusal) => refusal.to_string(),
        None => refused.to_string(),
    }
}

/// Whether the board does not know what it was asked for.
pub(super) fn is_unknown(refused: &Refused) -> bool {
    refused.is(Reason::Unsupported) || refused.is(Reason::Message)
}

/// Where the machine is.
pub(super) const fn state(state: BoardState) -> &'static str {
    match state {
        BoardState::NoSettings => "no settings",
        BoardState::Locked => "locked by a failure of its firmware",
        BoardState::StopOpen => "the stop circuit is open",
        BoardState::EnableInactive => "the enable input is not active",
        BoardState::Off => "off",
        BoardState::GettingReady => "getting ready",
        BoardState::Enabled => "enabled",
        BoardState::Homing => "homing",
        BoardState::Stopping => "stopping",
        BoardState::Faulted => "faulted",
    }
}

/// What becomes of a stream.
pub(super) const fn phase(phase: StreamPhase) -> &'static str {
    match phase {
        StreamPhase::Idle => "none",
        StreamPhase::Waiting => "waiting",
        StreamPhase::Moving => "moving",
        StreamPhase::Dry => "run dry, waiting",
        StreamPhase::Complete => "complete",
        StreamPhase::DriedUp => "run dry, ended",
        StreamPhase::Stopped => "stopped",
        StreamPhase::Displaced => "the axes stood elsewhere, nothing has moved",
    }
}

/// What a number of a fault means, with what else is known of it.
pub(super) fn fault(code: u16, detail: i32) -> String {
    let text = match code {
        1 => "the drive reports an alarm",
        2 => {
            let alarm = u8::try_from(detail).ok().and_then(alarm);
            return alarm.map_or_else(
                || format!("the drive reports alarm {detail}"),
                |alarm| format!("the drive reports an alarm: {alarm}"),
            );
        }
        3 => "the drive refuses a request as malformed",
        4 => return format!("the drive reports an error that is not documented: {detail}"),
        5 => "the drive lost its power or was switched off",
        6 => "the drive was switched on by somebody else",
        7 => return format!("the configuration of the drive cannot be used: {detail:#04x}"),
        8 if detail < 0 => "the gear number of the drive cannot be read",
        8 => return format!("the drive has gear number {detail}, the settings say another"),
        9 => "a load can fall, and the drive has no brake output",
        10 => "the drive does not answer any more",
        11 => return format!("the axis is {detail} counts behind its set-points"),
        12 => return format!("the axis drifts at standstill: {detail} counts"),
        13 => return format!("the following error is {detail} counts"),
        14 => return format!("the position jumped by {detail} counts"),
        15 => "the drive has started anew",
        16 => "no set-point got out onto the bus",
        17 => "the drive did not confirm that it is on or off",
        18 => return format!("the drive reads back a position that makes no sense: {detail}"),
        19 => return format!("the axis did not arrive: {detail} counts are missing"),
        20 => return format!("the axis is at the end of its travel: {detail} counts"),
        21 => "another axis of its group has a fault",
        100 => "the controller went bus-off",
        _ => return format!("fault {code}, {detail}"),
    };
    text.to_owned()
}

fn alarm(code: u8) -> Option<Alarm> {
    let alarm = Alarm::from_code(code);
    alarm.is_alarm().then_some(alarm)
}

/// An entry of the fault log without its time.
pub(super) fn entry(entry: &FaultEntry) -> String {
    let mut text = fault(entry.code, entry.detail);
    if !entry.place.is_empty() {
        text.push_str(&format!(", at {}", entry.place));
    }
    text
}

/// An event; `drive` says which drive an axis is.
pub(super) fn event(event: &Event, drive: impl Fn(u8) -> Option<u8>) -> String {
    match event {
        Event::State(is) => state(*is).to_owned(),
        Event::Stream {
            phase: is,
            finished,
            ..
        } => format!("stream: {}, {finished} segments played", phase(*is)),
        Event::Fault { axis, code, detail } => {
            let text = fault(*code, *detail);
            match axis.map(|axis| (axis, drive(axis))) {
                Some((_, Some(drive))) => format!("drive {drive}: {text}"),
                Some((axis, None)) => format!("axis {axis}: {text}"),
                None => text,
            }
        }
        Event::Claimed { session } => format!("host {session:08x} commands"),
        Event::Released { session } => format!("host {session:08x} does not command any more"),
        Event::SilentHost { session } => {
            format!("host {session:08x} was silent for too long: the axes stop")
        }
        Event::Homed {
            axis,
            counts,
            uncertainty,
        } => {
            let who = match drive(*axis) {
                Some(drive) => format!("drive {drive}"),
                None => format!("axis {axis}"),
            };
            format!("{who} is homed: its zero is at {counts} counts, within {uncertainty}")
        }
    }
}

/// What a number of a fault means, where nothing else is known.
pub(super) fn fault_name(code: u16) -> String {
    match code {
        2 => "the drive reports an alarm".to_owned(),
        7 => "the configuration of the drive cannot be used".to_owned(),
        8 => "the drive has another gear number than the settings say".to_owned(),
        11 => "the axis is too far behind its set-points".to_owned(),
        12 => "the axis drifts at standstill".to_owned(),
        13 => "the following error is too large".to_owned(),
        14 => "the position jumped".to_owned(),
        18 => "the drive reads back a position that makes no sense".to_owned(),
        19 => "the axis did not arrive".to_owned(),
        20 => "the axis is at the end of its travel".to_owned(),
        _ => fault(code, 0),
    }
}

/// The axes, one a row.
pub(super) fn table(axes: &[AxisReport]) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header([
        "drive",
        "target\ncounts",
        "position\ncounts",
        "error\ncounts",
        "fault",
    ]);
    for axis in axes {
        table.add_row([
            axis.drive
                .map_or_else(|| "?".to_owned(), |drive| drive.to_string()),
            axis.target_counts.to_string(),
            axis.position_counts.to_string(),
            axis.error_counts.to_string(),
            axis.fault.clone().unwrap_or_default(),
        ]);
    }
    align_numbers(&mut table);
    table
}
