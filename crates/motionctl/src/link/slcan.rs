//! A Lawicel adapter on a serial port.
//!
//! Each frame is a command, and the adapter answers commands in their order: `z` or `Z` for a frame that it took, BEL for
//! one that it refused because its queue is full. The master counts a frame when [`Can::transmit`] returns, which is
//! before that answer; a refused frame therefore comes back from a later `transmit`, as one that the controller gave back
//! unsent. Where answers are missing nobody knows whether frames went out: [`Slcan::take_unknown`] says so, and the master
//! anchors anew. Adapters that answer nothing work too, then nobody knows of refused frames.

mod set_up;
mod window;

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

use drive_sim::Frame;
use embedded_can::nb::Can;

use super::channel::Channel;
use super::{Adapter, BytePort, LinkFault, OpenError};
use crate::lawicel::{self, CR, Lines, Token};
pub(crate) use window::ANSWER_LIMIT;
use window::{Answer, MOST_UNANSWERED, Window};

/// How long a command may wait for room in the port.
const WRITE_TIME: Duration = Duration::from_millis(2);
/// How long the last frame may take before the channel is closed behind it.
const CLOSE_TIME: Duration = Duration::from_millis(100);

/// How to speak to an adapter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) baud: u32,
    pub(super) kbit_per_s: u32,
    /// Silence means that this is no adapter.
    pub(super) expects_answers: bool,
}

/// An open adapter.
pub(crate) struct Slcan {
    name: String,
    port: BytePort,
    lines: Lines,
    received: VecDeque<Frame>,
    window: Window,
    /// The rest of a command of which the port took a part.
    outgoing: Vec<u8>,
    fault: Option<LinkFault>,
}

impl Slcan {
    /// Opens a port, makes sure that a Lawicel adapter answers there, sets the bit rate and goes on the bus.
    ///
    /// # Errors
    /// [`OpenError`] says what is wrong with the port or with what answers on it.
    pub(super) fn open(
        name: &str,
        settings: Settings,
        channel: Channel,
    ) -> Result<Self, OpenError> {
        let kbit_per_s = settings.kbit_per_s;
        let code = lawicel::bit_rate_code(kbit_per_s).ok_or(OpenError::BitRate { kbit_per_s })?;
        let port = BytePort::open(name, settings.baud)?;
        let mut slcan = Self {
            name: name.to_owned(),
            port,
            lines: Lines::default(),
            received: VecDeque::new(),
            window: Window::new(MOST_UNANSWERED),
            outgoing: Vec::new(),
            fault: None,
        };
        slcan.set_up(code, channel, settings.expects_answers)?;
        Ok(slcan)
    }

    fn system(&self, source: io::Error) -> OpenError {
        let name = self.name.clone();
        OpenError::System { name, source }
    }

    fn next_token(&mut self, until: Instant) -> Option<Token> {
        loop {
            if let Some(token) = self.lines.pop() {
                return Some(token);
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || self.fault.is_some() {
                return None;
            }
            self.fill(left);
        }
    }

    /// Reads what is there, or waits for it at most so long.
    fn fill(&mut self, most: Duration) {
        let mut buffer = [0; 1_024];
        match self.port.read_within(&mut buffer, most) {
            // A terminal whose other side is gone reads as its end.
            Ok(0) => self.fault = Some(LinkFault::Vanished),
            Ok(length) => self.lines.push(&buffer[..length]),
            Err(error) if is_transient(&error) => {}
            Err(_) => self.fault = Some(LinkFault::Vanished),
        }
    }

    /// Reads what comes within `most`, and settles what it answers.
    fn hear(&mut self, most: Duration) {
        self.fill(most);
        let now = Instant::now();
        while let Some(token) = self.lines.pop() {
            match token {
                Token::Line(line) => self.take_line(&line, now),
                Token::Bell => self.window.answer(Answer::Refused, now),
                Token::Overlong => {}
            }
        }
        self.window.tick(now);
    }

    fn take_line(&mut self, line: &[u8], now: Instant) {
        // Nothing else begins with these letters, so one in front of another line has lost its end.
        let is_answer = |byte: &&u8| matches!(byte, b'z' | b'Z');
        let answers = line.iter().take_while(is_answer).count();
        let rest = &line[answers..];
        for _ in 0..answers.max(usize::from(line.is_empty())) {
            self.window.answer(Answer::Taken, now);
        }
        // Anything else is none of our questions' answers.
        self.received.extend(lawicel::decode(rest));
    }

    fn check(&self) -> nb::Result<(), LinkFault> {
        self.fault
            .map_or(Ok(()), |fault| Err(nb::Error::Other(fault)))
    }

    /// Writes the command that waits, or a part of it; returns how many bytes the port took.
    fn write_out(&mut self) -> usize {
        let mut taken = 0;
        while taken < self.outgoing.len() {
            match self.port.write_within(&self.outgoing[taken..], WRITE_TIME) {
                Ok(0) => break,
                Ok(more) => taken += more,
                Err(error) if is_transient(&error) => break,
                Err(_) => {
                    self.fault = Some(LinkFault::Vanished);
                    break;
                }
            }
        }
        self.outgoing.drain(..taken);
        taken
    }
}

impl Can for Slcan {
    type Frame = Frame;
    type Error = LinkFault;

    /// Hands a frame to the adapter; returns one that the adapter has refused meanwhile.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, LinkFault> {
        self.check()?;
        if !self.window.has_room() {
            self.hear(Duration::ZERO);
        }
        self.write_out();
        self.check()?;
        if !self.window.has_room() || !self.outgoing.is_empty() {
            return Err(nb::Error::WouldBlock);
        }
        self.outgoing.extend(lawicel::encode(frame).bytes());
        self.outgoing.push(CR);
        let taken = self.write_out();
        self.check()?;
        if taken == 0 {
            self.outgoing.clear();
            return Err(nb::Error::WouldBlock);
        }
        // What the port took a part of goes out: its rest follows before anything else.
        self.window.sent(*frame, Instant::now());
        Ok(self.window.take_refused())
    }

    fn receive(&mut self) -> nb::Result<Frame, LinkFault> {
        if self.received.is_empty() && self.fault.is_none() {
            self.hear(Duration::ZERO);
        }
        match self.received.pop_front() {
            Some(frame) => Ok(frame),
            None => self.check().and(Err(nb::Error::WouldBlock)),
        }
    }
}

impl Adapter for Slcan {
    fn wait(&mut self, most: Duration) {
        if self.fault.is_none() && self.received.is_empty() {
            self.hear(most);
        }
    }

    fn fault(&self) -> Option<LinkFault> {
        self.fault
    }

    fn take_unknown(&mut self) -> usize {
        self.window.take_unknown()
    }

    fn is_silent(&self) -> bool {
        self.window.is_silent()
    }
}

impl Drop for Slcan {
    /// Takes the adapter off the bus, so that it does not fill up with frames that nobody reads.
    fn drop(&mut self) {
        // An adapter that takes one command at a time would not hear the next one.
        let until = Instant::now() + CLOSE_TIME;
        while !self.window.has_room() && self.fault.is_none() && Instant::now() < until {
            self.wait(Duration::from_millis(5));
        }
        if self.fault.is_none() {
            self.outgoing.extend([b'C', CR]);
            // The port is about to be closed; there is nobody left to tell.
            self.write_out();
        }
    }
}

impl core::fmt::Debug for Slcan {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Slcan")
            .field("name", &self.name)
            .field("fault", &self.fault)
            .finish_non_exhaustive()
    }
}

/// The port has nothing to say, or no room, for the moment.
fn is_transient(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests;
