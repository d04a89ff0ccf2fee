//! The link to a board: a thread that keeps it alive, and calls that wait with Python let go.

mod errors;
mod port;
mod state;
mod waiting;
mod worker;

use std::hash::{BuildHasher, Hasher};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use board_link::WhenDry;
use board_link::host::{ClientConfig, StreamEnd};
use board_link::message::{Answer, Chunk, Request};
use board_link::segment::{Begin, OfAxes};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use pythonize::pythonize;

use crate::errors::input_error;
use crate::points::{Point, SegmentMaker};
use errors::{connection_lost, no_reply, not_connected, refused};
use port::Port;
use state::{End, Shared, State, StreamState};
use waiting::{ANSWER, SIGNALS, locked, seconds};
use worker::Worker;

/// An event and its number.
type Numbered<'py> = (u32, Bound<'py, PyAny>);

/// The link to a board.
///
/// Every call takes it as it is: one thread may stop what another one streams.
#[pyclass(module = "motion_board._native", frozen)]
pub(crate) struct Link {
    address: String,
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
    last_stream: AtomicU32,
    /// The process in which the thread runs.
    process: u32,
}

#[pymethods]
impl Link {
    #[new]
    fn new(py: Python<'_>, address: String, baud: u32, commands: bool) -> PyResult<Self> {
        let port = py.detach(|| Port::open(&address, baud));
        let port = port.map_err(|text| not_connected(py, text))?;
        let seed = random();
        let config = ClientConfig {
            commands,
            ..ClientConfig::default()
        };
        let shared = Arc::new(Shared::default());
        let worker = Worker::new(Arc::clone(&shared), port, config, seed);
        let builder = std::thread::Builder::new().name("motion-board link".to_owned());
        let thread = builder
            .spawn(move || worker.run())
            .map_err(|error| not_connected(py, error))?;
        Ok(Self {
            address,
            shared,
            thread: Mutex::new(Some(thread)),
            last_stream: AtomicU32::new(random()),
            process: std::process::id(),
        })
    }

    /// Waits until the board has answered, and the command is claimed where it shall be.
    fn connect(&self, py: Python<'_>, timeout_s: f64) -> PyResult<()> {
        let look = |state: &mut State| state.is_connected.then_some(());
        if self.wait(py, seconds(py, timeout_s)?, look)?.is_some() {
            return Ok(());
        }
        let address = &self.address;
        let unavailable = self.state(py)?.unavailable;
        let text = match unavailable {
            Some(refused) => format!("{address}: {refused}"),
            None => format!(
                "{address}: no board has answered in {timeout_s} s: check the port, the bit rate, and that the board runs"
            ),
        };
        Err(not_connected(py, text))
    }

    /// A request without an answer of its own; waits until it is carried out.
    fn command(&self, py: Python<'_>, name: &str, percent: u16) -> PyResult<()> {
        let request = match name {
            "enable" => Request::Enable,
            "disable" => Request::Disable,
            "clear" => Request::Clear,
            "stop" => Request::Stop,
            "halt" => Request::Halt,
            "pause" => Request::Pause,
            "resume" => Request::Resume,
            "override" => Request::Override { percent },
            other => {
                return Err(input_error(
                    py,
                    format_args!("no command is called {other}"),
                ));
            }
        };
        self.ask(py, request).map(|_| ())
    }

    /// Homes the axes, and waits for the end of that.
    fn home(&self, py: Python<'_>, timeout_s: f64) -> PyResult<()> {
        self.ask_within(py, Request::Home, seconds(py, timeout_s)?)
            .map(|_| ())
    }

