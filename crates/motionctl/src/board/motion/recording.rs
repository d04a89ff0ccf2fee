//! The recordings of a motion on a board, as far as its snapshots carry: what the set-points and the positions were, and what happened.

use std::path::Path;

use board_link::message::Snapshot;

use super::axes::Axis;
use crate::board::error::BoardError;
use crate::recording::{
    About, AxisNaming, AxisSample, Kind, Origin, Recorded, Recorder, RecordingOptions, Sample,
};

/// A recording in the making.
pub(in crate::board) struct BoardRecording {
    recorder: Recorder,
    axes: Vec<Axis>,
    cycle_us: u32,
    /// The cycle of the board at which it began.
    first_cycle: Option<u64>,
    latest_us: u64,
}

impl BoardRecording {
    /// Opens every file, for axes of the board at a port; none of them is one of those that are `taken`.
    ///
    /// # Errors
    /// When one cannot be made.
    pub(in crate::board) fn open(
        options: &RecordingOptions,
        port: &str,
        taken: Option<&Path>,
        (axes, cycle_us): (&[Axis], u32),
    ) -> Result<Self, BoardError> {
        let abouts = axes.iter().map(|axis| axis.about.clone()).collect();
        let about = About {
            interface: port.to_owned(),
            ..About::now(Origin::Bus, abouts, cycle_us, 1_000)
        };
        let taken: Vec<&Path> = taken.into_iter().collect();
        let recorder = options.open(&about, &taken);
        Ok(Self {
            recorder: recorder.map_err(BoardError::Recording)?,
            axes: axes.to_vec(),
            cycle_us,
            first_cycle: None,
            latest_us: 0,
        })
    }

    /// The axes at a moment.
    pub(super) fn snapshot(&mut self, snapshot: &Snapshot) {
        let first = *self.first_cycle.get_or_insert(snapshot.cycle);
        let number = snapshot.cycle.saturating_sub(first);
        self.latest_us = number * u64::from(self.cycle_us);
        let sample = |axis: &Axis| {
            let told = snapshot.axes.get(axis.place)?;
            Some(AxisSample {
                target: told.target,
                sent: told.target,
                position: Some(told.position.into()),
                backlog: 0,
                status_age_us: None,
                position_age_us: None,
                state: None,
            })
        };
        self.recorder.cycle(Sample {
            at_us: self.latest_us,
            number,
            // The bus is that of the board.
            load: 0.0,
            is_late: false,
            axes: self.axes.iter().filter_map(sample).collect(),
            wheels: Vec::new(),
        });
    }

    /// The motion begins with the next snapshot.
    pub(super) fn motion_begins(&mut self) {
        let number = self.latest_us / u64::from(self.cycle_us.max(1)) + 1;
        self.recorder.motion_begins(self.latest_us, number);
    }

    /// Something happened; `place` is that of an axis of the board.
    pub(super) fn happened(&mut self, place: Option<usize>, kind: Kind, text: String) {
        let axis = place.and_then(|place| self.axes.iter().position(|axis| axis.place == place));
        self.recorder.happened(self.latest_us, axis, kind, text);
    }

    /// What the axes are called from now on.
    pub(super) fn name_axes(&mut self, naming: Vec<AxisNaming>) {
        self.recorder.name_axes(naming);
    }

    /// Closes every file.
    pub(in crate::board) fn finish(self) -> Recorded {
        self.recorder.finish()
    }
}
