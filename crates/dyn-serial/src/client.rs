//! One request at a time, without a port and without a clock: bytes and time come in, packets go out.
//!
//! Laws:
//! - A request is sent only after the line has been quiet, so that a late reply to an earlier request is heard before.
//! - A reply counts only with the function and the drive id of the request.
//! - What was sent may come back and look like a reply. Such a packet counts as a reply only when the line does not bring back the
//!   request that was sent after it, because a line keeps the order.
//! - Only reads are repeated. A command is sent once and not acknowledged: repeating a relative move would double it.

mod hear;
mod outcome;
mod sent;
mod timing;

use crate::address::Address;
use crate::dialect::Dialect;
use crate::error::DecodeError;
use crate::function::ReplyFunction;
use crate::packet::Packet;
use crate::reply::Reply;
use crate::request::Request;
use crate::stream::{Decoder, Event, LineCounters};
use sent::SentPackets;

pub use outcome::{Answer, Busy, Failure, Poll, Traffic};
pub use timing::{BYTE_US, Timing};

/// The request that is not done.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Job {
    to: Address,
    packet: Packet,
    awaited: Option<ReplyFunction>,
    sent: u8,
    bad: Option<DecodeError>,
    /// Reads as the reply, and as a packet that was sent before and comes back.
    held: Option<Packet>,
    /// Such a packet came at least once.
    is_doubtful: bool,
    /// Something that was sent came back since the request was sent.
    is_echoed: bool,
    /// Damaged packets and stray bytes when the request was sent.
    damage: u32,
}

#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum State {
    Idle,
    /// Waits for a quiet line.
    Listening {
        job: Job,
        since_us: u64,
    },
    /// Waits for a reply.
    Waiting {
        job: Job,
        until_us: u64,
    },
    Done(Result<Answer, Failure>),
}

/// Sends one request at a time and finds its reply.
///
/// The caller writes what [`Self::poll`] hands out, and hands in what it reads. `now_us` is the caller's clock in
/// microseconds and never goes back.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Client {
    dialect: Dialect,
    timing: Timing,
    decoder: Decoder,
    state: State,
    /// From then on the line has been quiet.
    quiet_from_us: u64,
    sent: SentPackets,
    /// Until then what was sent last, or by somebody else before the start, is listened for.
    echo_until_us: u64,
    traffic: Traffic,
}

impl Client {
    /// A client with nothing to do.
    #[must_use]
    pub const fn new(dialect: Dialect, timing: Timing) -> Self {
        Self {
            dialect,
            timing,
            decoder: Decoder::new(),
            state: State::Idle,
            quiet_from_us: 0,
            sent: SentPackets::NONE,
            echo_until_us: timing.echo_us as u64,
            traffic: Traffic {
                replies: 0,
                echoes: 0,
                unexpected: 0,
                doubtful: 0,
                wrong_length: 0,
                out_of_range: 0,
                retries: 0,
            },
        }
    }

    /// Takes a request; [`Self::poll`] then says what to do.
    ///
    /// # Errors
    /// [`Busy`] while another request is not done, and for a request that the dialect does not send to this address.
    pub fn begin(&mut self, now_us: u64, to: Address, request: &Request) -> Result<(), Busy> {
        if !matches!(self.state, State::Idle) {
            return Err(Busy::Outstanding);
        }
        let packet = request.encode(to, &self.dialect).map_err(Busy::Encode)?;
        let job = Job {
            to,
            packet,
            awaited: request.reply_function(),
            sent: 0,
            bad: None,
            held: None,
            is_doubtful: false,
            is_echoed: false,
            damage: 0,
        };
        self.state = State::Listening {
            job,
            since_us: now_us,
        };
        Ok(())
    }

    /// Forgets the request that is not done, after an error of the port.
    pub fn abandon(&mut self) {
        self.state = State::Idle;
    }

    /// A byte that was received, with the event that it completes.
    pub fn receive(&mut self, now_us: u64, byte: u8) -> Option<Event> {
        self.quiet_from_us = self.quiet_from_us.max(now_us);
        let event = self.decoder.push(byte);
        if let Some(Event::Packet(packet)) = event {
            self.hear(now_us, &packet);
        }
        event
    }

