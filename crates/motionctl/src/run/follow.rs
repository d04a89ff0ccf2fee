//! From power-on to disabled: the drives follow the plan as the clock goes on.

use can_motion::{Fault, ReadBackScale, TargetError};
use dyn_can::DriveId;
use indicatif::{ProgressBar, ProgressStyle};

use super::summary::{AxisSummary, Outcome, Summary};
use crate::interrupt;
use crate::link::LinkFault;
use crate::output::tell;
use crate::recording::Recorded;
use crate::station::{BringUpError, Station, fault_text, found_on, unconfirmed_warning};
use crate::trajectory::Plan;

/// Time after the motion for the drives to arrive and to be read once more.
const SETTLE_US: u64 = 500_000;
/// Time that the axes have to catch up after the last cycle of the plan.
const CATCH_UP_LIMIT_US: u64 = 10_000_000;
/// Cycles between two updates of the progress bar.
const PROGRESS_STEP: u64 = 100;

/// Why the motion ended before its end.
enum Stop {
    BringUp(BringUpError),
    Fault(DriveId, Fault),
    /// A target that the master does not take although nothing is wrong with the axis.
    Target(DriveId, TargetError),
    Interrupted,
    Link(LinkFault),
}

impl From<LinkFault> for Stop {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

impl Stop {
    fn outcome(self) -> Outcome {
        match self {
            Self::Link(fault) | Self::BringUp(BringUpError::Link(fault)) => {
                Outcome::LinkFailed(fault)
            }
            Self::Interrupted | Self::BringUp(BringUpError::Interrupted) => Outcome::Interrupted,
            Self::Fault(drive, fault) | Self::BringUp(BringUpError::Fault { drive, fault }) => {
                let text = fault_text(drive, fault);
                if fault == Fault::Bus {
                    Outcome::StoodStill(text)
                } else {
                    Outcome::Stopped(text)
                }
            }
            Self::BringUp(error) => Outcome::Stopped(error.to_string()),
            Self::Target(drive, error) => Outcome::Stopped(format!("drive {drive}: {error}")),
        }
    }
}

/// A motion under way.
pub(super) struct Follow<'link> {
    station: Station<'link>,
    /// Drive and unit of the read-back of each axis.
    drives: Vec<DriveId>,
    read_back: Vec<ReadBackScale>,
    /// Place in the master of each axis: the master wants its drives in ascending order.
    places: Vec<usize>,
    /// Where each axis stood at the start.
    anchors: Vec<i32>,
}

impl<'link> Follow<'link> {
    pub(super) fn new(
        station: Station<'link>,
        drives: &[DriveId],
        read_back: Vec<ReadBackScale>,
    ) -> Self {
        Self {
            station,
            drives: drives.to_vec(),
            read_back,
            places: places(drives),
            anchors: vec![0; drives.len()],
        }
    }

    /// Enables, moves, disables.
    pub(super) fn run(mut self, plan: &Plan, show_progress: bool) -> (Summary, Recorded) {
        let moved = self.start_up(show_progress).and_then(|()| {
            self.follow(plan, show_progress)?;
            self.settle()
        });
        let before_end = self.snapshots();
        let moved = moved.map_err(Stop::outcome);
        if let Err(Outcome::Stopped(text) | Outcome::StoodStill(text)) = &moved {
            // At once: slowing down and confirming take their time.
            tell(text);
        }
        self.phase("the motion ends");
        let end = self.station.shut_down();
        let warning = match &end {
            Ok(end) if end.unconfirmed.is_empty() => None,
            Ok(end) => Some(unconfirmed_warning(&end.unconfirmed)),
            Err(fault) => Some(format!(
                "the link failed: {fault}. {}",
                self.station.link_warning()
            )),
        };
        if let Some(warning) = &warning {
            // Where it is seen whatever becomes of the summary.
            tell(warning);
        }
        let outcome = match (moved, &end) {
            (Err(outcome), _) => outcome,
            (Ok(()), Err(fault)) => Outcome::LinkFailed(*fault),
            (Ok(()), Ok(_)) => Outcome::Completed,
        };
        // With what the axes needed to slow down.
        let (at_end, ended_at) = (self.snapshots(), self.station.now());
        let axes = before_end
            .iter()
            .zip(&at_end)
            .zip(&self.anchors)
            .zip(plan.last())
            .zip(&self.read_back)
            .enumerate()
            .map(
                |(axis, ((((before, sums), &anchor), target), &read_back))| {
                    AxisSummary::new(axis, before, sums, anchor, target, read_back, ended_at)
                },
            )
            .collect();
        let pace = self.station.pace();
        let late = self.station.master().cycle_counters().late;
        let end = end.unwrap_or_default();
        let summary = Summary::new(outcome, end, warning, axes, pace, late);
        (summary, self.station.finish_recording())
    }

