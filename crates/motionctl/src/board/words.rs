//! What a board says, in words.

use board_link::message::{Event, FaultEntry, Reason, Refused};
use board_link::segment::StreamPhase;
use board_settings::FaultNumber;
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;

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

/// What a number of a fault means, where nothing else is known.
pub(super) fn fault_name(code: u16) -> String {
    let unknown = || FaultNumber { code, detail: 0 }.to_string();
    FaultNumber::name(code).map_or_else(unknown, str::to_owned)
}

/// An entry of the fault log without its time.
pub(super) fn entry(entry: &FaultEntry) -> String {
    let FaultEntry { code, detail, .. } = *entry;
    let text = FaultNumber { code, detail }.to_string();
    match (entry.place.as_str(), code) {
        ("", _) => text,
        // The line of a panic is its detail.
        (file, FaultNumber::PANIC) => format!("{text} at {file}:{detail}"),
        (place, _) => format!("{text}, at {place}"),
    }
}

/// An event; `drive` says which drive an axis is.
pub(super) fn event(event: &Event, drive: impl Fn(u8) -> Option<u8>) -> String {
    match event {
        Event::State(is) => is.text().to_owned(),
        Event::Stream {
            phase: is,
            finished,
            ..
        } => format!("stream: {}, {finished} segments played", phase(*is)),
        Event::Fault { axis, code, detail } => {
            let (code, detail) = (*code, *detail);
            let text = FaultNumber { code, detail }.to_string();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_with_its_file_and_line() {
        let mut panic = FaultEntry {
            code: FaultNumber::PANIC,
            detail: 71,
            place: "src/app.rs".parse().expect("a short text"),
            ..FaultEntry::default()
        };
        assert_eq!(entry(&panic), "the firmware panicked at src/app.rs:71");
        panic.place = "".parse().expect("no text");
        assert_eq!(entry(&panic), "the firmware panicked");
    }
}
