//! The recording of wheels on a real bus: opened before anything is sent, written while they turn, closed behind them.

use std::path::Path;
use std::time::Instant;

use can_motion::wheel::{WheelConfig, WheelSnapshot};

use super::follow::{Motion, Wheels, follow};
use super::summary::{Counts, Summary};
use super::{Arguments, CYCLE_US};
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::recorder::{RecordedWheel, WheelRecorder};
use crate::hub::station::WheelStation;
use crate::link::Link;
use crate::live_view::BusView;
use crate::recording::{
    About, AxisAbout, AxisOutcome, Origin, Outcome, Quantity, Recorded, Recorder,
};
use crate::report;
use crate::station::BusRecorder;

/// Files that are open, and wheels that do not turn yet.
pub(super) struct WheelRecording<'a> {
    arguments: &'a Arguments,
    recorder: Recorder,
    about: About,
    start: Instant,
}

/// Wheels that have come to rest without power, and what is left to be closed.
pub(super) struct Ended<'a> {
    pub(super) counts: Counts,
    recorded: Recorded,
    view: Option<BusView>,
    axes: Vec<AxisOutcome>,
    arguments: &'a Arguments,
}

impl<'a> WheelRecording<'a> {
    /// Opens every file; `taken` are those that are read.
    ///
    /// # Errors
    /// [`HubError::Recording`].
    pub(super) fn open(
        arguments: &'a Arguments,
        axes: Vec<AxisAbout>,
        taken: Option<&Path>,
        link: &mut Link,
    ) -> Result<Self, HubError> {
        let start = Instant::now();
        let about = About {
            quantity: Quantity::Speed,
            interface: arguments.link.interface().unwrap_or("can0").to_owned(),
            ..About::now(Origin::Bus, axes, CYCLE_US, link.bit_rate().bit_ns())
        };
        let taken: Vec<&Path> = [taken, arguments.odometry.as_deref()]
            .into_iter()
            .flatten()
            .collect();
        let recorder = arguments.recording.open(&about, &taken);
        let recorder = recorder.map_err(HubError::Recording)?;
        if arguments.live || !recorder.is_idle() {
            link.keep_frames();
        }
        Ok(Self {
            arguments,
            recorder,
            about,
            start,
        })
    }

    /// Goes on with wheels that may turn. Where they must not, the files are closed, with the frames that say why.
    ///
    /// # Errors
    /// Why the wheels must not turn.
    pub(super) fn with<T>(
        self,
        prepared: Result<T, HubError>,
        link: &mut Link,
    ) -> Result<(Self, T), HubError> {
        match prepared {
            Ok(prepared) => Ok((self, prepared)),
            Err(error) => Err(self.refuse(error, link)),
        }
    }

    fn refuse(self, error: HubError, link: &mut Link) -> HubError {
        let recorder = BusRecorder::new(self.recorder, self.start, self.about.bit_ns);
        // What is not complete was told.
        drop(recorder.finish(link));
        error
    }

    /// Brings the wheels up, lets them follow, switches them off. The page of wheels that could not end as they should says why.
    ///
    /// # Errors
    /// As [`WheelStation::new`], [`follow`] and [`WheelStation::end`].
    pub(super) fn follow(
        mut self,
        bus: &mut Bus,
        configs: &[WheelConfig],
        wheels: &Wheels,
        motion: &mut dyn Motion,
    ) -> Result<Ended<'a>, HubError> {
        let view = self.open_view();
        let (this, view) = self.with(view, bus.link())?;
        let checked = WheelStation::check(bus.link(), configs, CYCLE_US);
        let (this, ()) = this.with(checked, bus.link())?;
        let mut station = WheelStation::new(bus.link(), configs, CYCLE_US)?;
        let places = wheels.places().iter().zip(&wheels.looks);
        let recorded = places.map(|(&place, look)| RecordedWheel {
            place,
            speed_resolution: look.speed_resolution,
        });
        let recorder = BusRecorder::new(this.recorder, this.start, this.about.bit_ns);
        station.record(WheelRecorder::new(recorder, recorded));
        let followed = follow(&mut station, wheels, motion);
        let snapshots: Vec<WheelSnapshot> = station.snapshots().collect();
        let ended = station.end(followed);
        let recorded = station.finish_recording();
        let places = wheels.places().iter();
        let outcomes = places.filter_map(|&place| Some(outcome_of(snapshots.get(place)?)));
        let axes: Vec<AxisOutcome> = outcomes.collect();
        match ended {
            Ok((counts, _)) => Ok(Ended {
                counts,
                recorded,
                view,
                axes,
                arguments: this.arguments,
            }),
            Err(error) => {
                let verdict = format!("NOT complete: {error}");
                if let Some(view) = view {
                    view.end(&verdict, false);
                }
                let outcome = Outcome {
                    verdict,
                    is_good: false,
                    facts: Vec::new(),
                    axes,
                };
                let folder = this.arguments.recording.report.as_deref();
                report::write_and_tell(folder, &recorded, &outcome);
                Err(error)
            }
        }
    }

    fn open_view(&mut self) -> Result<Option<BusView>, HubError> {
        if !self.arguments.live {
            return Ok(None);
        }
        let (view, viewer) = BusView::open(&self.about, None).map_err(HubError::Terminal)?;
        self.recorder.watch(viewer);
        Ok(Some(view))
    }
}

impl Ended<'_> {
    /// Shows the result where somebody watches, writes the page, and notes in the summary what became of the recording.
    pub(super) fn close(self, summary: &mut Summary) {
        let outcome = summary.for_page(self.axes);
        if let Some(view) = self.view {
            view.end(&outcome.verdict, outcome.is_good);
        }
        let folder = self.arguments.recording.report.as_deref();
        let has_page = report::write_and_tell(folder, &self.recorded, &outcome);
        summary.note_recording(self.recorded.report, has_page);
    }
}

fn outcome_of(wheel: &WheelSnapshot) -> AxisOutcome {
    AxisOutcome {
        set_points: Some(wheel.counters.set_points.into()),
        received_counts: None,
        reply_timeouts: Some(wheel.counters.timeouts),
        state: match wheel.fault {
            Some(fault) => fault.to_string(),
            None => wheel.state.to_string(),
        },
    }
}
