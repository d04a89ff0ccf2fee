//! From claimed to given back: enable, send ahead, watch, stop where somebody wants it, disable.

use std::time::{Duration, Instant};

use board_link::host::{Incoming, RequestError, StreamEnd};
use board_link::message::{BoardState, Event, Request, Snapshot};
use board_link::segment::StreamPhase;

use super::Prepared;
use super::axes::OfBoard;
use super::recording::BoardRecording;
use super::remote::Remote;
use super::segments::{begin, place};
use super::summary::{End, Outcome, Traffic};
use crate::board::error::BoardError;
use crate::board::session::Session;
use crate::board::words::{self, phase, refusal, state};
use crate::control::Wishes;
use crate::interrupt;
use crate::output::tell;
use crate::recording::Kind;
use crate::run::progress_bar;
use crate::set_points::SetPointSource as _;

/// Time for the drives to be enabled.
const ENABLE_TIME: Duration = Duration::from_secs(10);
/// Time for them to slow down and to be off.
const DISABLE_TIME: Duration = Duration::from_secs(5);
/// Time for the drives to arrive behind the last set-point.
const SETTLE_TIME: Duration = Duration::from_millis(500);
/// Time for a snapshot.
const LOOK_TIME: Duration = Duration::from_millis(500);
const POLL: Duration = Duration::from_millis(2);
/// The only stream of this session.
const STREAM: u32 = 1;

/// A motion on a board under way.
pub(super) struct Follow<'a> {
    session: &'a mut Session,
    of_board: &'a OfBoard,
    prepared: &'a Prepared,
    recording: &'a mut BoardRecording,
    remote: Remote,
    latest: Snapshot,
    anchors: Vec<i32>,
    traffic: Traffic,
    /// Segments that were handed to the client.
    offered: usize,
    /// The phase of the stream, from snapshots and events.
    phase: StreamPhase,
    sent: Option<StreamEnd>,
    interrupts: u32,
}

/// Why the motion ends now.
type Stop = End;

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

impl<'a> Follow<'a> {
    pub(super) fn new(
        session: &'a mut Session,
        of_board: &'a OfBoard,
        prepared: &'a Prepared,
        recording: &'a mut BoardRecording,
    ) -> Self {
        Self {
            session,
            of_board,
            recording,
            remote: Remote::new(prepared.played.cycles),
            latest: Snapshot::default(),
            anchors: Vec::new(),
            traffic: Traffic {
                segments: prepared.segments.len() as u32,
                ..Traffic::default()
            },
            prepared,
            offered: 0,
            phase: StreamPhase::Idle,
            sent: None,
            interrupts: 0,
        }
    }

    /// Everything; the drives are off afterwards, or the summary says that nobody knows.
    pub(super) fn run(mut self, wishes: &Wishes, snapshot_hz: u32, show_progress: bool) -> Outcome {
        let moved = self
            .start(snapshot_hz, show_progress)
            .and_then(|()| self.stream(wishes, show_progress));
        let end = moved.err().unwrap_or(End::Completed);
        if let End::Stopped(reason) | End::LinkFailed(reason) = &end {
            // At once: slowing down and switching off take their time.
            tell(reason);
        }
        let is_off = match &end {
            End::LinkFailed(_) => self.try_to_end(),
            _ => self.end(),
        };
        self.traffic.clock_error_us = self.session.client().clock().error_us();
        let losses = *self.session.client().losses();
        let lost = losses.length + losses.stuffing + losses.checksum + losses.version + losses.body;
        self.traffic.lost_messages = lost.into();
        let before = (self.anchors.as_slice(), &self.latest);
        Outcome::new(self.prepared, &end, before, self.traffic, is_off)
    }

    fn start(&mut self, snapshot_hz: u32, show_progress: bool) -> Result<(), Stop> {
        let cycles_per_second = 1_000_000 / self.prepared.cycle_us.max(1);
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
        self.await_enabled()?;
        self.anchors = self.latest.axes.iter().map(|axis| axis.target).collect();
        self.recording.motion_begins();
        if show_progress {
            tell("every drive is enabled; the motion starts");
        }
        let begun = self.session.client().begin(begin(STREAM, &self.anchors));
        begun.map_err(|error| End::LinkFailed(error.to_string()))
    }

