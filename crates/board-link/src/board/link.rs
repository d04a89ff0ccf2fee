//! One port: the bytes of one host.

use super::application::Application;
use super::commands::Outcome;
use super::shared::Board;
use super::slots::Slots;
use crate::frame::{Decoder, LONGEST_FRAME, Loss, VERSION, decode};
use crate::message::{Answer, Counters, Request, ToBoard, ToHost};
use crate::outbox::Outbox;
use crate::reason::Reason;
use crate::refused::Refused;

/// Commands of this port that the application carries out.
const PENDING: usize = 4;
/// No reply, event or snapshot takes more bytes.
const LONGEST_ANSWER: usize = 512;
/// A request is not repeated behind so many others, and its number is used anew behind 65,535.
const REPEATED_WITHIN: u16 = 1_024;

/// A command that the application carries out.
#[derive(Debug, Clone, Copy)]
struct Pending {
    key: Key,
    ticket: u16,
    since: u64,
    /// It takes as long as it takes.
    is_homing: bool,
    is_enable: bool,
}

/// What two requests have in common when one is the repetition of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key {
    number: u16,
    checksum: u32,
}

/// One port of a board. `OUT` bytes wait to be sent at most: [`LONGEST_FRAME`] at least.
///
/// Whoever drives the wire hands over what has come ([`Self::on_bytes`]), calls [`Self::poll`] at least once a cycle or so, and sends what
/// waits ([`Self::output`]).
#[derive(Debug)]
pub struct Link<const OUT: usize> {
    pub(super) decoder: Decoder,
    outbox: Outbox<OUT>,
    /// The latest command that was answered.
    answered: Option<(Key, Result<Answer, Refused>)>,
    /// The latest homing that was answered. It is kept beside, because it moves the axes anew when it is carried out again, and its host lives on,
    /// and may stop it, while it waits for the reply.
    homed: Option<(Key, Result<(), Refused>)>,
    /// The latest `Enable`, for the same reason: the drives may have been halted meanwhile.
    enabled: Option<(Key, Result<(), Refused>)>,
    pending: Slots<Pending, PENDING>,
    /// The number of the next event to send.
    pub(super) cursor: u32,
    snapshots: Option<Snapshots>,
    pub(super) counters: Counters,
}

/// Snapshots that were asked for.
#[derive(Debug, Clone, Copy)]
struct Snapshots {
    period: u32,
    due: u64,
}