    /// What an axis counts from.
    fn origin<'py>(&self, py: Python<'py>, axis: u8) -> PyResult<Bound<'py, PyAny>> {
        match self.ask(py, Request::ReadOrigin { axis })? {
            Answer::Origin(origin) => Ok(pythonize(py, &origin)?),
            _ => Err(no_reply(py, "the board gave another answer than an origin")),
        }
    }

    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.ask(py, Request::Hello)? {
            Answer::Info(info) => Ok(pythonize(py, &info)?),
            _ => Err(no_reply(py, "the board gave another answer than its info")),
        }
    }

    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.ask(py, Request::ReadCounters)? {
            Answer::Counters(counters) => Ok(pythonize(py, &counters)?),
            _ => Err(no_reply(
                py,
                "the board gave another answer than its counters",
            )),
        }
    }

    /// An entry of the fault log, 0 the latest.
    fn fault<'py>(&self, py: Python<'py>, index: u32) -> PyResult<Bound<'py, PyAny>> {
        match self.ask(py, Request::ReadFault { index })? {
            Answer::Fault(entry) => Ok(pythonize(py, &entry)?),
            _ => Err(no_reply(py, "the board gave another answer than a fault")),
        }
    }

    /// All settings in force.
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut all: Vec<u8> = Vec::new();
        loop {
            let offset = all.len() as u32;
            let answer = self.ask(py, Request::ReadSettings { offset })?;
            let Answer::Settings {
                length,
                checksum,
                bytes,
                ..
            } = answer
            else {
                return Err(no_reply(
                    py,
                    "the board gave another answer than its settings",
                ));
            };
            all.extend_from_slice(&bytes);
            if bytes.is_empty() || all.len() >= length as usize {
                let actual = board_link::frame::checksum(&all);
                if actual == checksum {
                    return Ok(PyBytes::new(py, &all));
                }
                let text = format_args!(
                    "the settings do not fit their checksum: expected {checksum:08X}, got {actual:08X}; read them again"
                );
                return Err(no_reply(py, text));
            }
        }
    }

    /// Writes settings, piece by piece, and lets the board check and store them for its next start.
    fn write_settings(&self, py: Python<'_>, data: &[u8]) -> PyResult<()> {
        let mut offset = 0;
        for piece in data.chunks(Chunk::new().capacity()) {
            // No piece is longer than the capacity.
            let bytes = Chunk::from_slice(piece).unwrap_or_default();
            self.ask(py, Request::WriteSettings { offset, bytes })?;
            offset += piece.len() as u32;
        }
        let checksum = board_link::frame::checksum(data);
        let length = offset;
        self.ask(py, Request::CommitSettings { length, checksum })?;
        Ok(())
    }

    /// How everything is: the first report that came after this call.
    fn snapshot<'py>(&self, py: Python<'py>, timeout_s: f64) -> PyResult<Bound<'py, PyAny>> {
        let before = self.state(py)?.snapshots;
        let look = |state: &mut State| {
            // One that was on its way may be of a moment before the call.
            let is_new = state.snapshots > before + 1;
            state.snapshot.as_ref().filter(|_| is_new).cloned()
        };
        match self.wait(py, seconds(py, timeout_s)?, look)? {
            Some(snapshot) => Ok(pythonize(py, &snapshot)?),
            None => Err(connection_lost(
                py,
                format_args!("the board has reported nothing for {timeout_s} s"),
            )),
        }
    }

    /// The latest report, at once; `None` before the first one.
    fn latest_snapshot<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let snapshot = self.state(py)?.snapshot.clone();
        let snapshot = snapshot.map(|snapshot| pythonize(py, &snapshot));
        Ok(snapshot.transpose()?)
    }

    /// Events that have come, and how many were lost since the last call.
    fn events<'py>(&self, py: Python<'py>) -> PyResult<(Vec<Numbered<'py>>, u64)> {
        let (events, lost) = {
            let mut state = self.state(py)?;
            let lost = core::mem::take(&mut state.events_lost);
            (core::mem::take(&mut state.events), lost)
        };
        let events = events.into_iter();
        let events: PyResult<Vec<_>> = events
            .map(|(number, event)| Ok((number, pythonize(py, &event)?)))
            .collect();
        Ok((events?, lost))
    }

    /// Begins a stream at its first set-point; the result is its number.
    fn begin(
        &self,
        py: Python<'_>,
        cycles: f64,
        counts: Vec<f64>,
        waits: bool,
        percent: u16,
    ) -> PyResult<u32> {
        let first = Point::of(cycles, &counts).map_err(|text| input_error(py, text))?;
        let number = self
            .last_stream
            .fetch_add(1, Ordering::Relaxed)
            .wrapping_add(1);
        let from: OfAxes<i64> = first
            .positions
            .iter()
            .map(|position| position.units())
            .collect();
        let begin = Begin {
            stream: number,
            start: None,
            when_dry: if waits { WhenDry::Wait } else { WhenDry::End },
            percent,
            from,
        };
        let stream = StreamState::new(begin, SegmentMaker::new(first));
        let has_begun = self.state(py)?.begin(stream);
        if has_begun {
            return Ok(number);
        }
        Err(input_error(
            py,
            "another stream is under way: stop it, or wait for its end",
        ))
    }

    /// Adds a set-point to a stream; waits for room. Whether the stream still takes set-points.
    fn push(&self, py: Python<'_>, number: u32, cycles: f64, counts: Vec<f64>) -> PyResult<bool> {
        let point = Point::of(cycles, &counts).map_err(|text| input_error(py, text))?;
        let made = self
            .state(py)?
            .open_stream(number)
            .map(|stream| stream.make(point));
        let Some(made) = made else { return Ok(false) };
        match made.map_err(|text| input_error(py, text))? {
            Some(segment) => self.offer(py, number, segment),
            None => Ok(true),
        }
    }

    /// No set-point of a stream follows. Whether it was taken as a whole.
    fn finish(&self, py: Python<'_>, number: u32) -> PyResult<bool> {
        let last = self
            .state(py)?
            .open_stream(number)
            .and_then(StreamState::make_last);
        if let Some(segment) = last {
            self.offer(py, number, segment)?;
        }
        let mut state = self.state(py)?;
        let stream = state.open_stream(number);
        let is_open = stream.is_some();
        if let Some(stream) = stream {
            stream.is_finished = true;
        }
        Ok(is_open)
    }

    /// Stops a stream, unless it was stopped, or another one was begun since. Whether it may move the axes yet.
    fn stop_stream(&self, py: Python<'_>, number: u32) -> PyResult<bool> {
        let ticket = {
            let mut state = self.state(py)?;
            if !state.may_move(number) {
                return Ok(false);
            }
            state.stop_stream(number)
        };
        if let Some(ticket) = ticket {
            self.reply_within(py, ticket, ANSWER)?;
        }
        Ok(true)
    }

    /// How far a stream is: "sending", "sent", "lost", "timed-out", "stopped", or "replaced" by another one. One that the board refuses is
    /// an exception.
    fn stream_end(&self, py: Python<'_>, number: u32) -> PyResult<&'static str> {
        let end = self.state(py)?.stream(number).map(|stream| stream.end);
        match end {
            None => Ok("replaced"),
            Some(None) => Ok("sending"),
            Some(Some(End::Stopped)) => Ok("stopped"),
            Some(Some(End::Told(StreamEnd::Sent { .. }))) => Ok("sent"),
            Some(Some(End::Told(StreamEnd::Lost))) => Ok("lost"),
            Some(Some(End::Told(StreamEnd::TimedOut))) => Ok("timed-out"),
            Some(Some(End::Told(StreamEnd::Refused {
                index,
                refused: why,
            }))) => {
                // Segment 0 leads to set-point 1.
                Err(refused(py, &why, index.map(|index| index + 1)))
            }
        }
    }

    /// What became of a stream, as the board has said last; `None` when it has said nothing of it.
    fn played<'py>(&self, py: Python<'py>, number: u32) -> PyResult<Option<Bound<'py, PyAny>>> {
        let player = self.state(py)?.played(number);
        let player = player.map(|player| pythonize(py, &player));
        Ok(player.transpose()?)
    }

    /// Waits a moment for news, with Python let go.
    fn wait_for_news(&self, py: Python<'_>, most_s: f64) -> PyResult<()> {
        let most = seconds(py, most_s)?.min(SIGNALS);
        self.check_process(py)?;
        py.detach(|| self.shared.wait(most));
        py.check_signals()
    }

    /// Gives the command back and closes the port.
    fn close(&self, py: Python<'_>) {
        if !self.is_here() {
            // The thread is none of this process.
            return;
        }
        self.shared.lock().is_closing = true;
        let thread = locked(&self.thread).take();
        if let Some(thread) = thread {
            py.detach(|| {
                // A thread that panicked is gone all the same.
                let _ = thread.join();
            });
        }
    }

    fn is_closed(&self) -> bool {
        !self.is_here() || locked(&self.thread).is_none()
    }
}

impl Link {
    /// Whether this is the process that has opened it, and no child that was forked.
    fn is_here(&self) -> bool {
        self.process == std::process::id()
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if self.is_here() {
            // The thread says goodbye by itself.
            self.shared.lock().is_closing = true;
        }
    }
}

/// A number that no other start of a program had.
fn random() -> u32 {
    let hasher = std::hash::RandomState::new().build_hasher();
    hasher.finish() as u32
}
