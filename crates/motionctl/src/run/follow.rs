//! From power-on to disabled: the drives follow the plan as the clock goes on.

use can_motion::{Fault, ReadBackScale, TargetError};
use dyn_can::DriveId;
use indicatif::{ProgressBar, ProgressStyle};

use std::sync::Arc;

use super::summary::{AxisSummary, Outcome, Summary};
use super::together::Together;
use crate::control::Wishes;
use crate::interrupt;
use crate::link::LinkFault;
use crate::output::tell;
use crate::recording::Recorded;
use crate::set_points::{SetPointSource, Step};
use crate::station::{BringUpError, Station, fault_text, found_on, unconfirmed_warning};

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
    Ordered,
    RanOut,
    /// Another bus stopped.
    Together(String),
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
            Self::Together(reason) => {
                Outcome::Stopped(format!("stopped with the other bus: {reason}"))
            }
            Self::Ordered => Outcome::Ordered,
            Self::RanOut => Outcome::RanOut,
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
    /// The name of the bus, where there are several.
    bus: String,
    together: Option<Arc<Together>>,
}

impl Drop for Follow<'_> {
    /// Whatever the reason, a bus that ends ends all: a panic, too.
    fn drop(&mut self) {
        if std::thread::panicking()
            && let Some(together) = &self.together
        {
            together.fail(format!("{}: a failure of this program", self.bus));
        }
    }
}

impl<'link> Follow<'link> {
    pub(super) fn new(
        station: Station<'link>,
        axes: Vec<(DriveId, ReadBackScale)>,
        bus: String,
        together: Option<Arc<Together>>,
    ) -> Self {
        let (drives, read_back): (Vec<DriveId>, Vec<ReadBackScale>) = axes.into_iter().unzip();
        Self {
            station,
            places: places(&drives),
            anchors: vec![0; drives.len()],
            drives,
            read_back,
            bus,
            together,
        }
    }

    pub(super) fn axes(&self) -> usize {
        self.drives.len()
    }

    /// What it shares with other buses.
    pub(super) fn together(&self) -> Option<Arc<Together>> {
        self.together.clone()
    }

    /// To the user, with the bus where there are several.
    fn tell(&self, text: &str) {
        if self.bus.is_empty() {
            tell(text);
        } else {
            tell(format_args!("{}: {text}", self.bus));
        }
    }

