//! What the tests do again and again: bring the machine up, and look at the set-points on the wire.

use drive_sim::{DynDrive, Frame, Record};
use dyn_can::{Dialect, FunctionCode, Request};
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
            self.servos().all(DynDrive::is_enabled),
            "{:#?}",
            self.board().log()
        );
        assert!(self.servos().all(|drive| drive.books().pd_frames > 0));
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

    /// The largest step of these set-points, in command counts.
    ///
    /// # Panics
    /// When one of them does not decode.
    #[must_use]
    pub fn largest_step_since(&self, from_ns: u64) -> u32 {
        let steps = self.set_points_since(from_ns).map(|record| {
            let frame = dyn_can::DataFrame::from_can(&record.frame).expect("a data frame");
            match Request::decode(&frame, &Dialect::V1_6A) {
                Ok((_, Request::GoRelativePosPd(step))) => i32::from(step.get()).unsigned_abs(),
                other => panic!("{other:?} is no set-point"),
            }
        });
        steps.max().unwrap_or(0)
    }

    /// Commands to enable or disable a drive that the board put on the wire at or after `from_ns` and that were received.
    pub fn switches_since(&self, from_ns: u64) -> impl Iterator<Item = &Record> {
        self.from_board()
            .filter(move |record| record.start_ns >= from_ns && record.outcome.is_received())
            .filter(|record| function(&record.frame) == Some(FunctionCode::ServoDisable))
    }

    /// Whether every drive is enabled, or none.
    ///
    /// # Panics
    /// When some are and some are not.
    #[must_use]
    pub fn are_enabled(&self) -> bool {
        let all = self.servos().all(DynDrive::is_enabled);
        let any = self.servos().any(DynDrive::is_enabled);
        assert_eq!(all, any, "{:#?}", self.board().log());
        all
    }

    /// Command counts that the drives got by set-points, in their order.
    #[must_use]
    pub fn commanded_counts(&self) -> Vec<i64> {
        self.servos().map(DynDrive::commanded_counts).collect()
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
    is_set_point_frame(&record.frame)
}

/// Whether a frame is a streamed set-point.
#[must_use]
pub fn is_set_point_frame(frame: &Frame) -> bool {
    function(frame) == Some(FunctionCode::GoRelativePosPd)
}

fn function(frame: &Frame) -> Option<FunctionCode> {
    match frame.id() {
        Id::Standard(id) => Some(FunctionCode::from_can_id(id.as_raw())),
        Id::Extended(_) => None,
    }
}
