//! Hello, claim, heartbeat, clock: what keeps a client connected.

use super::client::Client;
use super::clock::ClockEstimate;
use super::connection::Phase;
use super::exchange::{Exchange, Next};
use super::incoming::Incoming;
use super::stream::Stream;
use crate::message::{Answer, Info, Request};
use crate::reason::Reason;
use crate::refused::Refused;

/// Round trips at the start.
const FIRST_ROUNDS: usize = 8;
/// The clocks of a host and a board differ by less than this part of the time.
const CLOCKS_DIFFER: u64 = 64;

impl<const WINDOW: usize, const OUT: usize> Client<WINDOW, OUT> {
    pub(super) fn drive_connection(&mut self, now_us: u64) {
        if self.connection.exchange.is_none()
            && let Some(request) = self.due(now_us)
        {
            if matches!(request, Request::Hello) {
                // Whatever came before, the board finds the beginning.
                self.outbox.end_frame();
            }
            let number = self.number();
            let exchange = Exchange::new(number, self.connection.session, request);
            self.connection.exchange = Some(exchange);
        }
        let limits = self.limits();
        if let Some(exchange) = &mut self.connection.exchange
            && let Next::GiveUp { .. } = exchange.drive(&mut self.outbox, now_us, limits)
        {
            self.disconnect();
        }
    }

    fn due(&mut self, now_us: u64) -> Option<Request> {
        let connection = &self.connection;
        let is_due =
            |since_us: u64, period_us: u32| now_us.saturating_sub(since_us) >= u64::from(period_us);
        match connection.phase {
            Phase::Greeting => Some(Request::Hello),
            Phase::Claiming => {
                is_due(connection.alive_us, self.config.timeout_us).then_some(Request::Claim)
            }
            Phase::Online => {
                if let Some(from) = self.events.missing() {
                    return Some(Request::Events { from });
                }
                let rounds = connection.clock.rounds();
                if self.config.commands && is_due(connection.alive_us, self.config.heartbeat_us) {
                    return Some(Request::Heartbeat);
                }
                let syncs = rounds < FIRST_ROUNDS
                    || is_due(connection.synchronised_us, self.config.sync_us);
                syncs.then_some(Request::TimeSync { host_us: now_us })
            }
        }
    }

    pub(super) fn take_connection_reply(&mut self, now_us: u64, result: Result<Answer, Refused>) {
        let Some(exchange) = self.connection.exchange.take() else {
            return;
        };
        match result {
            Ok(Answer::Info(info)) => self.meet(info, exchange.first_us, now_us),
            Ok(Answer::Claimed { events, .. }) => {
                self.connection.alive_us = exchange.first_us;
                self.events.begin(events);
                self.go_online();
            }
            Ok(Answer::Alive {
                events,
                next,
                credit,
            }) => {
                self.connection.alive_us = exchange.first_us;
                self.events.expect(events);
                if let Some(stream) = self.stream.as_ref().and_then(Stream::begun) {
                    self.take_credit(stream, next, credit, now_us);
                }
            }
            Ok(Answer::Time { host_us, cycle }) => {
                self.connection.clock.add(host_us, now_us, cycle);
                self.connection.synchronised_us = now_us;
            }
            Ok(Answer::Events { oldest, next }) => {
                if let Some(lost) = self.events.resend(oldest, next) {
                    self.tell(Incoming::EventsLost(lost));
                }
            }
            Err(refused) if self.connection.phase == Phase::Claiming => {
                // Asked again after a while.
                self.connection.alive_us = now_us;
                if refused.reason() == Some(Reason::Taken) && self.has_room() {
                    self.tell(Incoming::Unavailable(refused));
                }
            }
            other => self.look_for_end_of_session(&other),
        }
    }

    fn meet(&mut self, info: Info, asked_us: u64, now_us: u64) {
        let connection = &mut self.connection;
        let since_us = asked_us.saturating_sub(connection.met_us);
        let is_another = |before: &Info| {
            // Two starts may have the same number where the board had no supply in between; its clock shows them.
            let passed = since_us / u64::from(info.cycle_us.max(1));
            let least = before
                .uptime
                .saturating_add(passed - passed / CLOCKS_DIFFER);
            before.boot != info.boot || info.uptime < least
        };
        connection.is_reset = connection.info.as_ref().is_some_and(is_another);
        connection.met_us = now_us;
        connection.clock = ClockEstimate::new(info.cycle_us);
        connection.info = Some(info);
        if self.config.commands {
            connection.phase = Phase::Claiming;
            connection.alive_us = 0;
        } else {
            self.go_online();
        }
    }

    fn go_online(&mut self) {
        self.connection.phase = Phase::Online;
        let is_reset = self.connection.is_reset;
        self.tell(Incoming::Connected { is_reset });
    }
}
