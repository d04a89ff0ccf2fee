//! The client: what a program on a host calls.

use heapless::Deque;

use super::clock::ClockEstimate;
use super::connection::{self, Connection};
use super::events::EventOrder;
use super::exchange::{Exchange, FOR_EVER, Next, RequestError};
use super::incoming::{ClientConfig, Incoming};
use super::stream::{Phase, Stream, StreamEnd};
use crate::frame::{Decoder, Losses, decode};
use crate::message::{Answer, Info, Request, ToHost};
use crate::outbox::Outbox;
use crate::reason::Reason;
use crate::refused::Refused;

/// What waits for the program.
const INCOMING: usize = 16;

/// The end of a host. `WINDOW` segments are kept until the board has them, `OUT` bytes wait to be sent at most.
#[derive(Debug)]
pub struct Client<const WINDOW: usize, const OUT: usize> {
    pub(super) decoder: Decoder,
    pub(super) outbox: Outbox<OUT>,
    pub(super) config: ClientConfig,
    pub(super) connection: Connection,
    /// A request of the program.
    command: Option<Exchange>,
    /// A stop or a halt, which waits for nothing.
    urgent: Option<Exchange>,
    pub(super) stream: Option<Stream<WINDOW>>,
    pub(super) events: EventOrder,
    incoming: Deque<Incoming, INCOMING>,
    next_number: u16,
}

impl<const WINDOW: usize, const OUT: usize> Client<WINDOW, OUT> {
    /// Connects from the first [`Self::poll`] on. `seed` is a number that no other start of a client had: random, or of a clock.
    #[must_use]
    pub fn new(config: ClientConfig, seed: u32) -> Self {
        Self {
            decoder: Decoder::new(),
            outbox: Outbox::new(),
            config,
            connection: Connection::new(seed),
            command: None,
            urgent: None,
            stream: None,
            events: EventOrder::new(),
            incoming: Deque::new(),
            // A program that is started again does not repeat the numbers of the one before.
            next_number: (seed as u16) | 1,
        }
    }

    /// Bytes that wait to be sent.
    #[must_use]
    pub fn output(&self) -> &[u8] {
        self.outbox.waiting()
    }

    /// So many of them are sent.
    pub fn consume(&mut self, count: usize) {
        self.outbox.consume(count);
    }