impl<const OUT: usize> Link<OUT> {
    /// Before the first byte.
    #[must_use]
    pub fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            outbox: Outbox::new(),
            answered: None,
            homed: None,
            enabled: None,
            pending: Slots::new(),
            cursor: 0,
            snapshots: None,
            counters: Counters::default(),
        }
    }

    /// Bytes that wait to be sent.
    #[must_use]
    pub fn output(&self) -> &[u8] {
        self.outbox.waiting()
    }

    /// So many of them are sent, or in the buffer of the port.
    pub fn consume(&mut self, count: usize) {
        self.outbox.consume(count);
    }

    /// Takes bytes that have come, at `now` in cycles of the board.
    pub fn on_bytes<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        now: u64,
        bytes: &[u8],
    ) {
        for &byte in bytes {
            let message = match self.decoder.push(byte) {
                None => continue,
                Some(Ok(content)) => match to_board(content.body) {
                    Some(message) => Ok((content.checksum, message)),
                    None => Err(number_of(content.body)),
                },
                Some(Err(Loss::Version { actual })) => {
                    let refused = Reason::Version.because(VERSION.into(), actual.into());
                    self.reply(0, Err(refused));
                    continue;
                }
                Some(Err(_)) => continue,
            };
            match message {
                Ok((checksum, message)) => self.take(board, now, checksum, &message),
                Err(number) => {
                    self.decoder.count_bad_body();
                    self.reply(number, Err(Reason::Message.because(VERSION.into(), 0)));
                }
            }
        }
    }

    fn take<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        now: u64,
        checksum: u32,
        message: &ToBoard,
    ) {
        let key = Key {
            number: message.number,
            checksum,
        };
        if self.outbox.free() < LONGEST_ANSWER {
            // Nothing is done that cannot be answered: the host repeats it. A stop is done all the same.
            self.counters.unanswered = self.counters.unanswered.saturating_add(1);
            if !message.request.is_stopping() {
                return;
            }
        }
        // Whatever it asks for, the host lives.
        let commands = board.check_session(message.session, now).is_ok();
        if message.request.is_reading() {
            let result = self.read(board, &message.request, now);
            self.reply(key.number, result);
            return;
        }
        if self.pending.iter().any(|pending| pending.key == key) {
            // Its answer will come.
            self.counters.repeated = self.counters.repeated.saturating_add(1);
            return;
        }
        let is_old = |(last, _): &(Key, _)| {
            let ahead = message.number.wrapping_sub(last.number);
            (REPEATED_WITHIN..u16::MAX / 2).contains(&ahead)
        };
        self.homed.take_if(|of| is_old(of));
        self.enabled.take_if(|of| is_old(of));
        if A::HOMES
            && let Some((last, result)) = self.homed
            && last == key
            && (commands || result.is_err())
        {
            self.counters.repeated = self.counters.repeated.saturating_add(1);
            self.reply(key.number, result.map(|()| Answer::Done));
            return;
        }
        if let Some((last, result)) = self.enabled
            && last == key
            && (commands || result.is_err())
        {
            self.counters.repeated = self.counters.repeated.saturating_add(1);
            self.reply(key.number, result.map(|()| Answer::Done));
            return;
        }
        if self.is_repeated(key, message, commands)
            && let Some((_, result)) = self.answered.take()
        {
            self.counters.repeated = self.counters.repeated.saturating_add(1);
            return self.answer(key, result);
        }
        let is_segment = matches!(message.request, Request::Segment { .. });
        match board.command(message.session, &message.request, now) {
            // A segment has its index: what is there already is not taken twice.
            Outcome::Answered(result) if is_segment => {
                self.reply(key.number, result);
            }
            Outcome::Answered(result) => self.answer(key, result),
            Outcome::Posted(ticket) => self.wait_for(Pending {
                key,
                ticket,
                since: now,
                is_homing: matches!(message.request, Request::Home),
                is_enable: matches!(message.request, Request::Enable),
            }),
        }
    }

    /// Whether the last command is repeated, unless its session does not command any more.
    fn is_repeated(&self, key: Key, message: &ToBoard, commands: bool) -> bool {
        let is_free = message.request.is_stopping() || message.request == Request::Release;
        self.answered
            .as_ref()
            .is_some_and(|(last, result)| *last == key && (commands || is_free || result.is_err()))
    }

    fn wait_for(&mut self, pending: Pending) {
        if !self.pending.put(pending) {
            // It is carried out; how it ends is not reported.
            self.answer(
                pending.key,
                Err(Reason::Busy.because(PENDING as i64, PENDING as i64 + 1)),
            );
        }
    }

    fn answer(&mut self, key: Key, result: Result<Answer, Refused>) {
        let reply = self.reply(key.number, result);
        self.answered = match reply {
            ToHost::Reply { result, .. } => Some((key, result)),
            ToHost::Event { .. } | ToHost::Snapshot(_) => None,
        };
    }

    /// Returns the reply, of which commands keep the result.
    fn reply(&mut self, number: u16, result: Result<Answer, Refused>) -> ToHost {
        if result.is_err() {
            self.counters.refused = self.counters.refused.saturating_add(1);
        }
        let reply = ToHost::Reply { number, result };
        if !self.outbox.send(&reply) {
            self.counters.unanswered = self.counters.unanswered.saturating_add(1);
        }
        reply
    }

    pub(super) fn set_snapshots(&mut self, period: u32, now: u64) {
        self.snapshots = (period > 0).then_some(Snapshots { period, due: now });
    }

    /// Answers what the application has carried out, and reports events and snapshots, at `now` in cycles of the board.
    pub fn poll<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        now: u64,
    ) {
        board.poll(now);
        self.finish_commands(board, now);
        self.send_events(board);
        self.send_snapshot(board, now);
    }

    fn finish_commands<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        now: u64,
    ) {
        let patience = board.config.patience;
        for slot in 0..PENDING {
            let Some(pending) = self.pending.get(slot) else {
                continue;
            };
            let is_over = !pending.is_homing && now.saturating_sub(pending.since) > patience.into();
            let result = match board.take_result(pending.ticket) {
                Some(result) => {
                    if pending.is_enable {
                        self.enabled = Some((pending.key, result));
                    }
                    if A::HOMES && pending.is_homing {
                        self.homed = Some((pending.key, result));
                    }
                    result.map(|()| Answer::Done)
                }
                None if is_over => {
                    if board.busy == Some(pending.ticket) {
                        board.busy = None;
                    }
                    Err(Reason::NoAnswer.because(patience.into(), patience.into()))
                }
                None => continue,
            };
            self.pending.clear(slot);
            self.answer(pending.key, result);
        }
    }

    fn send_events<A: Application, const AXES: usize>(&mut self, board: &Board<'_, A, AXES>) {
        let nearest = board.events.nearest(self.cursor);
        let lost = nearest.wrapping_sub(self.cursor);
        self.counters.events_lost = self.counters.events_lost.saturating_add(lost);
        self.cursor = nearest;
        while self.outbox.free() >= LONGEST_ANSWER
            && let Some(event) = board.events.get(self.cursor)
        {
            let number = self.cursor;
            if !self.outbox.send(&ToHost::Event { number, event }) {
                return;
            }
            self.cursor = self.cursor.wrapping_add(1);
        }
    }

    fn send_snapshot<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        now: u64,
    ) {
        let Some(snapshots) = &mut self.snapshots else {
            return;
        };
        if now < snapshots.due {
            return;
        }
        // One at a time, however late it is.
        snapshots.due = now.saturating_add(snapshots.period.into());
        // Answers go first: one that finds no room is lost, and its request must come again.
        let is_sent = self.outbox.free() >= (2 * LONGEST_ANSWER).min(OUT)
            && self.outbox.send(&ToHost::Snapshot(board.snapshot(now)));
        if !is_sent {
            let left_out = &mut self.counters.snapshots_left_out;
            *left_out = left_out.saturating_add(1);
        }
    }
}

impl<const OUT: usize> Default for Link<OUT> {
    fn default() -> Self {
        Self::new()
    }
}

/// Compiled in this crate, once and for size, not for each application.
#[inline(never)]
fn to_board(body: &[u8]) -> Option<ToBoard> {
    decode(body)
}

/// The number of a request whose rest is unreadable; 0 where that is, too.
#[inline(never)]
fn number_of(body: &[u8]) -> u16 {
    postcard::take_from_bytes(body).map_or(0, |(number, _)| number)
}

const _: () = assert!(
    LONGEST_ANSWER <= LONGEST_FRAME,
    "an empty outbox has room for an answer"
);