    fn phase(&mut self, text: &str) {
        if let Some(recorder) = self.station.recorder() {
            recorder.phase(text);
        }
    }

    fn snapshots(&mut self) -> Vec<can_motion::AxisSnapshot> {
        let master = self.station.master();
        let axes = self.places.iter();
        axes.filter_map(|&place| master.snapshot(place)).collect()
    }

    fn targets(&mut self) -> Vec<i32> {
        let axes = self.snapshots();
        axes.iter().map(|axis| axis.target_counts).collect()
    }

    fn start_up(&mut self, show_progress: bool) -> Result<(), Stop> {
        self.station.bring_up().map_err(Stop::BringUp)?;
        self.anchors = self.targets();
        if let Some(recorder) = self.station.recorder() {
            recorder.motion_begins();
        }
        if show_progress {
            if let Some(text) = found_on(self.station.found_on()) {
                tell(text);
            }
            tell("every drive is enabled; the motion starts");
        }
        Ok(())
    }

    /// The row of the plan follows the clock: rows of cycles that were missed are passed over, and the axes owe the rest.
    fn follow(&mut self, plan: &Plan, show_progress: bool) -> Result<(), Stop> {
        let last = plan.cycles() as u64 - 1;
        let bar = progress_bar(last, show_progress);
        let mut first = None;
        let mut row = 0;
        while row < last {
            let (places, anchors) = (&self.places, &self.anchors);
            let mut refused = None;
            self.station.cycle(|master, number| {
                row = (number - *first.get_or_insert(number)).min(last);
                let offsets = plan.row(row as usize);
                let axes = places.iter().zip(anchors).zip(offsets).enumerate();
                for (axis, ((&place, &anchor), offset)) in axes {
                    let target = master.set_target(place, anchor.wrapping_add(offset));
                    refused = refused.or(target.err().map(|error| (axis, error)));
                }
            })?;
            if row % PROGRESS_STEP == 0 {
                bar.set_position(row);
            }
            // A fault is the cause of a refusal, and tells more.
            self.check()?;
            if let Some((axis, error)) = refused {
                return Err(Stop::Target(self.drives[axis], error));
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Until nothing is owed, and then until the drives have arrived.
    fn settle(&mut self) -> Result<(), Stop> {
        let start = self.station.now();
        let mut still_since = None;
        loop {
            self.station.cycle(|_, _| {})?;
            self.check()?;
            let now = self.station.now();
            let owes = self.snapshots().iter().any(|axis| axis.backlog_counts != 0);
            if owes {
                still_since = None;
            }
            let still_us = now.us_since(*still_since.get_or_insert(now));
            if still_us >= SETTLE_US || now.us_since(start) >= CATCH_UP_LIMIT_US {
                return Ok(());
            }
        }
    }

    fn check(&mut self) -> Result<(), Stop> {
        if let Some((drive, fault)) = self.station.first_fault() {
            return Err(Stop::Fault(drive, fault));
        }
        if interrupt::requests() > 0 {
            return Err(Stop::Interrupted);
        }
        Ok(())
    }
}

/// Place in the master of each drive: the master wants them in ascending order.
pub(super) fn places(drives: &[DriveId]) -> Vec<usize> {
    let place = |drive| drives.iter().filter(|&other| other < drive).count();
    drives.iter().map(place).collect()
}

fn progress_bar(cycles: u64, show: bool) -> ProgressBar {
    if !show {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} cycles, {eta} left");
    let bar = ProgressBar::new(cycles);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