    /// What to do at this time.
    pub fn poll(&mut self, now_us: u64) -> Poll {
        match self.state {
            State::Idle => Poll::Idle,
            State::Listening { job, since_us } => self.listen(now_us, job, since_us),
            State::Waiting { job, until_us } if now_us >= until_us => self.time_out(now_us, job),
            State::Waiting { until_us, .. } => Poll::Wait { until_us },
            State::Done(result) => {
                self.state = State::Idle;
                Poll::Done(result)
            }
        }
    }

    /// The events of the line.
    #[must_use]
    pub const fn line(&self) -> &LineCounters {
        self.decoder.counters()
    }

    /// What became of the packets.
    #[must_use]
    pub const fn traffic(&self) -> &Traffic {
        &self.traffic
    }

    fn listen(&mut self, now_us: u64, job: Job, since_us: u64) -> Poll {
        let quiet_at_us = self
            .quiet_from_us
            .saturating_add(u64::from(self.timing.quiet_us))
            .max(self.echo_until_us);
        if now_us >= quiet_at_us {
            return self.transmit(now_us, job);
        }
        let waited_us = now_us.saturating_sub(since_us);
        if waited_us >= u64::from(self.timing.quiet_timeout_us) {
            self.state = State::Idle;
            let waited_us = self.timing.quiet_timeout_us;
            return Poll::Done(Err(Failure::NotQuiet { waited_us }));
        }
        let timeout_us = since_us.saturating_add(u64::from(self.timing.quiet_timeout_us));
        Poll::Wait {
            until_us: quiet_at_us.min(timeout_us),
        }
    }

    fn transmit(&mut self, now_us: u64, mut job: Job) -> Poll {
        // Whatever is unfinished by now never will be.
        let _ = self.decoder.silence();
        if job.sent > 0 {
            count(&mut self.traffic.retries);
        }
        job.sent = job.sent.saturating_add(1);
        job.held = None;
        job.is_echoed = false;
        job.damage = self.damage();
        let bytes = job.packet.as_bytes().len() as u64;
        self.quiet_from_us = now_us.saturating_add(bytes * u64::from(BYTE_US));
        self.echo_until_us = self
            .quiet_from_us
            .saturating_add(u64::from(self.timing.echo_us));
        self.sent.push(job.packet, now_us);
        self.state = if job.awaited.is_some() {
            let until_us = now_us.saturating_add(u64::from(self.timing.reply_timeout_us));
            State::Waiting { job, until_us }
        } else {
            State::Done(Ok(Answer::Sent))
        };
        Poll::Transmit(job.packet)
    }

    /// Damage on the line since the start: what came back may have been among it.
    fn damage(&self) -> u32 {
        let line = self.decoder.counters();
        line.stray_bytes
            .wrapping_add(line.truncated)
            .wrapping_add(line.checksum_errors)
    }

    fn time_out(&mut self, now_us: u64, job: Job) -> Poll {
        if let Some(held) = job.held
            && job.damage == self.damage()
            && self.decoder.unfinished().is_empty()
            && !job.is_echoed
            && let Ok((from, reply)) = Reply::decode(&held)
        {
            // The line brings nothing back: not the request, and so nothing that was sent before it.
            self.sent.take(&held, now_us);
            count(&mut self.traffic.replies);
            self.state = State::Idle;
            return Poll::Done(Ok(Answer::Reply { from, reply }));
        }
        if job.sent < self.timing.attempts.get() {
            return self.listen_again(now_us, job);
        }
        self.state = State::Idle;
        let attempts = job.sent;
        Poll::Done(Err(match job.bad {
            _ if job.is_doubtful => Failure::Doubtful { attempts },
            Some(error) => Failure::BadReply { attempts, error },
            None => Failure::NoReply { attempts },
        }))
    }

    fn listen_again(&mut self, now_us: u64, job: Job) -> Poll {
        self.state = State::Listening {
            job,
            since_us: now_us,
        };
        self.listen(now_us, job, now_us)
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod echo_tests;
#[cfg(test)]
mod tests;
