//! Keyframes as Rust, for a configuration of the firmware to include.

use core::fmt::Write as _;

use dyn_can::{DriveId, GearNumber};

use super::fit::Fitted;
use super::report::Report;
use crate::trajectory::MotionReport;

/// The text of the file.
pub(super) fn write(
    report: &Report,
    fitted: &Fitted,
    told: &MotionReport,
    drives: &[DriveId],
    gears: &[GearNumber],
) -> String {
    let mut text = String::from(
        "// Made by `motionctl keyframes`, to be included by a configuration of the firmware.\n//\n",
    );
    for line in told.to_string().lines().chain([report.nearness().as_str()]) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "// {line}");
    }
    let (axes, frames) = (fitted.motors, fitted.frames.len());
    let _ = write!(text, "{}", head(axes, frames));
    let axes_of = drives.iter().zip(gears);
    let axes_of: Vec<String> = axes_of
        .map(|(drive, gear)| format!("({}, {})", drive.get(), gear.get()))
        .collect();
    let _ = writeln!(
        text,
        "/// Drive and gear number of each axis: the positions are those of these.\npub(crate) const MOTION_DRIVES: [(i32, i32); {axes}] = [{}];\n",
        axes_of.join(", ")
    );
    let _ = writeln!(
        text,
        "const PASSED: [trajectory::curve::Keyframe<{axes}>; {frames}] = ["
    );
    for frame in &fitted.frames {
        let _ = writeln!(text, "    passed({}, {:?}),", frame.at_ms, frame.counts);
    }
    let _ = writeln!(
        text,
        "];\n\nconst PASSED_COUNTS_PER_S: [[i32; {axes}]; {frames}] = ["
    );
    for frame in &fitted.frames {
        let _ = writeln!(text, "    {:?},", frame.counts_per_s);
    }
    text.push_str("];\n");
    text
}

fn head(axes: usize, frames: usize) -> String {
    format!(
        "
/// The built-in motion: {frames} keyframes that are passed at speed.
pub(crate) const MOTION: trajectory::curve::KeyframeMotion<'static, {axes}> =
    match trajectory::curve::KeyframeMotion::passing(&PASSED, &PASSED_COUNTS_PER_S) {{
        Ok(motion) => motion,
        Err(_) => panic!(\"the keyframes are not what was written\"),
    }};

const fn passed(at_ms: u32, positions_counts: [i32; {axes}]) -> trajectory::curve::Keyframe<{axes}> {{
    trajectory::curve::Keyframe {{
        at_ms,
        positions_counts,
    }}
}}

"
    )
}
