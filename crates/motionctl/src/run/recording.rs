//! The recordings of a motion on real buses, one a bus: opened before anything is sent, written while the motion runs, closed behind it.

use std::path::Path;
use std::time::Instant;

use can_motion::ReadBackScale;

use super::arguments::Arguments;
use super::buses::Bus;
use super::error::RunError;
use super::summary::Summary;
use crate::control::Wishes;
use crate::link::Link;
use crate::live_view::BusView;
use crate::recording::{About, Origin, Recorded, Recorder, RecordingOptions};
use crate::report;
use crate::station::{BusRecorder, Station, StationRecorder};

/// A recording that waits for its motion.
pub(super) struct RunRecording {
    recorder: Recorder,
    about: About,
    start: Instant,
}

/// Opens every file of every bus, when something is to be recorded or watched.
pub(super) fn begin(arguments: &Arguments, buses: &mut [Bus]) -> Result<(), RunError> {
    let start = Instant::now();
    let options = options(arguments, buses);
    // No recording is written over another, or over the motion itself.
    let mut taken: Vec<&Path> = arguments.motion.file().into_iter().collect();
    for (number, (bus, options)) in buses.iter_mut().zip(&options).enumerate() {
        let axes = bus.axes.iter().map(|axis| axis.about.clone()).collect();
        let bit_ns = 1_000_000 / u64::from(arguments.link.bit_rate_kbit().max(1));
        let interface = bus.interface.clone();
        let about = About {
            interface: interface.unwrap_or_else(|| format!("can{number}")),
            ..About::now(Origin::Bus, axes, arguments.cycle_us, bit_ns)
        };
        let recorder = options.open(&about, &taken).map_err(RunError::Recording)?;
        taken.extend(options.files());
        if arguments.live || !recorder.is_idle() {
            bus.link.keep_frames();
            bus.recording = Some(RunRecording {
                recorder,
                about,
                start,
            });
        }
    }
    Ok(())
}

/// What to record of each bus: files of several buses are named apart.
fn options(arguments: &Arguments, buses: &[Bus]) -> Vec<RecordingOptions> {
    let options = &arguments.recording;
    let names: Vec<&str> = buses.iter().map(|bus| bus.name.as_str()).collect();
    match names[..] {
        [_] => vec![options.clone()],
        _ => {
            let tails = tails(&names).into_iter();
            tails.map(|tail| options.named_apart(&tail)).collect()
        }
    }
}

/// What tells the files of the buses apart: the last part of the names of their links, or numbers from 1 where two have the same.
fn tails(names: &[&str]) -> Vec<String> {
    let tails = names.iter().map(|name| {
        // They become names of files: Windows has them without these.
        let last = name.rsplit(['/', '\\', ':']).next().unwrap_or_default();
        last.to_owned()
    });
    let tails: Vec<String> = tails.collect();
    let mut different = tails.clone();
    different.sort_unstable();
    different.dedup();
    if different.len() == tails.len() {
        return tails;
    }
    (1..=names.len()).map(|number| number.to_string()).collect()
}

impl RunRecording {
    /// Closes the files of a motion that did not begin, with the frames that say why.
    pub(super) fn give_up(self, link: &mut Link) {
        let (start, bit_ns) = (self.start, self.about.bit_ns);
        let recorder = BusRecorder::new(self.recorder, start, bit_ns);
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
        wishes: &Wishes,
    ) -> Result<Option<BusView>, RunError> {
        let mut view = None;
        if arguments.live {
            let opened = BusView::open(&self.about, Some(wishes)).map_err(RunError::Terminal)?;
            let (opened, viewer) = opened;
            self.recorder.watch(viewer);
            view = Some(opened);
        }
        let bus = BusRecorder::new(self.recorder, self.start, self.about.bit_ns);
        station.record(StationRecorder::new(bus, places, read_back));
        Ok(view)
    }
}

/// Shows the result in a view that is open until the user leaves it; the drives are off.
pub(super) fn end_view(view: Option<BusView>, results: &[(Summary, Recorded)]) {
    if let (Some(view), Some((summary, _))) = (view, results.first()) {
        view.end(&summary.verdict(), summary.is_completed());
    }
}

/// Writes the pages of a motion that has ended, and notes in the summaries what became of the recordings.
pub(super) fn close(
    arguments: &Arguments,
    buses: &[Bus],
    results: Vec<(Summary, Recorded)>,
) -> Vec<Summary> {
    let options = options(arguments, buses).into_iter();
    let close = |((mut summary, recorded), options): ((Summary, Recorded), RecordingOptions)| {
        let folder = options.report.as_deref();
        let has_page = report::write_and_tell(folder, &recorded, &summary.for_page());
        summary.ending.note_recording(recorded.report, has_page);
        summary
    };
    results.into_iter().zip(options).map(close).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buses_are_told_apart_by_the_end_of_their_links_or_by_numbers() {
        assert_eq!(tails(&["can0", "/dev/ttyACM1"]), ["can0", "ttyACM1"]);
        assert_eq!(
            tails(&["pcan:PCAN_USBBUS1", "tcp:[::1]:7000", r"\\.\COM10"]),
            ["PCAN_USBBUS1", "7000", "COM10"]
        );
        assert_eq!(tails(&["/a/tty", "/b/tty", "can0"]), ["1", "2", "3"]);
    }
}
