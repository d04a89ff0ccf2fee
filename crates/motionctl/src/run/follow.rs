//! From power-on to disabled: the drives follow the plan as the clock goes on.

use can_motion::{AxisState, EventKind, ReadBackScale};
use dyn_can::DriveId;
use indicatif::{ProgressBar, ProgressStyle};

use super::summary::{AxisSummary, Outcome, Summary};
use crate::interrupt;
use crate::link::LinkFault;
use crate::station::{GROUP, Station};
use crate::trajectory::Plan;

/// Time for the drives to become ready, and to be enabled.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time after the motion for the drives to arrive and to be read once more.
const SETTLE_US: u64 = 500_000;
/// Time that the axes have to catch up after the last cycle of the plan.
const CATCH_UP_LIMIT_US: u64 = 10_000_000;
/// Cycles between two updates of the progress bar.
const PROGRESS_STEP: u64 = 100;

/// Why the motion ended before its end.
enum Stop {
    Fault,
    NotReady,
    Interrupted,
    Link(LinkFault),
}

impl From<LinkFault> for Stop {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

/// A motion under way.
pub(super) struct Follow<'link> {
    station: Station<'link>,
    read_back: ReadBackScale,
    /// Place in the master of each axis: the master wants its drives in ascending order.
    places: Vec<usize>,
    /// Where each axis stood at the start.
    anchors: Vec<i32>,
    saw_fault: bool,
}

impl<'link> Follow<'link> {
    pub(super) fn new(
        station: Station<'link>,
        drives: &[DriveId],
        read_back: ReadBackScale,
    ) -> Self {
        let place = |drive| drives.iter().filter(|&other| other < drive).count();
        Self {
            station,
            read_back,
            places: drives.iter().map(place).collect(),
            anchors: vec![0; drives.len()],
            saw_fault: false,
        }
    }

    /// Enables, moves, disables.
    pub(super) fn run(mut self, plan: &Plan, show_progress: bool) -> Summary {
        let moved = self.start_up().and_then(|()| {
            self.anchors = self.targets();
            if show_progress {
                eprintln!("every drive is enabled; the motion starts");
            }
            self.follow(plan, show_progress)?;
            self.settle()
        });
        let before_end = self.snapshots();
        let shut_down = match moved {
            // Nothing gets through any more.
            Err(Stop::Link(fault)) => Err(fault),
            _ => self.shut_down(),
        };
        let outcome = match (moved, &shut_down) {
            (Err(Stop::Link(fault)), _) => Outcome::LinkFailed(fault),
            (_, Err(fault)) => Outcome::LinkFailed(*fault),
            (Err(Stop::Fault), _) => Outcome::Faulted,
            (Err(Stop::NotReady), _) => Outcome::NotReady,
            (Err(Stop::Interrupted), _) => Outcome::Interrupted,
            (Ok(()), Ok(_)) => Outcome::Completed,
        };
        let unconfirmed = shut_down.unwrap_or_default();
        let axes = before_end
            .iter()
            .zip(&self.anchors)
            .zip(plan.last())
            .enumerate()
            .map(|(axis, ((snapshot, &anchor), target))| {
                AxisSummary::new(axis, snapshot, anchor, target, self.read_back)
            })
            .collect();
        let pace = self.station.pace();
        let late = self.station.master().cycle_counters().late;
        Summary::new(outcome, &unconfirmed, axes, pace, late)
    }

    fn shut_down(&mut self) -> Result<Vec<DriveId>, LinkFault> {
        let end = self.station.shut_down();
        self.take_events();
        end
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

    fn start_up(&mut self) -> Result<(), Stop> {
        self.wait_for(AxisState::Ready)?;
        let now = self.station.now();
        if self.station.master().enable(now, GROUP).is_err() {
            return Err(Stop::NotReady);
        }
        self.wait_for(AxisState::Streaming)
    }

    fn wait_for(&mut self, state: AxisState) -> Result<(), Stop> {
        let start = self.station.now();
        while self.station.now().us_since(start) < START_UP_LIMIT_US {
            self.station.cycle(|_, _| {})?;
            self.check()?;
            if self.station.master().all_are(GROUP, state) {
                return Ok(());
            }
        }
        Err(Stop::NotReady)
    }

    /// The row of the plan follows the clock: rows of cycles that were missed are passed over, and the axes owe the rest.
    fn follow(&mut self, plan: &Plan, show_progress: bool) -> Result<(), Stop> {
        let last = plan.cycles() as u64 - 1;
        let bar = progress_bar(last, show_progress);
        let mut first = None;
        let mut row = 0;
        while row < last {
            let (places, anchors) = (&self.places, &self.anchors);
            self.station.cycle(|master, number| {
                row = (number - *first.get_or_insert(number)).min(last);
                let offsets = plan.row(row as usize);
                for ((&place, &anchor), offset) in places.iter().zip(anchors).zip(offsets) {
                    // A refusal is an axis that stopped by a fault, which the events tell.
                    let _ = master.set_target(place, anchor.wrapping_add(offset));
                }
            })?;
            if row % PROGRESS_STEP == 0 {
                bar.set_position(row);
            }
            self.check()?;
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
        self.take_events();
        if self.saw_fault {
            return Err(Stop::Fault);
        }
        if interrupt::requests() > 0 {
            return Err(Stop::Interrupted);
        }
        Ok(())
    }

    fn take_events(&mut self) {
        while let Some(event) = self.station.next_event() {
            if let EventKind::Fault(fault) = event.kind {
                self.saw_fault = true;
                let place = event.axis.map(usize::from);
                let axis = self.places.iter().position(|&other| Some(other) == place);
                let axis = axis.map_or(String::new(), |axis| format!(" axis {axis}:"));
                eprintln!("{} s:{axis} {fault}", event.at);
            }
        }
    }
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
