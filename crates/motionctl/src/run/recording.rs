//! The recording of a motion on a real bus: opened before anything is sent, written while the motion runs, closed behind it.

use can_motion::ReadBackScale;

use super::arguments::Arguments;
use super::error::RunError;
use super::live::LiveView;
use super::summary::Summary;
use crate::link::Link;
use crate::output::tell;
use crate::recording::{About, AxisAbout, Origin, Recorded, Recorder};
use crate::report;
use crate::station::{Station, StationRecorder};

/// A recording that waits for its motion.
pub(super) struct RunRecording {
    recorder: Recorder,
    about: About,
    start: std::time::Instant,
}

impl RunRecording {
    /// Opens every file; `None` when nothing is to be recorded or watched.
    pub(super) fn begin(
        arguments: &Arguments,
        axes: Vec<AxisAbout>,
    ) -> Result<Option<Self>, RunError> {
        let start = std::time::Instant::now();
        let link = &arguments.link;
        let bit_ns = 1_000_000 / u64::from(link.bit_rate_kbit().max(1));
        let about = About {
            interface: link.interface().unwrap_or("can0").to_owned(),
            ..About::now(Origin::Bus, axes, arguments.cycle_us, bit_ns)
        };
        let input = arguments.motion.file();
        let recorder = arguments.recording.open(&about, input);
        let recorder = recorder.map_err(RunError::Recording)?;
        Ok((arguments.live || !recorder.is_idle()).then_some(Self {
            recorder,
            about,
            start,
        }))
    }

    /// Closes the files of a motion that did not begin, with the frames that say why.
    pub(super) fn give_up(self, link: &mut Link) {
        let (start, bit_ns) = (self.start, self.about.bit_ns);
        let recorder = StationRecorder::new(self.recorder, start, &[], &[], bit_ns);
        // What is not complete was told.
        drop(recorder.finish(link));
    }

    /// Lets the station feed it, and opens the view when one is wanted.
    pub(super) fn attach(
        mut self,
        arguments: &Arguments,
        station: &mut Station<'_>,
        places: &[usize],
        read_back: &[ReadBackScale],
    ) -> Result<Option<LiveView>, RunError> {
        let mut view = None;
        if arguments.live {
            let (opened, viewer) = LiveView::open(&self.about).map_err(RunError::Terminal)?;
            self.recorder.watch(viewer);
            view = Some(opened);
        }
        let recorder = StationRecorder::new(
            self.recorder,
            self.start,
            places,
            read_back,
            self.about.bit_ns,
        );
        station.record(recorder);
        Ok(view)
    }
}

/// Writes the page of a motion that has ended; false when one was wanted and there is none.
pub(super) fn write_page(arguments: &Arguments, recorded: &Recorded, summary: &Summary) -> bool {
    let Some(folder) = &arguments.recording.report else {
        return true;
    };
    let Some(recording) = &recorded.recording else {
        tell("the page is not written: its numbers are not whole");
        return false;
    };
    match report::write(folder, recording, &summary.for_page()) {
        Ok(page) => {
            tell(format_args!("report: {}", page.display()));
            true
        }
        Err((path, source)) => {
            tell(format_args!("cannot write {}: {source}", path.display()));
            false
        }
    }
}
