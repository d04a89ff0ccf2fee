//! A host at the serial port of the board: the client of board-link, with the pauses of a computer that has other things to do.

use board_link::host::{Client, ClientConfig, Incoming, RequestError, StreamEnd};
use board_link::message::{Answer, BoardState, Event, Request, Snapshot};
use board_link::segment::{Begin, Segment, StreamPhase};
use board_link::{Reason, WhenDry};
use board_settings::Settings;

use crate::rig::Rig;

/// Bytes of a piece of the settings.
const CHUNK: usize = 100;

/// Bit rate of the port, on both boards.
pub const BIT_RATE: u32 = 921_600;

/// The client with its buffers.
pub type HostClient = Client<64, 8_192>;

/// A host.
pub struct Host {
    client: HostClient,
    random: fastrand::Rng,
    /// It looks at its port again after at most so long.
    longest_pause_ms: u64,
    wakes_ms: u64,
    /// Segments that wait to be sent.
    segments: std::vec::IntoIter<Segment>,
    is_feeding: bool,
    /// Everything that it was told, but for snapshots.
    pub told: Vec<Incoming>,
    /// The latest snapshot.
    pub snapshot: Snapshot,
    /// It does nothing any more.
    pub is_dead: bool,
}

impl Host {
    /// A host that looks at its port every millisecond, and its end of the line.
    #[must_use]
    pub fn new(rig: &mut Rig, seed: u64) -> Self {
        rig.serial_mut().set_rate(BIT_RATE);
        // Twelve seconds: the board answers to a command when it is carried out, and gives up after ten.
        let config = ClientConfig {
            tries: 120,
            ..ClientConfig::default()
        };
        Self {
            client: Client::new(config, seed as u32 ^ 0x5EED),
            random: fastrand::Rng::with_seed(seed),
            longest_pause_ms: 1,
            wakes_ms: 0,
            segments: Vec::new().into_iter(),
            is_feeding: false,
            told: Vec::new(),
            snapshot: Snapshot::default(),
            is_dead: false,
        }
    }

    /// From now on it looks at its port after 1 to so many milliseconds, another time each time.
    pub fn pause_up_to(&mut self, ms: u64) {
        self.longest_pause_ms = ms;
    }

    /// The client.
    pub fn client(&mut self) -> &mut HostClient {
        &mut self.client
    }

    /// Lets time pass for the board and the host.
    pub fn run_ms(&mut self, rig: &mut Rig, ms: u64) {
        for _ in 0..ms {
            rig.run_ms(1);
            self.look(rig);
        }
    }

    /// Lets time pass until something is so; false when it is not within `ms`.
    pub fn run_until(
        &mut self,
        rig: &mut Rig,
        ms: u64,
        mut is_so: impl FnMut(&mut Self, &mut Rig) -> bool,
    ) -> bool {
        for _ in 0..ms {
            if is_so(self, rig) {
                return true;
            }
            self.run_ms(rig, 1);
        }
        is_so(self, rig)
    }

    fn look(&mut self, rig: &mut Rig) {
        let now_ms = rig.now_ms();
        if self.is_dead || now_ms < self.wakes_ms {
            return;
        }
        self.wakes_ms = now_ms + self.random.u64(1..=self.longest_pause_ms);
        let now_us = 1_000 * now_ms;
        self.client.on_bytes(now_us, &rig.received_serial());
        while let Some(incoming) = self.client.next() {
            if let Incoming::Snapshot(snapshot) = incoming {
                self.snapshot = snapshot;
            } else {
                self.told.push(incoming);
            }
        }
        if self.is_feeding {
            self.client.feed(&mut self.segments);
        }
        self.client.poll(now_us);
        let bytes = self.client.output().to_vec();
        self.client.consume(bytes.len());
        rig.send_serial(&bytes);
    }

    /// Waits until the board has answered and the command is claimed.
    ///
    /// # Panics
    /// When that takes longer than three seconds.
    pub fn connect(&mut self, rig: &mut Rig) {
        let is_connected = self.run_until(rig, 3_000, |host, _| host.client.is_connected());
        assert!(is_connected, "{:?} {:#?}", self.told, rig.board().log());
    }

    /// Asks the board for something and waits for its reply.
    ///
    /// # Errors
    /// As [`Client::request`], and what the board refuses.
    ///
    /// # Panics
    /// When no reply comes within twelve seconds.
    pub fn ask(&mut self, rig: &mut Rig, request: Request) -> Result<Answer, RequestError> {
        let is_free = self.run_until(rig, 1_000, |host, _| {
            host.told
                .retain(|told| !matches!(told, Incoming::Reply { .. }));
            true
        });
        assert!(is_free);
        let ticket = self.client.request(request)?;
        let mut found = None;
        self.run_until(rig, 12_000, |host, _| {
            let reply = host.told.iter().find_map(|told| match told {
                Incoming::Reply { ticket: of, result } if *of == ticket => Some(result.clone()),
                _ => None,
            });
            found = reply;
            found.is_some()
        });
        found.expect("every request has an end")
    }

