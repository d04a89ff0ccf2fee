//! One file of a recording: what is in it, what is lost, and why.

use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

use schemars::JsonSchema;
use serde::Serialize;

use super::item::Item;
use super::keep::Keep;
use crate::output::tell;

/// Items and time after which they are brought to their place: what a file that fails can lose unseen is less.
const FLUSH_ITEMS: u64 = 1_000;
const FLUSH_TIME: Duration = Duration::from_millis(500);

/// Numbers of cycles and frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub(crate) struct Counts {
    pub(crate) cycles: u64,
    pub(crate) frames: u64,
}

impl Counts {
    pub(super) fn add(&mut self, item: &Item) {
        match item {
            Item::Cycle(_) => self.cycles += 1,
            Item::Frame(_) => self.frames += 1,
            Item::Event(_) | Item::MotionBegins { .. } | Item::Naming(_) => {}
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            cycles: self.cycles + other.cycles,
            frames: self.frames + other.frames,
        }
    }
}

/// What became of one file.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct FileReport {
    pub(crate) path: String,
    /// What is in it. A log holds no cycles and a table no frames: these count what it was given.
    pub(crate) recorded: Counts,
    pub(crate) lost: Counts,
    /// Why it is not complete.
    pub(crate) stopped: Option<String>,
    /// Nobody read it any longer, which is no failure.
    #[serde(skip)]
    pub(crate) reader_has_gone: bool,
}

/// One file with its books.
pub(super) struct Keeper {
    name: String,
    keep: Box<dyn Keep>,
    recorded: Counts,
    /// Since the last flush.
    pending: Counts,
    pending_items: u64,
    flushed_at: Instant,
    lost: Counts,
    stopped: Option<io::Error>,
    /// What goes on without the file.
    goes_on: &'static str,
}

impl Keeper {
    /// `goes_on` is what a failure does not stop, as in `the motion`.
    pub(super) fn new(name: String, keep: Box<dyn Keep>, goes_on: &'static str) -> Self {
        Self {
            name,
            keep,
            recorded: Counts::default(),
            pending: Counts::default(),
            pending_items: 0,
            flushed_at: Instant::now(),
            lost: Counts::default(),
            stopped: None,
            goes_on,
        }
    }

    /// Keeps an item, or counts it when the file has failed.
    pub(super) fn take(&mut self, item: &Item) {
        if self.stopped.is_some() {
            self.lost.add(item);
            return;
        }
        self.pending.add(item);
        self.pending_items += 1;
        let mut kept = self.keep.keep(item);
        if kept.is_ok() && self.pending_items >= FLUSH_ITEMS {
            kept = self.flush();
        }
        self.judge(kept);
    }

    /// Brings what waits for too long to its place.
    pub(super) fn rest(&mut self) {
        if self.stopped.is_none()
            && self.pending_items > 0
            && self.flushed_at.elapsed() >= FLUSH_TIME
        {
            let flushed = self.flush();
            self.judge(flushed);
        }
    }

    /// Ends the recording with what is in the file until now.
    pub(super) fn stop(&mut self, reason: io::Error, lost: Counts) {
        self.lost = self.lost.plus(lost);
        if self.stopped.is_none() {
            self.stopped = Some(reason);
        }
    }

    /// Says why nothing more is recorded; the counts come at the end.
    pub(super) fn tell_of_stop(&self) {
        if let Some(reason) = &self.stopped {
            tell(format_args!(
                "the recording {} stopped: {reason}; {} goes on",
                self.name, self.goes_on
            ));
        }
    }

    /// Closes the file.
    pub(super) fn finish(&mut self) -> FileReport {
        // Also of a file that was stopped because it is too slow: what is in it can be read.
        let finished = self.flush().and_then(|()| self.keep.finish());
        if self.stopped.is_none() {
            self.judge(finished);
        }
        if self.stopped.is_some() {
            tell(format_args!(
                "the recording {} is not complete: {} cycles and {} frames recorded, {} cycles and {} frames lost",
                self.name,
                self.recorded.cycles,
                self.recorded.frames,
                self.lost.cycles,
                self.lost.frames
            ));
        }
        FileReport {
            path: self.name.clone(),
            recorded: self.recorded,
            lost: self.lost,
            stopped: self.stopped.as_ref().map(ToString::to_string),
            reader_has_gone: self
                .stopped
                .as_ref()
                .is_some_and(|error| error.kind() == ErrorKind::BrokenPipe),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.flushed_at = Instant::now();
        self.keep.flush()?;
        self.recorded = self.recorded.plus(self.pending);
        (self.pending, self.pending_items) = (Counts::default(), 0);
        Ok(())
    }

    fn judge(&mut self, kept: io::Result<()>) {
        if let Err(reason) = kept {
            // What was not flushed may be in the file in part, and nobody knows which.
            let pending = core::mem::take(&mut self.pending);
            self.stop(reason, pending);
            self.tell_of_stop();
        }
    }
}
