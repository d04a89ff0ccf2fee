//! A Lawicel adapter on a serial port.
//!
//! Each frame is a command, and the adapter answers commands in their order: `z` or `Z` for a frame that it took, BEL for
//! one that it refused because its queue is full. The master counts a frame when [`Can::transmit`] returns, which is
//! before that answer; a refused frame therefore comes back from a later `transmit`, as one that the controller gave back
//! unsent. Adapters that answer nothing work too, then nobody knows of refused frames.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use drive_sim::Frame;
use embedded_can::nb::Can;
use serialport::{ClearBuffer, SerialPort};

use super::{LinkFault, OpenError};
use crate::lawicel::{self, BEL, CR, Lines, Token};

/// Frames on their way to an adapter that answers. Less than the queue of any adapter, so that one is seldom refused.
const MOST_UNANSWERED: usize = 16;
/// How long an adapter may take to answer a command while it is set up.
const ANSWER_TIME: Duration = Duration::from_millis(500);
/// How long a command may wait for room in the port.
const WRITE_TIME: Duration = Duration::from_millis(2);
/// How long bytes of an earlier use may trickle in.
const SETTLE_TIME: Duration = Duration::from_millis(50);

/// What the adapter does on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    /// It sends and acknowledges.
    Open,
    /// It only listens, and does not even acknowledge.
    ListenOnly,
}

/// An open adapter.
pub(crate) struct Slcan {
    name: String,
    port: Box<dyn SerialPort>,
    lines: Lines,
    received: VecDeque<Frame>,
    /// Frames that the adapter has not answered for yet, oldest first.
    unanswered: VecDeque<Frame>,
    /// Frames that the adapter has refused, to be given back.
    refused: VecDeque<Frame>,
    /// The adapter has answered for a frame at least once.
    answers: bool,
    fault: Option<LinkFault>,
}

impl Slcan {
    /// Opens a port, makes sure that a Lawicel adapter answers there, sets the bit rate and goes on the bus.
    ///
    /// # Errors
    /// [`OpenError`] says what is wrong with the port or with what answers on it.
    pub(super) fn open(
        name: &str,
        baud: u32,
        kbit_per_s: u32,
        channel: Channel,
    ) -> Result<Self, OpenError> {
        let code = lawicel::bit_rate_code(kbit_per_s).ok_or(OpenError::BitRate { kbit_per_s })?;
        let port = serialport::new(name, baud)
            .timeout(WRITE_TIME)
            .open()
            .map_err(|error| OpenError::of_port(name, &error))?;
        let mut slcan = Self {
            name: name.to_owned(),
            port,
            lines: Lines::default(),
            received: VecDeque::new(),
            unanswered: VecDeque::new(),
            refused: VecDeque::new(),
            answers: false,
            fault: None,
        };
        slcan.set_up(code, channel)?;
        Ok(slcan)
    }

    fn set_up(&mut self, bit_rate_code: char, channel: Channel) -> Result<(), OpenError> {
        // Ends half a command of an earlier user, and closes the channel if it was left open.
        self.send_line("\r\rC")
            .map_err(|error| self.system(error))?;
        self.wait_out(SETTLE_TIME);
        let cleared = self.port.clear(ClearBuffer::Input);
        cleared.map_err(|error| self.system(error.into()))?;
        self.lines.clear();
        self.ask_version()?;
        self.command(&format!("S{bit_rate_code}"))?;
        self.command(match channel {
            Channel::Open => "O",
            Channel::ListenOnly => "L",
        })
    }

    fn ask_version(&mut self) -> Result<(), OpenError> {
        self.send_line("V").map_err(|error| self.system(error))?;
        let until = Instant::now() + ANSWER_TIME;
        let mut heard = Vec::new();
        while let Some(token) = self.next_token(until) {
            match token {
                Token::Line(line) if line.first() == Some(&b'V') => return Ok(()),
                Token::Line(line) => heard.extend(line),
                Token::Bell => heard.push(BEL),
                Token::Overlong => {}
            }
        }
        let port = self.name.clone();
        Err(OpenError::NoAdapter { port, heard })
    }

