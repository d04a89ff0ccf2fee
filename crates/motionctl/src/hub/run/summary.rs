//! What has become of a run.

use core::fmt;
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;

use crate::counted::counted;
use crate::exit;
use crate::recording::{AxisOutcome, Outcome, RecordingReport};

/// What every run counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct Counts {
    pub(super) interrupted: bool,
    /// Every wheel says that it stands.
    pub(super) stands: bool,
    pub(super) cycles: u64,
    /// Cycles begun more than half a cycle after their time.
    pub(super) late_cycles: u64,
    /// Cycles never begun.
    pub(super) merged_cycles: u64,
}

/// One wheel at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct WheelCounts {
    pub(super) node: u8,
    /// How far it turned, by its own count.
    pub(super) counts: Option<i32>,
}

/// Where a vehicle is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(super) struct VehiclePose {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
    pub(super) from_start_m: f64,
    pub(super) left_counts: i64,
    pub(super) right_counts: i64,
}

/// A run at its end.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct Summary {
    /// The end of the input was reached, and every wheel stands.
    pub(super) complete: bool,
    #[serde(flatten)]
    pub(super) counts: Counts,
    pub(super) wheels: Vec<WheelCounts>,
    pub(super) pose: Option<VehiclePose>,
    /// How often no twist came in time.
    pub(super) dead_man_stops: u32,
    /// Cycles in which the vehicle was slower than its twist.
    pub(super) limited_cycles: u32,
    /// What became of the files.
    pub(super) recording: RecordingReport,
    /// Everything that was to be recorded is.
    #[serde(skip)]
    pub(super) is_recorded: bool,
}

impl Summary {
    /// Of wheels that only moved: everything that is not counted in cycles is added.
    pub(super) fn new(counts: Counts) -> Self {
        Self {
            complete: false,
            counts,
            wheels: Vec::new(),
            pose: None,
            dead_man_stops: 0,
            limited_cycles: 0,
            recording: RecordingReport::default(),
            is_recorded: true,
        }
    }

    /// The result as its page has it.
    pub(super) fn for_page(&self, axes: Vec<AxisOutcome>) -> Outcome {
        Outcome {
            verdict: self.verdict().to_owned(),
            is_good: self.complete,
            facts: self.facts(),
            axes,
        }
    }

    /// Notes what became of the recording, and whether the page that was wanted is there.
    pub(super) fn note_recording(&mut self, report: RecordingReport, has_page: bool) {
        self.is_recorded = report.is_complete() && has_page;
        self.recording = report;
    }

    /// The exit status of a run.
    pub(super) fn exit_code(&self) -> ExitCode {
        match (self.counts.interrupted, self.complete && self.is_recorded) {
            (true, _) => exit::INTERRUPTED.into(),
            (false, true) => ExitCode::SUCCESS,
            (false, false) => exit::BROKEN_PROMISE.into(),
        }
    }

    /// The result in one sentence.
    const fn verdict(&self) -> &'static str {
        match (self.complete, self.counts.interrupted) {
            (false, false) if self.counts.stands => {
                "NOT complete: the input ended with an error; every wheel stands and its power is off."
            }
            (true, _) => "The end was reached; every wheel stands and its power is off.",
            (false, true) => "Stopped by the user; the power of the wheels is off.",
            (false, false) => "NOT complete: a wheel does not say that it stands.",
        }
    }

    /// What else is true of the whole run.
    fn facts(&self) -> Vec<String> {
        let wheels = self.wheels.iter().map(|wheel| {
            let counts = wheel.counts.map(|counts| counts.to_string());
            let counts = counts.unwrap_or_else(|| "?".to_owned());
            format!("node {}: turned {counts} counts", wheel.node)
        });
        let mut facts: Vec<String> = wheels.collect();
        if let Some(pose) = &self.pose {
            facts.push(format!(
                "odometry: x {:.4} m, y {:.4} m, heading {:.2} degrees, {:.1} mm from the start",
                pose.x_m,
                pose.y_m,
                pose.heading_rad.to_degrees(),
                pose.from_start_m * 1e3
            ));
        }
        if self.dead_man_stops > 0 {
            let times = counted(self.dead_man_stops, "time", "times");
            facts.push(format!("stopped {times} because no twist came in time"));
        }
        if self.limited_cycles > 0 {
            facts.push(format!(
                "slower than the twist, on the same curve, in {} cycles",
                self.limited_cycles
            ));
        }
        facts.push(format!(
            "{} cycles, {} late, {} merged into the next",
            self.counts.cycles, self.counts.late_cycles, self.counts.merged_cycles
        ));
        facts
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for fact in self.facts() {
            writeln!(f, "{fact}")?;
        }
        f.write_str(self.verdict())
    }
}
