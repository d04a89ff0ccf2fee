//! How far a connection to a board is.

use super::clock::ClockEstimate;
use super::exchange::Exchange;
use crate::message::Info;

/// How far a connection is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    Greeting,
    Claiming,
    Online,
}

/// The connection to a board.
#[derive(Debug)]
pub(super) struct Connection {
    pub(super) phase: Phase,
    pub(super) session: u32,
    pub(super) info: Option<Info>,
    /// When it had come.
    pub(super) met_us: u64,
    pub(super) clock: ClockEstimate,
    /// One request at a time.
    pub(super) exchange: Option<Exchange>,
    /// When the session was last heard of by the board, as far as is known.
    pub(super) alive_us: u64,
    pub(super) synchronised_us: u64,
    /// Whether the board was started anew.
    pub(super) is_reset: bool,
}

impl Connection {
    pub(super) const fn new(seed: u32) -> Self {
        Self {
            phase: Phase::Greeting,
            session: next_session(seed),
            info: None,
            met_us: 0,
            clock: ClockEstimate::new(1),
            exchange: None,
            alive_us: 0,
            synchronised_us: 0,
            is_reset: false,
        }
    }

    /// Anew, with a session that no board has heard of.
    pub(super) fn restart(&mut self) {
        self.phase = Phase::Greeting;
        self.session = next_session(self.session);
        self.exchange = None;
    }
}

/// Another number than 0. The constants are those of Numerical Recipes: each number comes once in 2^32.
const fn next_session(session: u32) -> u32 {
    match session.wrapping_mul(1_664_525).wrapping_add(1_013_904_223) {
        0 => 1,
        next => next,
    }
}
