//! What simulations and real motions feed.

use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use schemars::JsonSchema;
use serde::Serialize;

use super::about::AxisNaming;
use super::event::{Happening, Kind};
use super::item::Item;
use super::keep::Keep;
use super::keeper::{Counts, FileReport, Keeper};
use super::model::Recording;
use super::queue::{QUEUE, Queued, Viewer};
use super::sample::Sample;
use super::wire_frame::WireFrame;

/// Takes every cycle, frame and event, and never delays whoever hands them over in real time.
#[derive(Default)]
pub(crate) struct Recorder {
    /// Written at once: time waits for them.
    direct: Vec<Keeper>,
    queued: Vec<Queued>,
    viewer: Option<Viewer>,
    /// The record in memory, where time waits.
    model: Option<Recording>,
    /// The same behind a queue.
    shared: Option<Arc<Mutex<Recording>>>,
    given: Counts,
}

/// What a recorder leaves.
#[derive(Default)]
pub(crate) struct Recorded {
    /// What the page is made of.
    pub(crate) recording: Option<Recording>,
    pub(crate) report: RecordingReport,
}

/// What became of the files.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub(crate) struct RecordingReport {
    /// Everything that was to be recorded.
    pub(crate) cycles: u64,
    pub(crate) frames: u64,
    pub(crate) files: Vec<FileReport>,
}

/// A result together with what became of its recording, for JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct WithRecording<'a, T> {
    #[serde(flatten)]
    pub(crate) result: &'a T,
    pub(crate) recording: &'a RecordingReport,
}

impl RecordingReport {
    /// Whether every file has everything; one that nobody read any longer is no failure.
    pub(crate) fn is_complete(&self) -> bool {
        let mut files = self.files.iter();
        files.all(|file| file.stopped.is_none() || file.reader_has_gone)
    }
}

impl Recorder {
    /// Adds a file that is written at once.
    pub(super) fn add_direct(&mut self, name: String, keep: Box<dyn Keep>) {
        self.direct.push(Keeper::new(name, keep, "the simulation"));
    }

    /// Adds a file behind a queue.
    pub(super) fn add_queued(&mut self, name: String, keep: Box<dyn Keep>) -> io::Result<()> {
        let keeper = Keeper::new(name.clone(), keep, "the motion");
        self.queued.push(Queued::start(name, keeper, QUEUE)?);
        Ok(())
    }

    /// Keeps a record in memory, for a page or a view of a simulation.
    pub(crate) fn keep_model(&mut self, recording: Recording) {
        self.model = Some(recording);
    }

    /// The same behind a queue: its memory is filled by another thread.
    pub(super) fn keep_model_queued(
        &mut self,
        name: String,
        recording: Recording,
    ) -> io::Result<()> {
        let shared = Arc::new(Mutex::new(recording));
        self.add_queued(name, Box::new(Shared(Arc::clone(&shared))))?;
        self.shared = Some(shared);
        Ok(())
    }

    /// Lets somebody watch.
    pub(crate) fn watch(&mut self, viewer: Viewer) {
        self.viewer = Some(viewer);
    }

    /// Whether nobody wants anything, so that nothing needs to be handed over.
    pub(crate) fn is_idle(&self) -> bool {
        self.direct.is_empty()
            && self.queued.is_empty()
            && self.viewer.is_none()
            && self.model.is_none()
    }

    /// The record in memory of a simulation.
    pub(crate) fn model(&self) -> Option<&Recording> {
        self.model.as_ref()
    }

    pub(crate) fn cycle(&mut self, sample: Sample) {
        self.push(Item::Cycle(sample));
    }

    pub(crate) fn frame(&mut self, frame: WireFrame) {
        self.push(Item::Frame(frame));
    }

    /// An event; `axis` is its place in the motion, not in the master.
    pub(crate) fn happened(
        &mut self,
        at_us: u64,
        axis: Option<usize>,
        kind: Kind,
        text: impl Into<String>,
    ) {
        self.push(Item::Event(Happening {
            at_us,
            axis,
            kind,
            text: text.into(),
            times: 1,
        }));
    }

    /// The next cycle, of this number, is the first of the motion.
    pub(crate) fn motion_begins(&mut self, at_us: u64, number: u64) {
        self.push(Item::MotionBegins { at_us, number });
        self.happened(at_us, None, Kind::Phase, "the motion begins");
    }

    /// A stream names its axes.
    pub(crate) fn name_axes(&mut self, naming: Vec<AxisNaming>) {
        self.push(Item::Naming(naming));
    }

    fn push(&mut self, item: Item) {
        self.given.add(&item);
        if let Some(model) = &mut self.model {
            model.add(&item);
        }
        for keeper in &mut self.direct {
            keeper.take(&item);
        }
        if self.queued.is_empty() && self.viewer.is_none() {
            return;
        }
        let item = Arc::new(item);
        for queued in &mut self.queued {
            queued.push(&item);
        }
        if let Some(viewer) = &self.viewer {
            viewer.push(&item);
        }
    }

    /// Closes every file.
    pub(crate) fn finish(self) -> Recorded {
        let direct = self.direct.into_iter().map(|mut keeper| keeper.finish());
        let mut files: Vec<FileReport> = direct.collect();
        files.extend(self.queued.into_iter().map(Queued::finish));
        // Its thread has ended, or is stuck elsewhere than in memory.
        let taken = self.shared.and_then(Arc::into_inner);
        let taken = taken.map(|shared| shared.into_inner().unwrap_or_else(PoisonError::into_inner));
        Recorded {
            recording: self.model.or(taken),
            report: RecordingReport {
                cycles: self.given.cycles,
                frames: self.given.frames,
                files,
            },
        }
    }
}

/// A record in memory that is taken back at the end.
struct Shared(Arc<Mutex<Recording>>);

impl Keep for Shared {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        let mut recording = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        recording.add(item);
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}
