//! The drives of a board on and off.

use std::time::{Duration, Instant};

use board_link::host::RequestError;
use board_link::message::{BoardState, Request};

use super::BoardMotion;
use super::follow::{Follow, POLL, Stop};
use super::outcome::End;
use crate::board::error::BoardError;
use crate::interrupt;
use crate::output::tell;
use crate::recording::Kind;

/// Time for the drives to be enabled.
const ENABLE_TIME: Duration = Duration::from_secs(10);
/// Time for them to slow down and to be off.
const DISABLE_TIME: Duration = Duration::from_secs(5);

impl From<BoardError> for End {
    fn from(error: BoardError) -> Self {
        match error {
            BoardError::Refused { .. } | BoardError::NotReady { .. } => {
                Self::Stopped(error.to_string())
            }
            error => Self::LinkFailed(error.to_string()),
        }
    }
}

impl<M: BoardMotion> Follow<'_, M> {
    /// Enables the drives, and waits until a snapshot says that they are.
    pub(super) fn enable(&mut self, snapshot_hz: u32) -> Result<(), Stop> {
        let cycles_per_second = 1_000_000 / self.motion.cycle_us().max(1);
        let period = (cycles_per_second / snapshot_hz).max(1);
        self.session
            .ask("send snapshots", Request::Snapshots { period })?;
        match self.session.ask("enable its drives", Request::Enable) {
            // Its answer comes when they are enabled, and that may be later than one is waited for: snapshots say so.
            Ok(_)
            | Err(BoardError::Request {
                source: RequestError::TimedOut { .. },
                ..
            }) => {}
            Err(error) => return Err(error.into()),
        }
        self.await_enabled()
    }

    fn await_enabled(&mut self) -> Result<(), Stop> {
        let until = Instant::now() + ENABLE_TIME;
        let mut has_begun = false;
        loop {
            let is_fresh = self.take(POLL)?;
            if interrupt::requests() > 0 {
                return Err(End::Interrupted);
            }
            let is = self.latest.state;
            has_begun |= is_fresh && is == BoardState::GettingReady;
            let has_failed = match is {
                BoardState::Enabled if is_fresh => return Ok(()),
                BoardState::Off | BoardState::Halted => has_begun && is_fresh,
                BoardState::GettingReady | BoardState::Enabled | BoardState::Stopping => false,
                _ => is_fresh,
            };
            if has_failed || Instant::now() >= until {
                return Err(BoardError::NotReady { state: is }.into());
            }
        }
    }

    /// Switches the drives off and gives the command back; whether the board says that they are off.
    pub(super) fn end(&mut self) -> bool {
        self.recording
            .happened(None, Kind::Phase, "the motion ends".to_owned());
        if let Err(error) = self.session.ask("disable its drives", Request::Disable) {
            tell(error);
        }
        let is_off = self.await_off();
        if let Err(error) = self.session.leave() {
            tell(error);
        }
        is_off
    }

    /// Gives the command back, and leaves the drives as they are; whether that is enabled.
    pub(super) fn leave_enabled(&mut self) -> bool {
        self.recording
            .happened(None, Kind::Phase, "the motion ends".to_owned());
        self.latest.state == BoardState::Enabled && self.session.leave().is_ok()
    }

    fn await_off(&mut self) -> bool {
        let until = Instant::now() + DISABLE_TIME;
        let mut is_fresh = false;
        while Instant::now() < until {
            match self.take(POLL) {
                Ok(is_snapshot) => is_fresh |= is_snapshot,
                // What was under way has ended; nothing else is of interest now.
                Err(End::Stopped(_)) => {}
                Err(_) => return false,
            }
            // A fault says nothing of the power.
            let is_off = matches!(
                self.latest.state,
                BoardState::Off | BoardState::StopOpen | BoardState::EnableInactive
            );
            if is_fresh && is_off {
                return true;
            }
        }
        false
    }

    /// The board may be there again, and stands then: once more, with a new session.
    pub(super) fn try_to_end(&mut self) -> bool {
        self.session.take_command().is_ok() && {
            let period = 20;
            let watched = self
                .session
                .ask("send snapshots", Request::Snapshots { period });
            watched.is_ok() && self.end()
        }
    }
}