    /// Enables, moves, disables.
    pub(super) fn run(
        mut self,
        source: &mut dyn SetPointSource,
        wishes: &Wishes,
        show_progress: bool,
    ) -> (Summary, Recorded) {
        let mut row = vec![0; source.axes()];
        let moved = self.start_up(show_progress).and_then(|()| {
            let end = self.follow(source, wishes, &mut row, show_progress)?;
            self.settle()?;
            match end {
                Step::Goes | Step::Completed => Ok(()),
                Step::Stopped => Err(Stop::Ordered),
                Step::RanOut => Err(Stop::RanOut),
            }
        });
        let before_end = self.snapshots();
        let moved = moved.map_err(Stop::outcome);
        if let (Err(outcome), Some(together)) = (&moved, &self.together) {
            let reason = outcome.reason().unwrap_or_else(|| outcome.to_string());
            together.fail(format!("{}: {reason}", self.bus));
        }
        if let Err(Outcome::Stopped(text) | Outcome::StoodStill(text)) = &moved {
            // At once: slowing down and confirming take their time.
            self.tell(text);
        }
        self.phase("the motion ends");
        let end = self.station.shut_down();
        let link_fault = match (&moved, &end) {
            (_, Err(fault)) => Some(*fault),
            // There was nothing left to do, and nothing could have been done either.
            (Err(Outcome::LinkFailed(fault)), Ok(end)) if !end.left_on.is_empty() => Some(*fault),
            _ => None,
        };
        let unconfirmed = end.as_ref().map_or(&[][..], |end| &end.unconfirmed);
        let warning = match link_fault {
            Some(fault) => Some(format!(
                "the link failed: {fault}. {}",
                self.station.link_warning()
            )),
            None => (!unconfirmed.is_empty()).then(|| unconfirmed_warning(unconfirmed)),
        };
        if let Some(warning) = &warning {
            // Where it is seen whatever becomes of the summary.
            self.tell(warning);
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
            .zip(row)
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
        let (bus, end) = (self.bus.clone(), end.unwrap_or_default());
        let summary = Summary::new(bus, outcome, end, warning, axes, pace, late);
        (summary, self.station.finish_recording())
    }

    fn phase(&mut self, text: &str) {
        if let Some(recorder) = self.station.recorder() {
            recorder.bus().phase(text);
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
        self.await_others()?;
        self.anchors = self.targets();
        if let Some(recorder) = self.station.recorder() {
            recorder.bus().motion_begins();
        }
        if show_progress {
            if let Some(text) = found_on(self.station.found_on()) {
                tell(text);
            }
            tell("every drive is enabled; the motion starts");
        }
        Ok(())
    }

    /// The motion follows the clock: rows of cycles that were missed are passed over, and the axes owe the rest.
    fn follow(
        &mut self,
        source: &mut dyn SetPointSource,
        wishes: &Wishes,
        row: &mut [i32],
        show_progress: bool,
    ) -> Result<Step, Stop> {
        let bar = progress_bar(source.progress().1, show_progress);
        let mut before = None;
        loop {
            wishes.hand_on(source);
            let (places, anchors) = (&self.places, &self.anchors);
            let (mut refused, mut step) = (None, Step::Goes);
            self.station.cycle(|master, number| {
                // In the first cycle the axes stand, as in a simulation.
                for _ in before.unwrap_or(number)..number {
                    step = source.next(row);
                }
                before = Some(number);
                for (axis, ((&place, &anchor), &offset)) in
                    places.iter().zip(anchors).zip(row.iter()).enumerate()
                {
                    let target = master.set_target(place, anchor.wrapping_add(offset));
                    refused = refused.or(target.err().map(|error| (axis, error)));
                }
            })?;
            while let Some(notice) = source.next_notice() {
                self.phase(&notice);
                bar.suspend(|| tell(notice));
            }
            if let (Some(naming), Some(recorder)) = (source.take_naming(), self.station.recorder())
            {
                recorder.bus().name_axes(naming);
            }
            if before.is_some_and(|number: u64| number.is_multiple_of(PROGRESS_STEP)) {
                bar.set_position(source.progress().0);
            }
            // A fault is the cause of a refusal, and tells more.
            self.check()?;
            if let Some((axis, error)) = refused {
                return Err(Stop::Target(self.drives[axis], error));
            }
            if step != Step::Goes {
                bar.finish_and_clear();
                return Ok(step);
            }
        }
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

    /// Holds until every bus is ready.
    fn await_others(&mut self) -> Result<(), Stop> {
        let Some(together) = self.together() else {
            return Ok(());
        };
        together.is_ready();
        while !together.may_start() {
            self.station.cycle(|_, _| {})?;
            self.check()?;
        }
        Ok(())
    }

    fn check(&mut self) -> Result<(), Stop> {
        if let Some((drive, fault)) = self.station.first_fault() {
            return Err(Stop::Fault(drive, fault));
        }
        if interrupt::requests() > 0 {
            return Err(Stop::Interrupted);
        }
        let failure = self
            .together
            .as_ref()
            .and_then(|together| together.failure());
        failure.map_or(Ok(()), |reason| Err(Stop::Together(reason)))
    }
}

/// Place in the master of each drive: the master wants them in ascending order.
pub(super) fn places(drives: &[DriveId]) -> Vec<usize> {
    let place = |drive| drives.iter().filter(|&other| other < drive).count();
    drives.iter().map(place).collect()
}

/// A bar for so many cycles, where they are known and somebody looks at it.
pub(crate) fn progress_bar(cycles: Option<u64>, show: bool) -> ProgressBar {
    let (Some(cycles), true) = (cycles, show) else {
        return ProgressBar::hidden();
    };
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} cycles, {eta} left");
    let bar = ProgressBar::new(cycles);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
