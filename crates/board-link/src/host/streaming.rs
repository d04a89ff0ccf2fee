//! A stream of segments: begun, sent ahead as far as the board has room, repeated where one is lost, ended.

use heapless::Deque;

use super::client::Client;
use super::exchange::{Exchange, Next, RequestError};
use super::incoming::Incoming;
use super::stream::{Phase, Stream, StreamEnd, Waiting};
use crate::message::{Answer, Request, ToBoard};
use crate::reason::Reason;
use crate::refused::Refused;
use crate::segment::{Begin, Segment};

impl<const WINDOW: usize, const OUT: usize> Client<WINDOW, OUT> {
    /// Begins a stream; its segments come from [`Self::offer`] or [`Self::feed`], its end from [`Self::finish`].
    ///
    /// # Errors
    /// [`RequestError::Offline`], and [`RequestError::Busy`] while another one is under way.
    pub fn begin(&mut self, begin: Begin) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::Offline);
        }
        if self.stream.is_some() {
            return Err(RequestError::Busy);
        }
        let number = begin.stream;
        let request = Request::Begin(begin);
        let exchange = Exchange::new(self.number(), self.session(), request);
        self.stream = Some(Stream {
            number,
            phase: Phase::Beginning(exchange),
            window: Deque::new(),
            first: 0,
            sent: 0,
            // The first one asks how many more.
            limit: 1,
            progress_us: 0,
            tries: 0,
            is_finished: false,
        });
        Ok(())
    }

    /// Whether a segment can be offered.
    #[must_use]
    pub fn wants_segment(&self) -> bool {
        self.stream
            .as_ref()
            .is_some_and(|stream| !stream.is_finished && !stream.window.is_full())
    }

    /// Adds a segment to the stream; it comes back when there is no room, or no stream that takes one.
    ///
    /// # Errors
    /// The segment.
    #[allow(
        clippy::result_large_err,
        reason = "the caller keeps what is not taken"
    )]
    pub fn offer(&mut self, segment: Segment) -> Result<(), Segment> {
        let Some(stream) = self.stream.as_mut().filter(|stream| !stream.is_finished) else {
            return Err(segment);
        };
        let waiting = Waiting { segment, number: 0 };
        stream
            .window
            .push_back(waiting)
            .map_err(|waiting| waiting.segment)
    }

    /// No segment follows.
    pub fn finish(&mut self) {
        if let Some(stream) = &mut self.stream {
            stream.is_finished = true;
        }
    }

    /// Takes segments from a source as long as there is room; the stream ends where the source does.
    pub fn feed(&mut self, source: &mut impl Iterator<Item = Segment>) {
        while self.wants_segment() {
            let Some(segment) = source.next() else {
                return self.finish();
            };
            // It was asked whether there is room.
            let _ = self.offer(segment);
        }
    }

    pub(super) fn drive_stream(&mut self, now_us: u64) {
        let limits = (self.config.timeout_us, self.config.tries);
        let Some(stream) = &mut self.stream else {
            return;
        };
        let is_over = match &mut stream.phase {
            Phase::Beginning(exchange) | Phase::Ending(exchange) => {
                matches!(
                    exchange.drive(&mut self.outbox, now_us, limits),
                    Next::GiveUp { .. }
                )
            }
            Phase::Sending => self.send_segments(now_us),
        };
        if is_over {
            self.end_stream(StreamEnd::TimedOut);
        }
    }

    /// Sends what the board has room for; whether it is given up.
    fn send_segments(&mut self, now_us: u64) -> bool {
        let (session, timeout_us) = (self.connection.session, self.config.timeout_us);
        if let Some(stream) = &mut self.stream
            && now_us.saturating_sub(stream.progress_us) >= u64::from(timeout_us)
        {
            stream.progress_us = now_us;
            if stream.sent > 0 {
                stream.sent = 0;
                stream.tries = stream.tries.saturating_add(1);
            } else {
                // A board that gives no credit for so long says why when it gets one more.
                stream.limit = stream.limit.max(stream.first.saturating_add(1));
            }
            if stream.tries >= self.config.tries {
                return true;
            }
        }
        loop {
            let number = self.number();
            let Some(stream) = &mut self.stream else {
                return false;
            };
            let index = stream.first.wrapping_add(stream.sent as u32);
            if index >= stream.limit {
                return false;
            }
            let Some(waiting) = stream.window.get_mut(stream.sent) else {
                if stream.is_finished && stream.window.is_empty() {
                    let request = Request::End {
                        stream: stream.number,
                    };
                    stream.phase = Phase::Ending(Exchange::new(number, session, request));
                }
                return false;
            };
            let message = ToBoard {
                number,
                session,
                request: Request::Segment {
                    stream: stream.number,
                    index,
                    segment: waiting.segment.clone(),
                },
            };
            if !self.outbox.send(&message) {
                return false;
            }
            if stream.sent == 0 {
                stream.progress_us = now_us;
            }
            waiting.number = number;
            stream.sent += 1;
        }
    }

    /// The board says which segment is next, and how many it has room for.
    pub(super) fn take_credit(&mut self, number: u32, next: u32, credit: u32, now_us: u64) {
        if let Some(stream) = &mut self.stream
            && stream.begun() == Some(number)
        {
            stream.confirm(next, now_us);
            stream.limit = stream.limit.max(next.saturating_add(credit));
        }
    }

    /// Whether a reply is one to a segment, a begin or an end.
    pub(super) fn take_segment_reply(
        &mut self,
        now_us: u64,
        number: u16,
        result: &Result<Answer, Refused>,
    ) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        match &stream.phase {
            Phase::Beginning(exchange) if exchange.message.number == number => match result {
                Ok(_) => {
                    stream.phase = Phase::Sending;
                    stream.progress_us = now_us;
                }
                Err(refused) => self.refuse_stream(None, *refused),
            },
            Phase::Ending(exchange) if exchange.message.number == number => match result {
                Ok(_) => {
                    let segments = stream.first;
                    self.end_stream(StreamEnd::Sent { segments });
                }
                Err(refused) => self.refuse_stream(None, *refused),
            },
            _ => return self.take_reply_to_segment(now_us, number, result),
        }
        true
    }

    fn take_reply_to_segment(
        &mut self,
        now_us: u64,
        number: u16,
        result: &Result<Answer, Refused>,
    ) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        match result {
            Ok(Answer::Taken { next, credit }) => {
                let (stream, next, credit) = (stream.number, *next, *credit);
                self.take_credit(stream, next, credit, now_us);
            }
            Ok(_) => return false,
            Err(refused) => {
                let sent = stream.window.iter().take(stream.sent);
                let Some(place) = sent.into_iter().position(|one| one.number == number) else {
                    return false;
                };
                let index = stream.first.wrapping_add(place as u32);
                match refused.reason() {
                    // One before was lost: from there on again.
                    Some(Reason::Order) => {
                        let next = u32::try_from(refused.expected).unwrap_or(stream.first);
                        stream.confirm(next, now_us);
                        stream.sent = 0;
                    }
                    // The board says when there is room again.
                    Some(Reason::Full) => {
                        stream.sent = place;
                        stream.limit = index;
                    }
                    _ => self.refuse_stream(Some(index), *refused),
                }
            }
        }
        true
    }

    fn refuse_stream(&mut self, index: Option<u32>, refused: Refused) {
        self.look_for_end_of_session(&Err(refused));
        if self.stream.is_some() {
            self.end_stream(StreamEnd::Refused { index, refused });
        }
    }

    fn end_stream(&mut self, end: StreamEnd) {
        self.stream = None;
        self.tell(Incoming::Stream(end));
    }
}
