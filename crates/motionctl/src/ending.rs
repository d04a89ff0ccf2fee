//! The exit status of a motion, and what became of its recording.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;

use crate::exit;
use crate::recording::RecordingReport;

/// What ended a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The motion itself, or what follows its set-points.
    Itself,
    /// Ctrl-C, or an order to stop.
    Asked,
    /// The link failed: nobody knows what the axes do.
    Unknown,
}

/// How a motion ended for whoever started it.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Ending {
    recording: RecordingReport,
    #[serde(skip)]
    exit_code: u8,
}

impl Ending {
    /// Of a motion without a recording; `is_off` says that every drive confirms to be disabled that shall be.
    pub(crate) fn new(cause: Cause, completed: bool, is_off: bool) -> Self {
        let exit_code = match cause {
            Cause::Unknown => exit::LINK_FAILED,
            Cause::Asked if is_off => exit::INTERRUPTED,
            _ if completed => 0,
            _ => exit::BROKEN_PROMISE,
        };
        Self {
            recording: RecordingReport::default(),
            exit_code,
        }
    }

    /// Notes what became of the recording, and whether the page that was wanted is there.
    pub(crate) fn note_recording(&mut self, report: RecordingReport, has_page: bool) {
        if self.exit_code == 0 && !(report.is_complete() && has_page) {
            self.exit_code = exit::BROKEN_PROMISE;
        }
        self.recording = report;
    }

    /// The larger, the worse: nobody knows, then not as promised, then ended before.
    pub(crate) const fn severity(&self) -> u8 {
        match self.exit_code {
            exit::LINK_FAILED => 3,
            0 => 0,
            exit::INTERRUPTED => 1,
            _ => 2,
        }
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        self.exit_code.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_not_off_has_not_merely_been_asked_to_stop() {
        for (cause, completed, is_off, expected) in [
            (Cause::Itself, true, true, 0),
            (Cause::Itself, false, true, exit::BROKEN_PROMISE),
            (Cause::Asked, false, true, exit::INTERRUPTED),
            (Cause::Asked, false, false, exit::BROKEN_PROMISE),
            (Cause::Unknown, false, true, exit::LINK_FAILED),
        ] {
            let ending = Ending::new(cause, completed, is_off);
            assert_eq!(ending.exit_code, expected, "{cause:?} {completed} {is_off}");
        }
    }

    #[test]
    fn a_recording_that_is_not_complete_spoils_what_was_good_and_nothing_else() {
        let mut good = Ending::new(Cause::Itself, true, true);
        good.note_recording(RecordingReport::default(), true);
        assert_eq!(good.exit_code, 0);
        good.note_recording(RecordingReport::default(), false);
        assert_eq!(good.exit_code, exit::BROKEN_PROMISE);
        let mut asked = Ending::new(Cause::Asked, false, true);
        asked.note_recording(RecordingReport::default(), false);
        assert_eq!(asked.exit_code, exit::INTERRUPTED);
    }
}
