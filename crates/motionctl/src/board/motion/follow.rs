//! From claimed to given back: enable, send ahead, watch, stop where somebody wants it, disable.

use std::time::{Duration, Instant};

use board_link::message::{BoardState, Request, Snapshot};
use board_link::segment::StreamPhase;

use super::axes::OfBoard;
use super::outcome::{End, Traffic};
use super::recording::BoardRecording;
use super::remote::Remote;
use super::{BoardMotion, GivenUp};
use crate::board::session::Session;
use crate::control::Wishes;
use crate::interrupt;
use crate::output::tell;
use crate::run::progress_bar;
use crate::set_points::SetPointSource as _;

pub(super) const POLL: Duration = Duration::from_millis(2);

/// Time for axes to slow down that something has stopped.
const SLOW_TIME: Duration = Duration::from_secs(5);

/// A motion on a board under way.
pub(in crate::board) struct Follow<'a, M> {
    pub(super) session: &'a mut Session,
    pub(super) of_board: &'a OfBoard,
    pub(super) motion: &'a mut M,
    pub(super) recording: &'a mut BoardRecording,
    pub(super) remote: Remote,
    pub(super) latest: Snapshot,
    /// Where the axes of the board stood.
    pub(super) anchors: Vec<i32>,
    pub(super) traffic: Traffic,
    /// The number of the stream, once it is begun.
    pub(super) stream: Option<u32>,
    /// Its phase, from snapshots and events.
    pub(super) phase: StreamPhase,
    interrupts: u32,
    /// Since when the stream has been stopped, and the axes slow down.
    slows_since: Option<Instant>,
    /// The drives stay enabled when the motion is complete.
    stays_enabled: bool,
}

/// Why the motion ends now.
pub(super) type Stop = End;

/// A motion that has ended.
pub(in crate::board) struct Followed {
    pub(super) end: End,
    pub(super) anchors: Vec<i32>,
    pub(super) latest: Snapshot,
    pub(super) traffic: Traffic,
    pub(super) is_off: bool,
    /// The drives were left enabled on purpose.
    pub(super) is_left_on: bool,
}

impl<'a, M: BoardMotion> Follow<'a, M> {
    pub(in crate::board) fn new(
        session: &'a mut Session,
        of_board: &'a OfBoard,
        motion: &'a mut M,
        recording: &'a mut BoardRecording,
    ) -> Self {
        Self {
            session,
            of_board,
            recording,
            remote: Remote::new(motion.cycles(), motion.most_percent()),
            latest: Snapshot::default(),
            anchors: Vec::new(),
            traffic: Traffic::default(),
            motion,
            stream: None,
            phase: StreamPhase::Idle,
            interrupts: 0,
            slows_since: None,
            stays_enabled: false,
        }
    }

    /// Leaves the drives enabled when the motion is complete: the board knows the origins of homed axes no longer than that.
    pub(in crate::board) fn staying_enabled(self, stays_enabled: bool) -> Self {
        Self {
            stays_enabled,
            ..self
        }
    }

    /// Everything; the drives are off afterwards, or the result says that nobody knows.
    pub(in crate::board) fn run(
        mut self,
        wishes: &Wishes,
        snapshot_hz: u32,
        show_progress: bool,
    ) -> Followed {
        let moved = self
            .start(snapshot_hz, show_progress)
            .and_then(|()| self.stream(wishes, show_progress));
        let end = moved.err().unwrap_or(End::Completed);
        self.tell_notices();
        if let End::Stopped(reason) | End::Unplayable(reason) | End::LinkFailed(reason) = &end {
            // At once: slowing down and switching off take their time.
            tell(reason);
        }
        let is_left_on = self.stays_enabled && end == End::Completed && self.leave_enabled();
        let is_off = match &end {
            _ if is_left_on => false,
            End::LinkFailed(_) => self.try_to_end(),
            _ => self.end(),
        };
        self.traffic.clock_error_us = self.session.client().clock().error_us();
        let losses = *self.session.client().losses();
        let lost = losses.length + losses.stuffing + losses.checksum + losses.version + losses.body;
        self.traffic.lost_messages = lost.into();
        Followed {
            end,
            anchors: self.anchors,
            latest: self.latest,
            traffic: self.traffic,
            is_off,
            is_left_on,
        }
    }

    fn start(&mut self, snapshot_hz: u32, show_progress: bool) -> Result<(), Stop> {
        self.enable(snapshot_hz)?;
        self.anchors = self.latest.axes.iter().map(|axis| axis.target).collect();
        self.recording.motion_begins();
        if show_progress {
            tell("every drive is enabled; the motion starts");
        }
        Ok(())
    }

