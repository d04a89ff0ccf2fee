//! What the tests do again and again: bring the machine up, and look at the set-points on the wire.

use drive_sim::{DynDrive, Record};
use dyn_can::FunctionCode;
use embedded_can::{Frame as _, Id};

use crate::rig::{Contact, Rig};

/// Milliseconds in which the drives are up, known and at rest.
const READY_MS: u64 = 400;
/// Milliseconds from enable to the first set-points: standstill, a second anchor, confirmation.
const ENABLE_MS: u64 = 600;

impl Rig {
    /// Closes the stop circuit and lets the firmware find its drives.
    pub fn make_ready(&mut self) {
        self.close(Contact::Stop);
        self.run_ms(READY_MS);
    }

    /// Makes enable active and waits until every drive gets set-points.
    ///
    /// # Panics
    /// When a drive is not enabled afterwards.
    pub fn enable(&mut self) {
        self.close(Contact::Enable);
        self.run_ms(ENABLE_MS);
        assert!(
            self.wire().devices().all(DynDrive::is_enabled),
            "{:#?}",
            self.board().log()
        );
        assert!(
            self.wire()
                .devices()
                .all(|drive| drive.books().pd_frames > 0)
        );
    }

    /// From power-on to a running motion.
    pub fn bring_up(&mut self) {
        self.make_ready();
        self.enable();
        self.close(Contact::Run);
        self.run_ms(200);
    }

    /// Set-points that began at or after `from_ns` and were received.
    pub fn set_points_since(&self, from_ns: u64) -> impl Iterator<Item = &Record> {
        self.from_board()
            .filter(move |record| record.start_ns >= from_ns && record.outcome.is_received())
            .filter(|record| is_set_point(record))
    }

    /// Command counts that the drives got by set-points, in their order.
    #[must_use]
    pub fn commanded_counts(&self) -> Vec<i64> {
        self.wire()
            .devices()
            .map(DynDrive::commanded_counts)
            .collect()
    }

    /// The counts that the latest line of the log with `text` lists in brackets.
    #[must_use]
    pub fn logged_counts(&self, text: &str) -> Option<Vec<i64>> {
        let line = self
            .board()
            .log()
            .iter()
            .rev()
            .find(|line| line.contains(text))?;
        let list = line.split_once('[')?.1.split_once(']')?.0;
        list.split(',')
            .map(|number| number.trim().parse().ok())
            .collect()
    }

    /// The latest figure before `unit` in the line of statistics, such as `late`.
    #[must_use]
    pub fn statistic(&self, unit: &str) -> Option<u64> {
        let line = self
            .board()
            .log()
            .iter()
            .rev()
            .find(|line| line.contains(" cycles, "))?;
        let before = line.split_once(&format!(" {unit}"))?.0;
        before.rsplit(' ').next()?.parse().ok()
    }
}

/// Whether a record is a streamed set-point.
#[must_use]
pub fn is_set_point(record: &Record) -> bool {
    matches!(record.frame.id(), Id::Standard(id) if FunctionCode::from_can_id(id.as_raw()) == FunctionCode::GoRelativePosPd)
}
