//! What a call waits for, with Python let go.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use board_link::message::{Answer, Request};
use board_link::segment::Segment;
use pyo3::prelude::*;

use super::Link;
use super::errors::{connection_lost, no_reply, request_failed};
use super::state::{QUEUE, State, ends};
use crate::errors::input_error;

/// Python looks for Ctrl-C this often.
pub(super) const SIGNALS: Duration = Duration::from_millis(50);
/// The application of a board takes no longer for a command than this.
pub(super) const ANSWER: Duration = Duration::from_secs(15);

impl Link {
    /// Waits until something is so; `None` when it took too long.
    pub(super) fn wait<T: Send>(
        &self,
        py: Python<'_>,
        most: Duration,
        mut look: impl FnMut(&mut State) -> Option<T> + Send,
    ) -> PyResult<Option<T>> {
        self.check_process(py)?;
        let start = Instant::now();
        loop {
            let seen = py.detach(|| {
                let seen = self.look(&mut look);
                if !matches!(seen, Seen::Nothing) {
                    return seen;
                }
                let most = SIGNALS.min(most.saturating_sub(start.elapsed()));
                self.shared.wait(most);
                self.look(&mut look)
            });
            match seen {
                Seen::It(found) => return Ok(Some(found)),
                Seen::Gone(text) => return Err(connection_lost(py, text)),
                Seen::Nothing => {}
            }
            py.check_signals()?;
            if start.elapsed() >= most {
                return Ok(None);
            }
        }
    }

    fn look<T>(&self, look: &mut impl FnMut(&mut State) -> Option<T>) -> Seen<T> {
        let mut state = self.shared.lock();
        match (look(&mut state), &state.gone) {
            (Some(found), _) => Seen::It(found),
            (None, Some(gone)) => Seen::Gone(format!("{}: {gone}", self.address)),
            (None, None) => Seen::Nothing,
        }
    }

    /// The state, for a moment in which no object of Python is made: that may wait for a thread that waits for the state.
    pub(super) fn state(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, State>> {
        self.check_process(py)?;
        Ok(self.shared.lock())
    }

    /// A child that was forked has a copy of the link without its thread, which may have held the state at that moment.
    pub(super) fn check_process(&self, py: Python<'_>) -> PyResult<()> {
        if self.is_here() {
            return Ok(());
        }
        let address = &self.address;
        Err(connection_lost(
            py,
            format_args!("{address}: the link belongs to another process: open it anew"),
        ))
    }

    pub(super) fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Answer> {
        self.ask_within(py, request, ANSWER)
    }

    pub(super) fn ask_within(
        &self,
        py: Python<'_>,
        request: Request,
        most: Duration,
    ) -> PyResult<Answer> {
        let ticket = self.state(py)?.queue(request);
        self.reply_within(py, ticket, most)
    }

    /// The reply to a request that was queued.
    pub(super) fn reply_within(
        &self,
        py: Python<'_>,
        ticket: u64,
        most: Duration,
    ) -> PyResult<Answer> {
        let waited = self.wait(py, most, |state| state.replies.remove(&ticket));
        if !matches!(waited, Ok(Some(_))) {
            // What nobody waits for any more, and has not gone out yet, does not go out behind the stop that follows; but what stops does.
            let mut state = self.shared.lock();
            let is_gone = state.gone.is_some();
            let is_another = |one: &(u64, Request)| one.0 != ticket || (ends(&one.1) && !is_gone);
            state.requests.retain(is_another);
        }
        match waited? {
            Some(Ok(answer)) => Ok(answer),
            Some(Err(error)) => Err(request_failed(py, &error)),
            None => Err(no_reply(
                py,
                format_args!(
                    "no reply in {} s: read the state of the board",
                    most.as_secs()
                ),
            )),
        }
    }

    /// Adds a segment when there is room; whether the stream still takes them.
    pub(super) fn offer(&self, py: Python<'_>, number: u32, segment: Segment) -> PyResult<bool> {
        let mut segment = Some(segment);
        loop {
            let look = |state: &mut State| {
                let Some(stream) = state.open_stream(number) else {
                    return Some(false);
                };
                let has_room = stream.segments.len() < QUEUE;
                has_room.then(|| {
                    stream.segments.extend(segment.take());
                    true
                })
            };
            if let Some(is_open) = self.wait(py, ANSWER, look)? {
                return Ok(is_open);
            }
        }
    }
}

/// What a look at the state has found.
enum Seen<T> {
    It(T),
    /// The thread has ended, and why.
    Gone(String),
    Nothing,
}

/// A caller that panicked left nothing half done.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// The longest time that can be waited for: a day.
const LONGEST_S: f64 = 86_400.0;

/// How long to wait.
pub(super) fn seconds(py: Python<'_>, timeout_s: f64) -> PyResult<Duration> {
    if !(0.0..=LONGEST_S).contains(&timeout_s) {
        let text = format_args!("timeout_s: expected 0 to {LONGEST_S} s, got {timeout_s}");
        return Err(input_error(py, text));
    }
    Ok(Duration::from_secs_f64(timeout_s))
}
