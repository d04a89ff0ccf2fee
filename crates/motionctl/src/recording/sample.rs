//! Everything at one moment, once a cycle.

use can_motion::wheel::{WheelFeedback, WheelSnapshot};
use can_motion::{AxisSnapshot, AxisState, Instant, PollKind};

use super::about::COUNTS_PER_RPM;

/// One axis in one cycle; positions in command counts as the master counts them, speeds of wheels in thousandths of an r/min.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisSample {
    /// Where the application wants the axis.
    pub(crate) target: i32,
    /// Where the set-points that went out take the drive.
    pub(crate) sent: i32,
    /// Where the motor stands, or how fast a wheel turns. A simulation knows it in every cycle; on a real bus it is the position that the drive reported in
    /// this cycle, and `None` in all others.
    pub(crate) position: Option<i64>,
    pub(crate) backlog: i32,
    /// Age of the latest status and position; `None` before the first.
    pub(crate) status_age_us: Option<u32>,
    pub(crate) position_age_us: Option<u32>,
    /// Unknown in a log.
    pub(crate) state: Option<AxisState>,
}

/// Everything in one cycle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    /// Since the start of the recording.
    pub(crate) at_us: u64,
    /// Number of the cycle on the clock: it jumps over cycles that were missed.
    pub(crate) number: u64,
    /// Busy share of the bus in this cycle, 0 ..= 1.
    pub(crate) load: f64,
    /// A set-point of this cycle was not on the bus in time, or the cycle began more than half a cycle late.
    pub(crate) is_late: bool,
    /// In the order of the motion's columns.
    pub(crate) axes: Vec<AxisSample>,
    /// What hub motors reported, in the same order; empty with other drives.
    pub(crate) wheels: Vec<WheelReadings>,
}

/// What a hub motor reported last, and what a simulation knows besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WheelReadings {
    /// Where the wheel stands; known in a simulation alone.
    pub(crate) travel_counts: Option<i64>,
    pub(crate) speed_decirpm: Option<i32>,
    pub(crate) position_counts: Option<i32>,
    pub(crate) torque: Option<i16>,
}

impl WheelReadings {
    pub(crate) fn new(feedback: &WheelFeedback, travel_counts: Option<i64>) -> Self {
        Self {
            travel_counts,
            speed_decirpm: feedback.speed_decirpm.map(|read| read.value),
            position_counts: feedback.position_counts.map(|read| read.value),
            torque: feedback.torque.map(|read| read.value),
        }
    }
}

impl AxisSample {
    pub(crate) fn new(snapshot: &AxisSnapshot, position: Option<i64>, now: Instant) -> Self {
        let age_us = |kind| {
            let at = snapshot.feedback.polled_at(kind)?;
            u32::try_from(now.us_since(at)).ok()
        };
        Self {
            target: snapshot.target_counts,
            sent: snapshot.sent_counts,
            position,
            backlog: snapshot.backlog_counts,
            status_age_us: age_us(PollKind::Status),
            position_age_us: age_us(PollKind::Position),
            state: Some(snapshot.state),
        }
    }

    /// A wheel whose speeds count 1/`resolution` r/min; `speed_rpm` is that of its shaft, where it is known in this cycle.
    pub(crate) fn of_wheel(
        snapshot: &WheelSnapshot,
        resolution: u16,
        speed_rpm: Option<f64>,
        now: Instant,
    ) -> Self {
        let speed = |number: i32| {
            (f64::from(number) / f64::from(resolution) * COUNTS_PER_RPM).round() as i32
        };
        let age_us = |at: Instant| u32::try_from(now.us_since(at)).ok();
        let (target, sent) = (speed(snapshot.target), speed(snapshot.sent));
        let feedback = &snapshot.feedback;
        Self {
            target,
            sent,
            position: speed_rpm.map(|rpm| (rpm * COUNTS_PER_RPM).round() as i64),
            backlog: target - sent,
            status_age_us: feedback.status.and_then(|read| age_us(read.at)),
            position_age_us: feedback.position_counts.and_then(|read| age_us(read.at)),
            state: Some(snapshot.state),
        }
    }

    /// Following error: target minus the motor's position, where that is known.
    pub(crate) fn error(&self) -> Option<i64> {
        Some(i64::from(self.target) - self.position?)
    }
}

impl Sample {
    /// The largest following error of all axes, in counts.
    pub(crate) fn largest_error(&self) -> u64 {
        let errors = self.axes.iter().filter_map(AxisSample::error);
        errors.map(i64::unsigned_abs).max().unwrap_or(0)
    }
}
