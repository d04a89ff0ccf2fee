//! The traffic of the bench as a log.

use std::path::Path;

use drive_sim::{Bench, DynDrive, LogMode, NodeId};

use super::board::Seat;
use super::error::BenchError;
use crate::recording::{About, Origin, Recorder, RecordingOptions};
use crate::sim::wire_frame;

/// A log in the making.
pub(super) struct BenchLog {
    recorder: Recorder,
    bit_ns: u64,
    /// What counts as the master.
    board: Option<NodeId>,
}

impl BenchLog {
    /// Opens the file, where there shall be one.
    pub(super) fn open(
        path: Option<&Path>,
        bench: &mut Bench<DynDrive>,
        board: Option<&Seat>,
    ) -> Result<Option<Self>, BenchError> {
        let Some(path) = path else { return Ok(None) };
        bench.bus_mut().set_log(LogMode::Full);
        let bit_ns = bench.bus().bit_rate().bit_ns();
        let about = About::now(Origin::Simulation, Vec::new(), 1_000, bit_ns);
        let options = RecordingOptions {
            candump: Some(path.to_owned()),
            ..RecordingOptions::default()
        };
        let recorder = options.open(&about, &[]).map_err(BenchError::Candump)?;
        Ok(Some(Self {
            recorder,
            bit_ns,
            board: board.map(Seat::node),
        }))
    }

    /// Writes what was on the bus meanwhile.
    pub(super) fn drain(&mut self, bench: &mut Bench<DynDrive>) {
        for record in bench.bus_mut().log_mut().drain() {
            let is_from_master = Some(record.node) == self.board;
            if let Some(frame) = wire_frame(&record, is_from_master, self.bit_ns) {
                self.recorder.frame(frame);
            }
        }
    }

    /// Closes the file.
    ///
    /// # Errors
    /// When it could not be written to its end.
    pub(super) fn finish(self) -> Result<(), BenchError> {
        let report = self.recorder.finish().report;
        let stopped = report.files.iter().find_map(|file| file.stopped.clone());
        match stopped.filter(|_| !report.is_complete()) {
            None => Ok(()),
            Some(reason) => Err(BenchError::CandumpStopped { reason }),
        }
    }
}