    /// Until a snapshot says so.
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
                BoardState::Off => has_begun && is_fresh,
                BoardState::GettingReady | BoardState::Enabled | BoardState::Stopping => false,
                _ => is_fresh,
            };
            if has_failed || Instant::now() >= until {
                return Err(BoardError::NotReady { state: is }.into());
            }
        }
    }

    /// Takes what has come in; whether a snapshot was among it.
    fn take(&mut self, most: Duration) -> Result<bool, Stop> {
        let Some(incoming) = self.session.next_or_earlier(most)? else {
            return Ok(false);
        };
        match incoming {
            Incoming::Snapshot(snapshot) => {
                self.traffic.snapshots += 1;
                self.recording.snapshot(&snapshot);
                self.remote.note(&snapshot);
                if snapshot.stream == STREAM && !self.anchors.is_empty() {
                    self.phase = snapshot.player.phase;
                }
                self.latest = snapshot;
                return Ok(true);
            }
            Incoming::Event { event, .. } => self.note_event(&event),
            Incoming::EventsLost(lost) => self.traffic.lost_events += u64::from(lost),
            Incoming::Stream(end) => self.note_sent(end)?,
            Incoming::Disconnected | Incoming::Connected { .. } => {
                let lost = BoardError::Reset {
                    what: "follow the motion",
                };
                return Err(lost.into());
            }
            Incoming::Unavailable(refused) => {
                let port = self.session.name().to_owned();
                return Err(BoardError::Unavailable { port, refused }.into());
            }
            // An order that is refused because the motion has just ended.
            Incoming::Reply { .. } => {}
        }
        Ok(false)
    }

    fn note_event(&mut self, event: &Event) {
        let drives = &self.of_board.drives;
        let drive = |axis: u8| drives.get(usize::from(axis)).map(|drive| drive.get());
        let text = words::event(event, drive);
        let (place, kind) = match event {
            Event::Fault { axis, .. } => (axis.map(usize::from), Kind::Fault),
            Event::State(_) | Event::Stream { .. } => (None, Kind::State),
            _ => (None, Kind::Notice),
        };
        if kind == Kind::Fault {
            tell(&text);
        }
        if let Event::State(is) = event {
            self.latest.state = *is;
        }
        if let Event::Stream {
            stream: STREAM,
            phase,
            ..
        } = event
            && !self.anchors.is_empty()
        {
            self.phase = *phase;
        }
        self.recording.happened(place, kind, text);
    }

    fn note_sent(&mut self, end: StreamEnd) -> Result<(), Stop> {
        self.sent = Some(end);
        match end {
            StreamEnd::Sent { segments } => {
                self.traffic.segments_sent = segments;
                Ok(())
            }
            // It was told to stop, and says that it takes no more.
            StreamEnd::Refused { .. } if self.is_stopping() => Ok(()),
            StreamEnd::Refused { index, refused } => Err(End::Stopped(match index {
                Some(index) => {
                    self.traffic.segments_sent = index;
                    format!("the board refuses segment {index}: {}", refusal(&refused))
                }
                None => format!("the board refuses the motion: {}", refusal(&refused)),
            })),
            StreamEnd::TimedOut | StreamEnd::Lost => {
                let lost = BoardError::Reset {
                    what: "follow the motion",
                };
                Err(lost.into())
            }
        }
    }

    const fn is_stopping(&self) -> bool {
        self.interrupts > 0 || self.remote.is_stopping
    }

    /// Sends the segments and watches until the axes stand.
    fn stream(&mut self, wishes: &Wishes, show_progress: bool) -> Result<(), Stop> {
        let bar = progress_bar(self.remote.progress().1, show_progress);
        let ended = loop {
            self.feed();
            self.take(POLL)?;
            wishes.hand_on(&mut self.remote);
            self.give_orders();
            bar.set_position(self.remote.progress().0);
            if let Some(end) = self.has_ended() {
                break end;
            }
        };
        bar.finish_and_clear();
        match ended {
            End::Completed => self.settle(),
            End::Stopped(_) => {
                self.look()?;
                Err(End::Stopped(self.why()))
            }
            other => Err(other),
        }
    }

    /// Waits for the next snapshot.
    fn look(&mut self) -> Result<(), Stop> {
        let until = Instant::now() + LOOK_TIME;
        while !self.take(POLL)? && Instant::now() < until {}
        Ok(())
    }

    fn feed(&mut self) {
        let (places, anchors) = (self.prepared.places(), &self.anchors);
        let rest = self.prepared.segments.get(self.offered..);
        let mut source = rest
            .unwrap_or_default()
            .iter()
            .map(|segment| place(segment, &places, anchors))
            .inspect(|_| self.offered += 1);
        self.session.client().feed(&mut source);
    }

    /// What Ctrl-C and others want.
    fn give_orders(&mut self) {
        let interrupts = interrupt::requests();
        if interrupts > self.interrupts {
            let request = if self.interrupts == 0 {
                Request::Stop
            } else {
                Request::Halt
            };
            if self.session.client().request(request).is_ok() {
                self.interrupts += 1;
            }
        }
        if let Some(order) = self.remote.next_order()
            && self.session.client().request(order.clone()).is_err()
        {
            // The one before has no answer yet.
            self.remote.put_back(order);
        }
    }

    /// How the motion has ended, when it has.
    fn has_ended(&self) -> Option<End> {
        let is = self.latest.state;
        match self.phase {
            StreamPhase::Complete => Some(End::Completed),
            StreamPhase::Stopped | StreamPhase::DriedUp | StreamPhase::Displaced => {
                Some(match (self.interrupts > 0, self.remote.is_stopping) {
                    (true, _) => End::Interrupted,
                    (false, true) => End::Ordered,
                    (false, false) => End::Stopped(self.why()),
                })
            }
            _ if !matches!(is, BoardState::Enabled | BoardState::Stopping) => {
                Some(End::Stopped(self.why()))
            }
            _ => None,
        }
    }

    fn why(&self) -> String {
        let faults = self.latest.axes.iter().zip(&self.of_board.drives);
        let faults: Vec<String> = faults
            .filter(|(axis, _)| axis.fault != 0)
            .map(|(axis, drive)| format!("drive {drive}: {}", words::fault_name(axis.fault)))
            .collect();
        if faults.is_empty() {
            format!(
                "the board ended the motion: {}; stream: {}",
                state(self.latest.state),
                phase(self.phase)
            )
        } else {
            format!("the board ended the motion: {}", faults.join("; "))
        }
    }

    fn settle(&mut self) -> Result<(), Stop> {
        let until = Instant::now() + SETTLE_TIME;
        while Instant::now() < until {
            self.take(POLL)?;
            if self.latest.state == BoardState::Faulted {
                return Err(End::Stopped(self.why()));
            }
        }
        Ok(())
    }

    /// Switches the drives off and gives the command back; whether the board says that they are off.
    fn end(&mut self) -> bool {
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
    fn try_to_end(&mut self) -> bool {
        self.session.take_command().is_ok() && {
            let period = 20;
            let watched = self
                .session
                .ask("send snapshots", Request::Snapshots { period });
            watched.is_ok() && self.end()
        }
    }
}
