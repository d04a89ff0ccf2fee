//! The bytes between this computer and a board: a port, the client of the protocol, and the clock.

use std::collections::VecDeque;
use std::io::ErrorKind;
use std::time::{Duration, Instant};

use board_link::host::{Client, ClientConfig, Incoming, RequestError};
use board_link::message::{Answer, Info, Request};

use super::arguments::PortOptions;
use super::error::BoardError;
use crate::link::BytePort;

/// A board answers its first request within this time, whatever else is under way.
const CONNECT_TIME: Duration = Duration::from_secs(2);
/// How long a host that is gone may keep the command: half a second on the boards, and what the way takes.
const TAKEN_TIME: Duration = Duration::from_secs(3);
/// How often the client looks at its clock.
const POLL: Duration = Duration::from_millis(2);
/// Time for a port that takes no bytes at the moment.
const WRITE_TIME: Duration = Duration::from_millis(10);

/// Segments that are kept until the board has them, and bytes on their way to it.
pub(super) type BoardClient = Client<64, 4_096>;

/// A connection to a board.
pub(super) struct Session {
    port: BytePort,
    client: Box<BoardClient>,
    start: Instant,
    /// What came in while something else was waited for, oldest first.
    incoming: VecDeque<Incoming>,
    name: String,
}

impl Session {
    /// Opens the port and waits for the board. One that `commands` has the board to itself; one that only reads disturbs nobody.
    ///
    /// # Errors
    /// [`BoardError`]; nothing was switched or moved.
    pub(super) fn open(options: &PortOptions, commands: bool) -> Result<Self, BoardError> {
        let mut port = BytePort::open(&options.port, options.baud).map_err(BoardError::Open)?;
        // What a board has told somebody else.
        port.clear_input().map_err(|source| BoardError::Port {
            port: options.port.clone(),
            source,
        })?;
        let config = ClientConfig {
            commands,
            ..ClientConfig::default()
        };
        let mut session = Self {
            port,
            client: Box::new(Client::new(config, seed())),
            start: Instant::now(),
            incoming: VecDeque::new(),
            name: options.port.clone(),
        };
        session.connect()?;
        Ok(session)
    }

    /// Has the board to itself from now on.
    ///
    /// # Errors
    /// [`BoardError::Unavailable`] when another host commands.
    pub(super) fn take_command(&mut self) -> Result<(), BoardError> {
        *self.client = Client::new(ClientConfig::default(), seed());
        self.connect()
    }

    fn connect(&mut self) -> Result<(), BoardError> {
        let start = Instant::now();
        let mut unavailable = None;
        loop {
            let most = if unavailable.is_some() {
                TAKEN_TIME
            } else {
                CONNECT_TIME
            };
            if start.elapsed() >= most {
                let (port, seconds) = (self.name.clone(), most.as_secs_f64());
                let answers = self.client.losses().version > 0;
                return Err(match unavailable {
                    Some(refused) => BoardError::Unavailable { port, refused },
                    None if answers => BoardError::OtherVersion { port },
                    None => BoardError::NoAnswer { port, seconds },
                });
            }
            match self.next(POLL)? {
                Some(Incoming::Connected { .. }) => return Ok(()),
                Some(Incoming::Unavailable(refused)) => unavailable = Some(refused),
                Some(other) => self.incoming.push_back(other),
                None => {}
            }
        }
    }

    /// What the board is.
    pub(super) fn info(&self) -> Info {
        self.client.info().cloned().unwrap_or_default()
    }

    /// The port.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The client, for what needs no waiting.
    pub(super) fn client(&mut self) -> &mut BoardClient {
        &mut self.client
    }

    /// What comes in next, within `most`.
    ///
    /// # Errors
    /// When the port is gone.
    pub(super) fn next(&mut self, most: Duration) -> Result<Option<Incoming>, BoardError> {
        let until = Instant::now() + most;
        loop {
            self.exchange(until)?;
            let incoming = self.client.next();
            if incoming.is_some() || Instant::now() >= until {
                return Ok(incoming);
            }
        }
    }

    /// The same, with what was put aside before.
    ///
    /// # Errors
    /// As [`Self::next`].
    pub(super) fn next_or_earlier(
        &mut self,
        most: Duration,
    ) -> Result<Option<Incoming>, BoardError> {
        match self.incoming.pop_front() {
            Some(earlier) => Ok(Some(earlier)),
            None => self.next(most),
        }
    }

    /// Bytes both ways, until something has come or it is time.
    fn exchange(&mut self, until: Instant) -> Result<(), BoardError> {
        let now_us = self.now_us();
        self.client.poll(now_us);
        let output = self.client.output();
        if !output.is_empty() {
            match self.port.write_within(output, WRITE_TIME) {
                Ok(written) => self.client.consume(written),
                Err(error) if is_patience(error.kind()) => {}
                Err(source) => return Err(self.gone(source)),
            }
        }
        let most = until.saturating_duration_since(Instant::now()).min(POLL);
        let mut buffer = [0; 4_096];
        match self.port.read_within(&mut buffer, most) {
            Ok(0) => Err(self.gone(ErrorKind::UnexpectedEof.into())),
            Ok(length) => {
                let now_us = self.now_us();
                let bytes = buffer.get(..length).unwrap_or_default();
                self.client.on_bytes(now_us, bytes);
                Ok(())
            }
            Err(error) if is_patience(error.kind()) => Ok(()),
            Err(source) => Err(self.gone(source)),
        }
    }

    fn gone(&self, source: std::io::Error) -> BoardError {
        let port = self.name.clone();
        BoardError::Port { port, source }
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    /// Asks for something and waits for the answer; `what` it is, for messages. Snapshots that came before it are of before it, be they asked
    /// for by the program before this one: they are forgotten.
    ///
    /// # Errors
    /// [`BoardError::Refused`], and when no answer comes.
    pub(super) fn ask(
        &mut self,
        what: &'static str,
        request: Request,
    ) -> Result<Answer, BoardError> {
        let ticket = self
            .client
            .request(request)
            .map_err(|source| BoardError::Request { what, source })?;
        loop {
            match self.next(POLL)? {
                Some(Incoming::Reply { ticket: of, result }) if of == ticket => {
                    let is_kept = |one: &Incoming| !matches!(one, Incoming::Snapshot(_));
                    self.incoming.retain(is_kept);
                    return result.map_err(|error| match error {
                        RequestError::Refused(refused) => BoardError::Refused { what, refused },
                        RequestError::Lost => BoardError::Reset { what },
                        source => BoardError::Request { what, source },
                    });
                }
                Some(other) => self.incoming.push_back(other),
                None => {}
            }
        }
    }

    /// Ends the snapshots, which would wait for the next program, and gives the command back.
    ///
    /// # Errors
    /// As [`Self::next`].
    pub(super) fn leave(&mut self) -> Result<(), BoardError> {
        let period = 0;
        match self.ask("end the snapshots", Request::Snapshots { period }) {
            Ok(_) | Err(BoardError::Refused { .. } | BoardError::Request { .. }) => {}
            Err(error) => return Err(error),
        }
        match self.ask("give the command back", Request::Release) {
            // It has no command any more.
            Ok(_) | Err(BoardError::Refused { .. } | BoardError::Request { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// No other start of a program has the same.
fn seed() -> u32 {
    let since_1970 = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let ns = since_1970.map_or(0, |time| time.as_nanos() as u32);
    ns ^ std::process::id().rotate_left(16)
}

/// Whether it only says that nothing is there at the moment.
pub(super) fn is_patience(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}
