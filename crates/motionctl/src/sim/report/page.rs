//! The page: numbers, pictures, the strip of frames, and the events.

use core::fmt::Write as _;

use super::{charts, frame_block, palette};
use crate::counted::counted;
use crate::sim::axis_summary::{AxisSummary, age_text};
use crate::sim::recording::{Kind, Recording};
use crate::sim::summary::Summary;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("strip.js");
/// Rows of the table of events; the rest is counted.
const MOST_EVENTS: usize = 1_000;

/// The whole page, or why a picture cannot be drawn.
pub(super) fn page(
    recording: &Recording,
    summary: &Summary,
    path: Option<&str>,
) -> Result<String, String> {
    let mut axes = String::new();
    for axis in 0..recording.drives.len() {
        let picture = charts::axis(recording, axis)?;
        let drive = recording.drives[axis];
        // Writing to a string cannot fail.
        let _ = write!(
            axes,
            "<figure><figcaption>Axis {axis}, drive {drive}</figcaption>{AXIS_LEGEND}{picture}</figure>"
        );
    }
    let parts = [
        ("style", format!("{}\n{STYLE}", palette::rules())),
        ("verdict", verdict(summary)),
        ("facts", facts(recording, summary)),
        ("summary", summary_rows(summary)),
        ("path", path.map_or_else(String::new, path_figure)),
        ("axes", axes),
        ("bus", charts::bus(recording)?),
        ("jitter", charts::jitter(recording)?),
        ("jitter-facts", jitter_facts(recording)),
        ("strip-note", strip_note(recording)),
        ("events", event_rows(recording)),
        ("data", data(recording)),
        ("script", SCRIPT.to_owned()),
    ];
    Ok(fill(&parts))
}

fn path_figure(picture: &str) -> String {
    format!(
        "<figure><figcaption>Path of the program, seen from above</figcaption>{picture}</figure>"
    )
}

const AXIS_LEGEND: &str = "<ul class=\"legend\"><li class=\"target\">target</li><li class=\"sent\">sent</li><li class=\"drive\">drive</li>\
<li class=\"error\">target - drive</li><li class=\"backlog\">target - sent</li><li class=\"status-age\">status poll</li><li class=\"position-age\">position poll</li>\
<li class=\"cause\">commanded fault</li><li class=\"fault\">fault</li></ul>";

/// Puts each part at its place in the template, once: a part is never searched for places.
fn fill(parts: &[(&str, String)]) -> String {
    let mut pieces = TEMPLATE.split("{{");
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or((piece, ""));
        let part = parts.iter().find(|(other, _)| *other == name);
        page.push_str(part.map_or("", |(_, text)| text));
        page.push_str(rest);
    }
    page
}

/// Text between tags.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

fn verdict(summary: &Summary) -> String {
    let class = if summary.promises_kept() {
        "kept"
    } else {
        "broken"
    };
    format!(
        "<p class=\"verdict {class}\">{}</p>",
        escaped(summary.verdict())
    )
}

fn facts(recording: &Recording, summary: &Summary) -> String {
    format!(
        "{} of {} us at {} kbit/s, {} of them late; bus load {:.1} % mean, {:.1} % peak; {}; {:.3} s of virtual time.",
        counted(summary.cycles, "cycle", "cycles"),
        summary.cycle_us,
        summary.bit_rate_kbit,
        summary.late_cycles,
        100.0 * summary.mean_bus_load,
        100.0 * summary.peak_bus_load,
        counted(summary.faults, "fault", "faults"),
        recording.end_s(),
    )
}

fn summary_rows(summary: &Summary) -> String {
    summary.axes.iter().map(summary_row).collect()
}

fn summary_row(axis: &AxisSummary) -> String {
    let difference = i64::from(axis.target_counts) - axis.received_counts;
    let numbers = [
        axis.axis.to_string(),
        axis.drive.to_string(),
        axis.set_points.to_string(),
        axis.target_counts.to_string(),
        axis.sent_counts.to_string(),
        axis.received_counts.to_string(),
        difference.to_string(),
        axis.largest_backlog_counts.to_string(),
        axis.position_error_counts.to_string(),
        age_text(axis.worst_status_age_ms),
        age_text(axis.worst_position_age_ms),
        axis.reply_timeouts.to_string(),
    ];
    let state = axis.fault.as_ref().unwrap_or(&axis.state);
    let cells: String = numbers
        .iter()
        .map(|number| format!("<td>{number}</td>"))
        .collect();
    format!(
        "<tr>{cells}<td class=\"words\">{}</td></tr>\n",
        escaped(state)
    )
}

fn jitter_facts(recording: &Recording) -> String {
    let intervals = &recording.intervals;
    format!(
        "{}: {:.2} % within 10 us of the cycle, {:.2} % within 100 us.",
        counted(intervals.deviations_us().len(), "interval", "intervals"),
        100.0 * intervals.share_within(10.0),
        100.0 * intervals.share_within(100.0),
    )
}

fn strip_note(recording: &Recording) -> String {
    let frames = recording.frames.sightings().len();
    match recording.frames.forgotten() {
        0 => format!("The whole run, {}.", counted(frames, "frame", "frames")),
        forgotten => format!(
            "The newest {}; {forgotten} before them are not in the page, --candump keeps everything.",
            counted(frames, "frame", "frames")
        ),
    }
}

fn event_rows(recording: &Recording) -> String {
    let mut rows = String::new();
    for happening in recording.happenings.iter().take(MOST_EVENTS) {
        let kind = match happening.kind {
            Kind::Cause => ("cause", "commanded"),
            Kind::Fault => ("fault", "fault"),
            Kind::Notice => ("notice", "notice"),
            Kind::State => ("state", "state"),
            Kind::Phase => ("state", "phase"),
        };
        let axis = happening
            .axis
            .map_or(String::new(), |axis| recording.name(axis));
        let _ = writeln!(
            rows,
            "<tr><td>{:.6}</td><td>{axis}</td><td class=\"words {}\">{}</td><td class=\"words\">{}</td></tr>",
            happening.at_us as f64 * 1e-6,
            kind.0,
            kind.1,
            escaped(&happening.to_string()),
        );
    }
    let left = recording.happenings.len().saturating_sub(MOST_EVENTS);
    if left > 0 {
        let _ = writeln!(rows, "<tr><td colspan=\"4\">and {left} more</td></tr>");
    }
    rows
}

/// What the script of the strip draws.
fn data(recording: &Recording) -> String {
    let marks: Vec<_> = recording
        .happenings
        .iter()
        .filter(|happening| happening.kind != Kind::State)
        .take(MOST_EVENTS)
        .map(|happening| {
            let axis = happening
                .axis
                .map_or(String::new(), |axis| format!("{}: ", recording.name(axis)));
            (happening.at_us, format!("{axis}{happening}"))
        })
        .collect();
    let drives: Vec<u8> = recording.drives.iter().map(|drive| drive.get()).collect();
    let data = serde_json::json!({
        "bitNs": recording.bit_ns,
        "cycleUs": recording.cycle_us,
        "motionUs": recording.motion_start_us.unwrap_or(0),
        "endUs": recording.end_s() * 1e6,
        "drives": drives,
        "texts": recording.frames.texts(),
        "marks": marks,
        "frames": frame_block::block(recording.frames.sightings()),
    });
    // The block must not end the element that it stands in.
    data.to_string().replace('<', "\\u003c")
}
