//! What the thread of a link and the callers share.

use std::collections::{HashMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::Duration;

use board_link::Refused;
use board_link::host::{RequestError, StreamEnd};
use board_link::message::{Answer, Event, Request, Snapshot};
use board_link::segment::{Begin, Segment};

/// Segments that wait for the client.
pub(super) const QUEUE: usize = 64;
/// Events that are kept for the program.
const EVENTS: usize = 4_096;

/// A stream on its way through the thread.
#[derive(Default)]
pub(super) struct StreamState {
    /// To be begun.
    pub(super) begin: Option<Begin>,
    pub(super) segments: VecDeque<Segment>,
    /// No segment follows.
    pub(super) is_finished: bool,
    /// The client was told so.
    pub(super) is_finish_told: bool,
    pub(super) end: Option<StreamEnd>,
}

#[derive(Default)]
pub(super) struct State {
    pub(super) is_connected: bool,
    pub(super) is_closing: bool,
    /// Why the thread has ended.
    pub(super) gone: Option<String>,
    pub(super) unavailable: Option<Refused>,
    pub(super) requests: VecDeque<(u64, Request)>,
    pub(super) replies: HashMap<u64, Result<Answer, RequestError>>,
    pub(super) last_ticket: u64,
    pub(super) stream: Option<StreamState>,
    pub(super) snapshot: Option<Snapshot>,
    /// Snapshots that have come.
    pub(super) snapshots: u64,
    pub(super) events: VecDeque<(u32, Event)>,
    /// Events that were lost: on the board, or because the program did not take them.
    pub(super) events_lost: u64,
}

impl State {
    pub(super) fn keep_event(&mut self, number: u32, event: Event) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
            self.events_lost += 1;
        }
        self.events.push_back((number, event));
    }
}

/// The state, and a signal that it has changed.
#[derive(Default)]
pub(super) struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        // A caller that panicked left nothing half done: every change is one assignment.
        self.state
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    pub(super) fn tell(&self) {
        self.changed.notify_all();
    }

    /// Waits for a change, a while at most.
    pub(super) fn wait(&self, most: Duration) {
        let state = self.lock();
        let _ = self.changed.wait_timeout(state, most);
    }
}
