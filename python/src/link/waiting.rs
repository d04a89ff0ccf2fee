//! What a call waits for, with Python let go.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use board_link::message::{Answer, Request};
use board_link::segment::Segment;
use pyo3::prelude::*;

use super::Link;
use super::errors::{connection_lost, no_reply, request_failed};
use super::state::{QUEUE, State};
use crate::errors::input_error;
use crate::points::Point;

/// Python looks for Ctrl-C this often.
pub(super) const SIGNALS: Duration = Duration::from_millis(50);
/// The application of a board takes no longer for a command than this.
const ANSWER: Duration = Duration::from_secs(15);

impl Link {
    /// Waits until something is so; `None` when it took too long.
    pub(super) fn wait<T: Send>(
        &self,
        py: Python<'_>,
        most: Duration,
        mut look: impl FnMut(&mut State) -> Option<T> + Send,
    ) -> PyResult<Option<T>> {
        let start = Instant::now();
        loop {
            let mut found = py.detach(|| {
                let found = look(&mut self.shared.lock());
                if found.is_none() {
                    self.shared
                        .wait(SIGNALS.min(most.saturating_sub(start.elapsed())));
                }
                found
            });
            if found.is_none() {
                found = look(&mut self.shared.lock());
            }
            if found.is_some() {
                return Ok(found);
            }
            py.check_signals()?;
            if let Some(gone) = &self.shared.lock().gone {
                return Err(connection_lost(
                    py,
                    format_args!("{}: {gone}", self.address),
                ));
            }
            if start.elapsed() >= most {
                return Ok(None);
            }
        }
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
        let ticket = {
            let mut state = self.shared.lock();
            if let Some(gone) = &state.gone {
                return Err(connection_lost(
                    py,
                    format_args!("{}: {gone}", self.address),
                ));
            }
            state.last_ticket += 1;
            let ticket = state.last_ticket;
            state.requests.push_back((ticket, request));
            ticket
        };
        let waited = self.wait(py, most, |state| state.replies.remove(&ticket));
        if !matches!(waited, Ok(Some(_))) {
            // What nobody waits for any more, and has not gone out yet, does not go out behind the stop that follows; but what stops does.
            let ends = |request: &Request| request.is_stopping() || *request == Request::Disable;
            let is_another = |one: &(u64, Request)| one.0 != ticket || ends(&one.1);
            self.shared.lock().requests.retain(is_another);
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

    /// The segment that a set-point completes.
    pub(super) fn make(&self, point: Point) -> Result<Option<Segment>, String> {
        let mut maker = locked(&self.maker);
        let Some(maker) = maker.as_mut() else {
            return Err("no stream is under way".to_owned());
        };
        let latest = maker.latest().time;
        if point.time <= latest {
            let (expected, actual) = (latest.cycles(), point.time.cycles());
            return Err(format!(
                "the time: expected later than {expected} cycles, got {actual}"
            ));
        }
        Ok(maker.push(point))
    }

    pub(super) fn offer(&self, py: Python<'_>, segment: Segment) -> PyResult<bool> {
        let mut segment = Some(segment);
        loop {
            let look = |state: &mut State| {
                let Some(stream) = &mut state.stream else {
                    return Some(false);
                };
                if stream.end.is_some() {
                    return Some(false);
                }
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

    pub(super) fn is_open(&self) -> bool {
        let state = self.shared.lock();
        state
            .stream
            .as_ref()
            .is_some_and(|stream| stream.end.is_none())
    }
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