    /// What the program is told, oldest first.
    #[allow(
        clippy::should_implement_trait,
        reason = "it is no iterator: more comes later"
    )]
    pub fn next(&mut self) -> Option<Incoming> {
        self.incoming.pop_front()
    }

    /// Whether the board answers, and the command is claimed where it shall be.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.connection.phase == connection::Phase::Online
    }

    /// What the board is, once it has answered.
    #[must_use]
    pub const fn info(&self) -> Option<&Info> {
        self.connection.info.as_ref()
    }

    /// The clock of the board.
    #[must_use]
    pub const fn clock(&self) -> &ClockEstimate {
        &self.connection.clock
    }

    /// The session.
    #[must_use]
    pub const fn session(&self) -> u32 {
        self.connection.session
    }

    /// Frames that were lost on the way to the host.
    #[must_use]
    pub const fn losses(&self) -> &Losses {
        self.decoder.losses()
    }

    /// Sends a request; its reply comes from [`Self::next`] with this ticket. [`Request::Stop`] and [`Request::Halt`] wait for no other
    /// request; [`Request::Disable`] takes the place of one that is under way, which is given up. What was asked for before one of these three
    /// and could move the axes is not sent behind it any more: a stream that the board has not begun by then ends.
    ///
    /// # Errors
    /// [`RequestError::Offline`], [`RequestError::Busy`].
    pub fn request(&mut self, request: Request) -> Result<u16, RequestError> {
        let is_urgent = request.is_stopping();
        if !self.is_connected() && !is_urgent {
            return Err(RequestError::Offline);
        }
        if is_urgent || request == Request::Disable {
            self.recall_what_moves();
        }
        if request == Request::Disable
            && let Some(exchange) = self.command.take()
        {
            let (ticket, tries) = (exchange.message.number, exchange.tries());
            let result = Err(RequestError::TimedOut { tries });
            self.tell(Incoming::Reply { ticket, result });
        }
        let slot = if is_urgent {
            &self.urgent
        } else {
            &self.command
        };
        if slot.is_some() {
            return Err(RequestError::Busy);
        }
        let number = self.number();
        let exchange = Exchange::new(number, self.connection.session, request);
        if is_urgent {
            self.urgent = Some(exchange);
        } else {
            self.command = Some(exchange);
        }
        Ok(number)
    }

    /// Sent behind a stop, because it waited or was lost before, it would begin, enable what was halted, or change the stream that comes next.
    fn recall_what_moves(&mut self) {
        if let Some(command) = &mut self.command
            && matches!(
                command.message.request,
                Request::Home | Request::Enable | Request::Resume | Request::Override { .. }
            )
        {
            command.recall();
        }
        if let Some(stream) = &mut self.stream
            && let Phase::Beginning(begin) = &mut stream.phase
        {
            begin.recall();
        }
    }

    pub(super) fn number(&mut self) -> u16 {
        let number = self.next_number;
        // 0 is for replies to what cannot be read.
        self.next_number = number.checked_add(1).unwrap_or(1);
        number
    }

    pub(super) fn has_room(&self) -> bool {
        // The last place is for what must not be lost: that the connection is.
        self.incoming.len() + 2 < INCOMING
    }

    pub(super) fn tell(&mut self, incoming: Incoming) {
        if self.incoming.is_full() {
            // What is told last counts: a connection that is lost ends what is told before.
            self.incoming.pop_front();
        }
        // There is room now.
        let _ = self.incoming.push_back(incoming);
    }

    /// How long and how often a request is tried. A board that stores settings may stand still for half a second, with everything that it
    /// would answer.
    pub(super) fn limits(&self) -> (u32, u8) {
        const PATIENCE: u32 = 10;
        let is_storing = self.command.as_ref().is_some_and(|exchange| {
            matches!(exchange.message.request, Request::CommitSettings { .. })
        });
        let timeout_us = self.config.timeout_us;
        let longest_us = timeout_us.saturating_mul(PATIENCE);
        (
            if is_storing { longest_us } else { timeout_us },
            self.config.tries,
        )
    }

    /// The same for a request of the program. A homing takes as long as it takes: it is tried until the connection is lost.
    fn limits_of_command(&self) -> (u32, u8) {
        let (timeout_us, tries) = self.limits();
        let command = self.command.as_ref();
        let is_homing = command.is_some_and(|exchange| exchange.message.request == Request::Home);
        (timeout_us, if is_homing { FOR_EVER } else { tries })
    }

    /// Sends what is due.
    pub fn poll(&mut self, now_us: u64) {
        let patient = self.limits_of_command();
        let usual = (self.config.timeout_us, self.config.tries);
        for is_urgent in [true, false] {
            let (slot, limits) = if is_urgent {
                (&mut self.urgent, usual)
            } else {
                (&mut self.command, patient)
            };
            let Some(exchange) = slot else { continue };
            if let Next::GiveUp { tries } = exchange.drive(&mut self.outbox, now_us, limits) {
                let ticket = exchange.message.number;
                *slot = None;
                let result = Err(RequestError::TimedOut { tries });
                self.tell(Incoming::Reply { ticket, result });
            }
        }
        self.drive_connection(now_us);
        self.drive_stream(now_us);
    }

    /// Takes bytes that have come.
    pub fn on_bytes(&mut self, now_us: u64, bytes: &[u8]) {
        for &byte in bytes {
            let Some(Ok(content)) = self.decoder.push(byte) else {
                continue;
            };
            match decode::<ToHost>(content.body) {
                Some(message) => self.take(now_us, message),
                None => self.decoder.count_bad_body(),
            }
        }
    }

    fn take(&mut self, now_us: u64, message: ToHost) {
        match message {
            ToHost::Reply { number, result } => self.take_reply(now_us, number, result),
            ToHost::Event { number, event } => self.take_event(number, event),
            ToHost::Snapshot(snapshot) => {
                let (next, credit) = (snapshot.next_segment, snapshot.credit);
                self.take_credit(snapshot.stream, next, credit, now_us);
                self.events.expect(snapshot.events);
                if self.has_room() {
                    self.tell(Incoming::Snapshot(snapshot));
                }
            }
        }
    }

    fn take_reply(&mut self, now_us: u64, number: u16, result: Result<Answer, Refused>) {
        if self.take_segment_reply(now_us, number, &result) {
            return;
        }
        let is_of = |exchange: &Option<Exchange>| {
            exchange
                .as_ref()
                .is_some_and(|exchange| exchange.message.number == number)
        };
        if is_of(&self.connection.exchange) {
            return self.take_connection_reply(now_us, result);
        }
        let is_urgent = is_of(&self.urgent);
        if is_urgent || is_of(&self.command) {
            if !self.has_room() {
                // It is asked again, and answered again.
                return;
            }
            let slot = if is_urgent {
                &mut self.urgent
            } else {
                &mut self.command
            };
            *slot = None;
            self.look_for_end_of_session(&result);
            let result = result.map_err(RequestError::Refused);
            let ticket = number;
            return self.tell(Incoming::Reply { ticket, result });
        }
        if number == 0
            && let Err(refused) = result
            && refused.reason() == Some(Reason::Version)
            && self.has_room()
        {
            self.tell(Incoming::Unavailable(refused));
        }
    }

    /// A board that does not know the session any more was reset, or has heard nothing for too long.
    pub(super) fn look_for_end_of_session(&mut self, result: &Result<Answer, Refused>) {
        if let Err(refused) = result
            && self.config.commands
            && matches!(refused.reason(), Some(Reason::NoSession | Reason::Taken))
        {
            self.disconnect();
        }
    }

    /// Everything that was under way has ended; a new session begins.
    pub(super) fn disconnect(&mut self) {
        let was_online = self.is_connected();
        self.connection.restart();
        self.outbox.clear();
        if !was_online {
            return;
        }
        let open = [self.command.take(), self.urgent.take()];
        for exchange in open.into_iter().flatten() {
            let ticket = exchange.message.number;
            let result = Err(RequestError::Lost);
            self.tell(Incoming::Reply { ticket, result });
        }
        if self.stream.take().is_some() {
            self.tell(Incoming::Stream(StreamEnd::Lost));
        }
        self.tell(Incoming::Disconnected);
    }
}