    /// A command of the set-up. Silence is no refusal: some adapters answer nothing.
    fn command(&mut self, command: &str) -> Result<(), OpenError> {
        self.send_line(command)
            .map_err(|error| self.system(error))?;
        match self.next_token(Instant::now() + ANSWER_TIME) {
            Some(Token::Bell) => Err(OpenError::CommandRefused {
                port: self.name.clone(),
                command: command.to_owned(),
            }),
            _ => Ok(()),
        }
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

    fn wait_out(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while self.next_token(until).is_some() {}
    }

    fn send_line(&mut self, line: &str) -> io::Result<()> {
        let mut bytes = line.as_bytes().to_vec();
        bytes.push(CR);
        self.port.set_timeout(WRITE_TIME)?;
        self.port.write_all(&bytes)
    }

    /// Reads what is there, or waits for it at most so long.
    fn fill(&mut self, most: Duration) {
        let mut buffer = [0; 1_024];
        let read = self
            .port
            .set_timeout(most)
            .map_err(io::Error::from)
            .and_then(|()| self.port.read(&mut buffer));
        match read {
            // A terminal whose other side is gone reads as its end.
            Ok(0) => self.fault = Some(LinkFault::Vanished),
            Ok(length) => self.lines.push(&buffer[..length]),
            Err(error) if is_transient(&error) => {}
            Err(_) => self.fault = Some(LinkFault::Vanished),
        }
    }

    fn take_lines(&mut self) {
        while let Some(token) = self.lines.pop() {
            match token {
                Token::Line(line) if matches!(line.as_slice(), [] | b"z" | b"Z") => {
                    self.answers = true;
                    self.unanswered.pop_front();
                }
                Token::Bell => {
                    self.answers = true;
                    self.refused.extend(self.unanswered.pop_front());
                }
                // Anything else is none of our questions' answers.
                Token::Line(line) => self.received.extend(lawicel::decode(&line)),
                Token::Overlong => {}
            }
        }
    }

    pub(super) fn fault(&self) -> Option<LinkFault> {
        self.fault
    }

    pub(super) fn wait(&mut self, most: Duration) {
        if self.fault.is_none() && self.received.is_empty() {
            self.fill(most);
            self.take_lines();
        }
    }

    fn check(&self) -> nb::Result<(), LinkFault> {
        self.fault
            .map_or(Ok(()), |fault| Err(nb::Error::Other(fault)))
    }
}

impl Can for Slcan {
    type Frame = Frame;
    type Error = LinkFault;

    /// Hands a frame to the adapter; returns one that the adapter has refused meanwhile.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, LinkFault> {
        self.check()?;
        if self.unanswered.len() >= MOST_UNANSWERED {
            if self.answers {
                return Err(nb::Error::WouldBlock);
            }
            self.unanswered.pop_front();
        }
        match self.send_line(&lawicel::encode(frame)) {
            Ok(()) => {}
            Err(error) if is_transient(&error) => return Err(nb::Error::WouldBlock),
            Err(_) => self.fault = Some(LinkFault::Vanished),
        }
        self.check()?;
        self.unanswered.push_back(*frame);
        Ok(self.refused.pop_front())
    }

    fn receive(&mut self) -> nb::Result<Frame, LinkFault> {
        if self.received.is_empty() && self.fault.is_none() {
            self.fill(Duration::ZERO);
            self.take_lines();
        }
        match self.received.pop_front() {
            Some(frame) => Ok(frame),
            None => self.check().and(Err(nb::Error::WouldBlock)),
        }
    }
}

