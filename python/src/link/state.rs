//! What the thread of a link and the callers share.

use std::collections::{HashMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::Duration;

use board_link::Refused;
use board_link::host::{RequestError, StreamEnd};
use board_link::message::{Answer, Event, Request, Snapshot};
use board_link::segment::{Begin, PlayerState, Segment};

use crate::points::{Point, SegmentMaker};

/// Segments that wait for the client.
pub(super) const QUEUE: usize = 64;
/// Events that are kept for the program.
const EVENTS: usize = 4_096;

/// Streams of which is kept what became of them: a thread may look at its own when others have begun theirs.
const PLAYED: usize = 16;

/// How a stream has ended for the thread.
#[derive(Clone, Copy)]
pub(super) enum End {
    /// As the client says.
    Told(StreamEnd),
    /// By a request of this program; the board may not have heard of it at all.
    Stopped,
}

/// A stream on its way through the thread.
pub(super) struct StreamState {
    pub(super) number: u32,
    /// To be begun.
    pub(super) begin: Option<Begin>,
    maker: Option<SegmentMaker>,
    pub(super) segments: VecDeque<Segment>,
    /// No segment follows.
    pub(super) is_finished: bool,
    /// The client was told so.
    pub(super) is_finish_told: bool,
    pub(super) end: Option<End>,
}

impl StreamState {
    pub(super) fn new(begin: Begin, maker: SegmentMaker) -> Self {
        Self {
            number: begin.stream,
            begin: Some(begin),
            maker: Some(maker),
            segments: VecDeque::new(),
            is_finished: false,
            is_finish_told: false,
            end: None,
        }
    }

    /// The segment that a set-point completes.
    pub(super) fn make(&mut self, point: Point) -> Result<Option<Segment>, String> {
        let Some(maker) = &mut self.maker else {
            return Err("no set-point was to follow".to_owned());
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

    /// The segment to the last set-point.
    pub(super) fn make_last(&mut self) -> Option<Segment> {
        self.maker.take().and_then(|mut maker| maker.finish())
    }

    /// Nothing more of it goes out.
    fn stop(&mut self) {
        self.begin = None;
        self.maker = None;
        self.segments.clear();
        // The board refuses the end of a stream that was told to stop, and that is its end for the client, too.
        self.is_finished = true;
        self.end.get_or_insert(End::Stopped);
    }
}

/// Whether a request ends what moves.
pub(super) fn ends(request: &Request) -> bool {
    request.is_stopping() || *request == Request::Disable
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
    /// What became of the latest streams.
    played: VecDeque<(u32, PlayerState)>,
    pub(super) snapshot: Option<Snapshot>,
    /// Snapshots that have come.
    pub(super) snapshots: u64,
    pub(super) events: VecDeque<(u32, Event)>,
    /// Events that were lost: on the board, or because the program did not take them.
    pub(super) events_lost: u64,
}

impl State {
    /// Lets the thread send a request; the result is its ticket.
    pub(super) fn queue(&mut self, request: Request) -> u64 {
        if ends(&request)
            && let Some(stream) = &mut self.stream
        {
            // Here and not in the thread: what is begun from now on comes behind it.
            stream.stop();
        }
        self.last_ticket += 1;
        self.requests.push_back((self.last_ticket, request));
        self.last_ticket
    }

    /// Begins a stream; not while another one is under way.
    pub(super) fn begin(&mut self, stream: StreamState) -> bool {
        let is_open = |stream: &StreamState| stream.end.is_none();
        if self.stream.as_ref().is_some_and(is_open) && self.gone.is_none() {
            return false;
        }
        self.stream = Some(stream);
        true
    }

    /// A stream, unless another one was begun since.
    pub(super) fn stream(&mut self, number: u32) -> Option<&mut StreamState> {
        let stream = self.stream.as_mut();
        stream.filter(|stream| stream.number == number)
    }

    /// A stream that takes set-points.
    pub(super) fn open_stream(&mut self, number: u32) -> Option<&mut StreamState> {
        let stream = self.stream(number);
        stream.filter(|stream| stream.end.is_none())
    }

    /// Stops a stream that nobody has stopped; the result is the ticket of that.
    pub(super) fn stop_stream(&mut self, number: u32) -> Option<u64> {
        let stream = self.stream(number)?;
        if matches!(stream.end, Some(End::Stopped)) {
            return None;
        }
        Some(self.queue(Request::Stop))
    }

    /// Whether a stream may move the axes yet.
    pub(super) fn may_move(&mut self, number: u32) -> bool {
        let is_over = |player: PlayerState| !player.phase.is_active();
        self.stream(number).is_some() && !self.played(number).is_some_and(is_over)
    }

    /// What became of a stream, as the board has said last.
    pub(super) fn played(&self, number: u32) -> Option<PlayerState> {
        let found = self.played.iter().rfind(|one| one.0 == number);
        found.map(|one| one.1)
    }

    fn note_played(&mut self, number: u32, player: PlayerState) {
        self.played.retain(|one| one.0 != number);
        if self.played.len() == PLAYED {
            self.played.pop_front();
        }
        self.played.push_back((number, player));
    }

    pub(super) fn keep_snapshot(&mut self, snapshot: Snapshot) {
        self.note_played(snapshot.stream, snapshot.player);
        self.snapshot = Some(snapshot);
        self.snapshots += 1;
    }

    pub(super) fn keep_event(&mut self, number: u32, event: Event) {
        // An event may be older than a snapshot, but an end is one.
        if let Event::Stream { stream, phase, .. } = event
            && !phase.is_active()
        {
            let player = self.played(stream).unwrap_or_default();
            self.note_played(stream, PlayerState { phase, ..player });
        }
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