    /// The reason why the board refuses a request.
    ///
    /// # Panics
    /// When it does not refuse it.
    pub fn refusal(&mut self, rig: &mut Rig, request: Request) -> Reason {
        match self.ask(rig, request.clone()) {
            Err(RequestError::Refused(refused)) => refused.reason().expect("a known reason"),
            other => panic!("{request:?} is not refused: {other:?}"),
        }
    }

    /// The state of the board now.
    ///
    /// # Panics
    /// When it does not say it within a second.
    pub fn state(&mut self, rig: &mut Rig) -> BoardState {
        self.look_at_machine(rig).state
    }

    /// A snapshot of now.
    ///
    /// # Panics
    /// When it does not come within a second.
    pub fn look_at_machine(&mut self, rig: &mut Rig) -> Snapshot {
        // A session that was lost is made anew.
        self.connect(rig);
        let asked = self.ask(rig, Request::Snapshots { period: 5 });
        assert_eq!(asked, Ok(Answer::Done));
        let cycle = self.snapshot.cycle + 40;
        let is_new = self.run_until(rig, 1_000, |host, _| host.snapshot.cycle > cycle);
        assert!(is_new, "no snapshot comes");
        self.snapshot.clone()
    }

    /// Sends a stream from where the axes stand, and its end behind the last segment.
    ///
    /// # Panics
    /// When the client is not connected, or sends another one.
    pub fn stream(
        &mut self,
        rig: &mut Rig,
        number: u32,
        segments: Vec<Segment>,
        when_dry: WhenDry,
    ) {
        let stand = self.look_at_machine(rig);
        let from = stand.axes.iter();
        let begin = Begin {
            stream: number,
            start: None,
            when_dry,
            percent: 100,
            from: from.map(|axis| i64::from(axis.target) << 24).collect(),
        };
        self.client.begin(begin).expect("a client that is free");
        self.segments = segments.into_iter();
        self.is_feeding = true;
    }

    /// Ends no stream: nothing more comes.
    pub fn stop_feeding(&mut self) {
        self.is_feeding = false;
    }

    /// How the stream has ended for the client.
    #[must_use]
    pub fn stream_end(&self) -> Option<StreamEnd> {
        self.told.iter().find_map(|told| match told {
            Incoming::Stream(end) => Some(*end),
            _ => None,
        })
    }

    /// The phases that a stream has had, as the board has told them.
    #[must_use]
    pub fn phases(&self, number: u32) -> Vec<StreamPhase> {
        let events = self.told.iter().filter_map(|told| match told {
            Incoming::Event { event, .. } => Some(*event),
            _ => None,
        });
        let phases = events.filter_map(|event| match event {
            Event::Stream { stream, phase, .. } if stream == number => Some(phase),
            _ => None,
        });
        phases.collect()
    }

    /// Writes settings for the next start of the board.
    ///
    /// # Errors
    /// What the board refuses.
    ///
    /// # Panics
    /// When the settings are longer than any.
    pub fn write_settings(
        &mut self,
        rig: &mut Rig,
        settings: &Settings,
    ) -> Result<Answer, RequestError> {
        let mut room = [0; board_settings::LONGEST];
        let bytes = settings.write(&mut room).expect("settings that fit");
        for (place, chunk) in bytes.chunks(CHUNK).enumerate() {
            let request = Request::WriteSettings {
                offset: (place * CHUNK) as u32,
                bytes: chunk.iter().copied().collect(),
            };
            self.ask(rig, request)?;
        }
        let (length, checksum) = (bytes.len() as u32, board_link::frame::checksum(bytes));
        self.ask(rig, Request::CommitSettings { length, checksum })
    }

    /// Closes the contacts and enables the drives by command.
    ///
    /// # Panics
    /// When they are not enabled then.
    pub fn bring_up(&mut self, rig: &mut Rig) {
        rig.make_ready();
        rig.close(crate::Contact::Enable);
        self.run_ms(rig, 50);
        self.connect(rig);
        let enabled = self.ask(rig, Request::Enable);
        assert_eq!(enabled, Ok(Answer::Done), "{:#?}", rig.board().log());
        assert_eq!(self.state(rig), BoardState::Enabled);
    }
}