impl Drop for Slcan {
    /// Takes the adapter off the bus, so that it does not fill up with frames that nobody reads.
    fn drop(&mut self) {
        if self.fault.is_none() {
            // The port is about to be closed; there is nobody left to tell.
            let _ = self.send_line("C");
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
mod tests {
    use embedded_can::{Frame as _, StandardId};

    use super::super::fake_adapter::{FakeAdapter, set_up_answer};
    use super::*;

    fn open(adapter: &FakeAdapter) -> Result<Slcan, OpenError> {
        Slcan::open(adapter.port(), 115_200, 1_000, Channel::Open)
    }

    fn frame(byte: u8) -> Frame {
        Frame::new(StandardId::new(0x03C).unwrap(), &[byte]).unwrap()
    }

    /// Waits until the adapter has answered for every frame.
    fn await_answers(slcan: &mut Slcan) {
        let start = Instant::now();
        while !slcan.unanswered.is_empty() && start.elapsed() < Duration::from_secs(30) {
            slcan.wait(Duration::from_millis(5));
        }
        assert!(slcan.unanswered.is_empty());
    }

    #[test]
    fn a_refused_frame_comes_back_from_a_later_transmit() {
        let adapter = FakeAdapter::new("refuse", |line| match line {
            b"t03C102" => b"\x07".to_vec(),
            b"t03C1FF" => b"z\rt03D1EE\r".to_vec(),
            [b't', ..] => b"z\r".to_vec(),
            line => set_up_answer(line),
        });
        let mut slcan = open(&adapter).unwrap();
        for byte in [1, 2, 3] {
            assert_eq!(slcan.transmit(&frame(byte)), Ok(None));
        }
        await_answers(&mut slcan);
        assert_eq!(slcan.transmit(&frame(4)), Ok(Some(frame(2))));
        assert_eq!(slcan.transmit(&frame(0xFF)), Ok(None));
        await_answers(&mut slcan);
        while slcan.received.is_empty() {
            slcan.wait(Duration::from_millis(5));
        }
        let alarm = Frame::new(StandardId::new(0x03D).unwrap(), &[0xEE]).unwrap();
        assert_eq!(slcan.receive(), Ok(alarm));
        assert_eq!(slcan.receive(), Err(nb::Error::WouldBlock));
    }

    #[test]
    fn an_adapter_that_falls_silent_holds_up_and_one_that_never_answers_does_not() {
        let adapter = FakeAdapter::new("silent", |line| match line {
            b"t03C100" => b"z\r".to_vec(),
            [b't', ..] => Vec::new(),
            line => set_up_answer(line),
        });
        let mut slcan = open(&adapter).unwrap();
        for _ in 0..3 * MOST_UNANSWERED {
            assert_eq!(slcan.transmit(&frame(1)), Ok(None));
        }
        assert_eq!(slcan.transmit(&frame(0)), Ok(None));
        while !slcan.answers {
            slcan.wait(Duration::from_millis(5));
        }
        let until_full = (0..=MOST_UNANSWERED).map(|_| slcan.transmit(&frame(1)));
        assert_eq!(until_full.last(), Some(Err(nb::Error::WouldBlock)));
    }

    #[test]
    fn an_adapter_that_is_gone_is_a_final_fault() {
        let mut adapter = FakeAdapter::new("gone", set_up_answer);
        let mut slcan = open(&adapter).unwrap();
        adapter.vanish();
        while slcan.fault().is_none() {
            slcan.wait(Duration::from_millis(5));
        }
        assert_eq!(slcan.fault(), Some(LinkFault::Vanished));
        let gone = || nb::Error::Other(LinkFault::Vanished);
        assert_eq!(slcan.transmit(&frame(1)), Err(gone()));
        assert_eq!(slcan.receive(), Err(gone()));
    }

    #[test]
    fn what_does_not_answer_as_an_adapter_is_told() {
        let modem = FakeAdapter::new("modem", |_| b"ERROR\r".to_vec());
        let Err(error @ OpenError::NoAdapter { .. }) = open(&modem) else {
            panic!("a modem is no adapter");
        };
        assert!(error.to_string().contains("said \"ERROR\""), "{error}");
        let narrow = FakeAdapter::new("narrow", |line| match line {
            b"S8" => b"\x07".to_vec(),
            line => set_up_answer(line),
        });
        let refused = open(&narrow).unwrap_err();
        assert!(
            refused.to_string().contains("refuses the command S8"),
            "{refused}"
        );
        let odd = Slcan::open(narrow.port(), 115_200, 333, Channel::Open);
        assert!(matches!(odd, Err(OpenError::BitRate { kbit_per_s: 333 })));
    }
}
