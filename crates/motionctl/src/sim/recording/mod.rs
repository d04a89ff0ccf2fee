//! What a simulation leaves behind to look at: samples of every cycle, events, frames, intervals.

mod frames;
mod intervals;
mod words;

use core::fmt;

use can_motion::{AxisSnapshot, Event, EventKind, Instant, PollKind};
use drive_sim::{NodeId, Record};
use dyn_can::DriveId;

pub(crate) use frames::{Frames, Sighting};
pub(crate) use intervals::Intervals;
use words::words;

/// One axis at the end of a cycle; positions in command counts as the master counts them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisSample {
    pub(crate) target: i32,
    pub(crate) sent: i32,
    /// Where the motor stands, which the drive alone knows.
    pub(crate) drive: i64,
    pub(crate) backlog: i32,
    /// Age of the latest status and position; `None` before the first.
    pub(crate) status_age_us: Option<u32>,
    pub(crate) position_age_us: Option<u32>,
}

/// Everything at the end of one cycle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    pub(crate) at_us: u64,
    /// Busy share of the bus in this cycle, 0 ..= 1.
    pub(crate) load: f64,
    /// A set-point of this cycle had not ended on the wire.
    pub(crate) is_late: bool,
    pub(crate) axes: Vec<AxisSample>,
}

/// Something that happened, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Happening {
    pub(crate) at_us: u64,
    pub(crate) axis: Option<usize>,
    pub(crate) kind: Kind,
    pub(crate) text: String,
    /// How often in a row; `at_us` is the first time.
    pub(crate) times: u32,
}

/// What kind of thing happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A fault was commanded: by the script or a key.
    Cause,
    /// The master latched a fault.
    Fault,
    /// The master noticed something.
    Notice,
    /// An axis changed its state.
    State,
    /// A phase of the run began.
    Phase,
}

/// The record of a run.
#[derive(Debug)]
pub(crate) struct Recording {
    pub(crate) drives: Vec<DriveId>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_ns: u64,
    pub(crate) samples: Vec<Sample>,
    pub(crate) happenings: Vec<Happening>,
    /// When the motion began; nothing is polled and no set-point is sent before.
    pub(crate) motion_start_us: Option<u64>,
    pub(crate) frames: Frames,
    pub(crate) intervals: Intervals,
}

impl Recording {
    /// What an axis is called: by the drive that the user knows.
    pub(crate) fn name(&self, axis: usize) -> String {
        self.drives
            .get(axis)
            .map_or_else(|| format!("axis {axis}"), |drive| format!("drive {drive}"))
    }

    pub(crate) fn new(drives: Vec<DriveId>, master: NodeId, cycle_us: u32, bit_ns: u64) -> Self {
        Self {
            intervals: Intervals::new(master, &drives),
            drives,
            cycle_us,
            bit_ns,
            samples: Vec::new(),
            happenings: Vec::new(),
            motion_start_us: None,
            frames: Frames::default(),
        }
    }

    pub(crate) fn frame(&mut self, record: &Record) {
        self.intervals.frame(record, self.cycle_us);
        self.frames.push(record, self.bit_ns);
    }

    /// `axis` is its place in the motion, not in the master.
    pub(crate) fn event(&mut self, event: &Event<EventKind>, axis: Option<usize>) {
        let (kind, text) = words(event.kind);
        self.happened(event.at.as_us(), axis, kind, text);
    }

    pub(crate) fn happened(
        &mut self,
        at_us: u64,
        axis: Option<usize>,
        kind: Kind,
        text: impl Into<String>,
    ) {
        let text = text.into();
        // A controller that is bus-off says so every cycle.
        if let Some(last) = self.happenings.last_mut()
            && (last.axis, last.kind, &last.text) == (axis, kind, &text)
        {
            last.times = last.times.saturating_add(1);
            return;
        }
        self.happenings.push(Happening {
            at_us,
            axis,
            kind,
            text,
            times: 1,
        });
    }

    /// Time of the last sample in seconds.
    pub(crate) fn end_s(&self) -> f64 {
        self.samples
            .last()
            .map_or(0.0, |sample| sample.at_us as f64 * 1e-6)
    }
}

/// The words, and how often they were said.
impl fmt::Display for Happening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        if self.times > 1 {
            write!(f, " ({} times)", self.times)?;
        }
        Ok(())
    }
}

impl AxisSample {
    pub(crate) fn new(snapshot: &AxisSnapshot, drive_counts: i64, now: Instant) -> Self {
        let age_us = |kind| {
            let at = snapshot.feedback.polled_at(kind)?;
            u32::try_from(now.us_since(at)).ok()
        };
        Self {
            target: snapshot.target_counts,
            sent: snapshot.sent_counts,
            drive: drive_counts,
            backlog: snapshot.backlog_counts,
            status_age_us: age_us(PollKind::Status),
            position_age_us: age_us(PollKind::Position),
        }
    }

    /// Target minus the motor's position.
    pub(crate) fn error(&self) -> i64 {
        i64::from(self.target) - self.drive
    }
}