    pub(super) const fn is_stopping(&self) -> bool {
        self.interrupts > 0 || self.remote.is_stopping
    }

    /// Sends the segments and watches until the axes stand.
    fn stream(&mut self, wishes: &Wishes, show_progress: bool) -> Result<(), Stop> {
        let bar = progress_bar(self.remote.progress().1, show_progress);
        let ended = loop {
            self.play()?;
            self.take(POLL)?;
            self.listen(wishes);
            self.give_orders();
            bar.set_position(self.remote.progress().0);
            if let Some(end) = self.has_ended() {
                break end;
            }
        };
        bar.finish_and_clear();
        match ended {
            End::Completed => self.settle(),
            End::RanOut => self.settle().and(Err(End::RanOut)),
            End::Stopped(_) => {
                self.look()?;
                Err(End::Stopped(self.why()))
            }
            other => Err(other),
        }
    }

    /// Begins the stream, or goes on with it.
    fn play(&mut self) -> Result<(), Stop> {
        if self.stream.is_some() {
            self.motion.feed(self.session.client());
            return Ok(());
        }
        let speed = self.remote.speed();
        self.motion.wait(&self.anchors, speed);
        if speed.is_paused {
            return Ok(());
        }
        // Another number than that of the stream before: nothing that the board says of it is about this one.
        let number = self.latest.stream.wrapping_add(1);
        if let Some(mut begin) = self.motion.begin(number, &self.anchors) {
            begin.percent = self.remote.percent_at_begin();
            let begun = self.session.client().begin(begin);
            begun.map_err(|error| End::LinkFailed(error.to_string()))?;
            self.stream = Some(number);
        }
        Ok(())
    }

    /// What others want of the motion, and what it says.
    fn listen(&mut self, wishes: &Wishes) {
        wishes.hand_on(&mut self.remote);
        while let Some(order) = self.motion.next_order() {
            self.remote.order(order);
        }
        self.tell_notices();
        if let Some(naming) = self.motion.take_naming() {
            self.recording.name_axes(naming);
        }
    }

    fn tell_notices(&mut self) {
        while let Some(notice) = self
            .motion
            .next_notice()
            .or_else(|| self.remote.next_notice())
        {
            tell(notice);
        }
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
        // The board takes no order to a stream that it has not begun.
        if self.phase.is_active()
            && let Some(order) = self.remote.next_order()
            && self.session.client().request(order.clone()).is_err()
        {
            // The one before has no answer yet.
            self.remote.put_back(order);
        }
    }

    /// Whether a motion that was stopped still slows down, for as long as that is waited for.
    fn slows_down(&mut self) -> bool {
        let since = self.slows_since.get_or_insert_with(Instant::now);
        self.latest.state == BoardState::Stopping && since.elapsed() < SLOW_TIME
    }

    /// How the motion has ended, when it has.
    fn has_ended(&mut self) -> Option<End> {
        let asked = match (self.interrupts > 0, self.remote.is_stopping) {
            (true, _) => Some(End::Interrupted),
            (false, true) => Some(End::Ordered),
            (false, false) => None,
        };
        let given_up = self.motion.has_given_up().map(|why| match why {
            GivenUp::RanOut => End::RanOut,
            GivenUp::Unplayable(why) => End::Unplayable(why),
        });
        let is = self.latest.state;
        let is_stopped = self.phase == StreamPhase::Stopped && asked.is_none();
        if is_stopped && given_up.is_none() && self.slows_down() {
            // The board says why when the axes stand.
            return None;
        }
        match self.phase {
            StreamPhase::Complete if self.motion.has_run_out() => Some(End::RanOut),
            StreamPhase::Complete => Some(End::Completed),
            // It has ordered that itself.
            StreamPhase::Stopped | StreamPhase::DriedUp | StreamPhase::Displaced
                if given_up.is_some() && self.interrupts == 0 =>
            {
                given_up
            }
            StreamPhase::DriedUp if asked.is_none() => Some(End::RanOut),
            StreamPhase::Stopped | StreamPhase::DriedUp | StreamPhase::Displaced => {
                asked.or_else(|| Some(End::Stopped(self.why())))
            }
            _ if !matches!(is, BoardState::Enabled | BoardState::Stopping) => {
                Some(End::Stopped(self.why()))
            }
            // Nothing was begun that could be stopped.
            StreamPhase::Idle if self.stream.is_none() => given_up.or(asked),
            _ => None,
        }
    }
}
