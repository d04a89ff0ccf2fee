//! A board with a simulated machine, and a wire that delays, loses and damages bytes; time is a number.
#![allow(dead_code, reason = "each test uses a part")]

use std::collections::VecDeque;

use board_link::board::{Application, Board, BoardConfig, Command, Link, Machine};
use board_link::host::{Client, ClientConfig, Incoming};
use board_link::message::{AxisSnapshot, BoardState, Event, FaultEntry, Info, Origin};
use board_link::segment::{
    AxisSegment, Begin, OfAxes, Player, Segment, SegmentConfig, SegmentQueue, Shape,
};
use board_link::{AxisLimits, Reason, Refused, WhenDry};
use trajectory::{Limits, Position, Time};

#[path = "../judge/mod.rs"]
pub(crate) mod judge;
use judge::Judge;

pub(crate) const AXES: usize = 2;
pub(crate) const OUT: usize = 2_048;
pub(crate) type TestClient = Client<16, OUT>;

pub(crate) fn limits() -> AxisLimits {
    AxisLimits {
        motion: Limits::without_jerk(100.0, 1.5).unwrap(),
        lowest: Position::from_counts(-50_000),
        highest: Position::from_counts(50_000),
    }
}

/// The application: what the cycle would do with queues.
pub(crate) struct Mock {
    pub(crate) state: BoardState,
    pub(crate) targets: [i32; AXES],
    pub(crate) stop_open: bool,
    /// The numbers of their faults.
    pub(crate) faults: [u16; AXES],
    pub(crate) boot: u32,
    /// Everything that was ordered.
    pub(crate) ordered: Vec<Command>,
    commands: VecDeque<(u16, Command)>,
    results: VecDeque<(u16, Result<(), Refused>)>,
    pub(crate) events: VecDeque<Event>,
    pub(crate) stored: Vec<u8>,
    pub(crate) staging: Vec<u8>,
    /// The cycle does not come to commands.
    pub(crate) is_stuck: bool,
    /// What the axes count from; none without a homing.
    pub(crate) origins: OfAxes<Origin>,
    /// A homing that goes on.
    pub(crate) homing: Option<u16>,
}

impl Mock {
    fn new(boot: u32, targets: [i32; AXES]) -> Self {
        Self {
            state: BoardState::Off,
            targets,
            stop_open: false,
            faults: [0; AXES],
            boot,
            ordered: Vec::new(),
            commands: VecDeque::new(),
            results: VecDeque::new(),
            events: VecDeque::new(),
            stored: b"first settings".to_vec(),
            staging: vec![0; 300],
            is_stuck: false,
            origins: OfAxes::new(),
            homing: None,
        }
    }

    /// The homing ends so.
    pub(crate) fn end_homing(&mut self, result: Result<(), Refused>) {
        let ticket = self.homing.take().expect("a homing");
        self.results.push_back((ticket, result));
    }

    fn carry_out(
        &mut self,
        command: Command,
        player: &mut Player<'_, AXES>,
    ) -> Result<(), Refused> {
        match command {
            Command::Enable if self.stop_open => return Err(Reason::StopInput.plain()),
            Command::Enable => self.state = BoardState::Enabled,
            Command::Disable => {
                player.halt();
                self.state = BoardState::Off;
            }
            Command::Halt => player.halt(),
            Command::Stop | Command::Clear => {}
            Command::Home if self.state != BoardState::Enabled => {
                return Err(Reason::NotEnabled.plain());
            }
            Command::Home => {}
            Command::SaveSettings { .. } if self.state == BoardState::Enabled => {
                return Err(Reason::Enabled.plain());
            }
            Command::SaveSettings { length } => {
                self.stored = self.staging[..length as usize].to_vec();
            }
        }
        Ok(())
    }
}

impl Application for Mock {
    const HOMES: bool = true;

    fn info(&self) -> Info {
        Info {
            board: "mock".try_into().unwrap(),
            firmware: "0.1.0".try_into().unwrap(),
            boot: self.boot,
            cycle_us: 1_000,
            settings: 300,
            faults: 2,
            ..Info::default()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> Result<(), Refused> {
        if self.commands.len() >= 4 {
            return Err(Reason::Busy.because(4, 5));
        }
        self.commands.push_back((ticket, command));
        Ok(())
    }

    fn result(&mut self) -> Option<(u16, Result<(), Refused>)> {
        self.results.pop_front()
    }

    fn machine(&mut self) -> Machine {
        Machine {
            state: self.state,
            axes: self
                .targets
                .into_iter()
                .zip(self.faults)
                .map(|(target, fault)| AxisSnapshot {
                    target,
                    position: target,
                    fault,
                    ..AxisSnapshot::default()
                })
                .collect(),
            late_cycles: 0,
        }
    }

    fn event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn origin(&mut self, axis: usize) -> Origin {
        self.origins.get(axis).copied().unwrap_or_default()
    }

    fn settings(&self) -> &[u8] {
        &self.stored
    }

    fn staging(&mut self) -> &mut [u8] {
        &mut self.staging
    }

    fn check_settings(&mut self, length: u32) -> Result<(), Refused> {
        if self.staging[..length as usize].contains(&0xEE) {
            return Err(Reason::Settings.because(0, 0xEE));
        }
        Ok(())
    }

    fn fault(&mut self, index: u32) -> Option<FaultEntry> {
        (index < 2).then(|| FaultEntry {
            number: 40 - index,
            code: 7,
            ..FaultEntry::default()
        })
    }
}

/// A board with its machine.
pub(crate) struct Bench {
    pub(crate) board: Board<'static, Mock, AXES>,
    pub(crate) link: Link<OUT>,
    pub(crate) player: Player<'static, AXES>,
    /// The cycle.
    pub(crate) now: u64,
    pub(crate) judges: [Judge; AXES],
    /// Cycles in which a set-point changed.
    pub(crate) moved: u64,
    was_moving: bool,
    /// Where every axis stood last.
    targets: [Position; AXES],
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::started(1, [0; AXES], 1_000)
    }

    fn started(boot: u32, targets: [i32; AXES], now: u64) -> Self {
        // The memory of a test: a few kilobytes for each start.
        let queue = Box::leak(Box::new(SegmentQueue::<AXES, 33>::new()));
        let config = SegmentConfig::with_cycles_per_second(1_000);
        let (admission, player) = queue.split(&[limits(); AXES], config).unwrap();
        let config = BoardConfig {
            silence: 1_000,
            ..BoardConfig::with_cycles_per_second(1_000)
        };
        Self {
            board: Board::new(Mock::new(boot, targets), Some(admission), config),
            link: Link::new(),
            player,
            now,
            judges: [Judge::default(); AXES],
            moved: 0,
            was_moving: false,
            targets: targets.map(Position::from_counts),
        }
    }

    /// A reset: everything but the machine begins anew.
    pub(crate) fn reset(&mut self) {
        let mock = self.board.application();
        let (boot, targets) = (mock.boot + 1, mock.targets);
        let judges = self.judges;
        *self = Self::started(boot, targets, 0);
        self.judges = judges;
        for (judge, at) in self.judges.iter_mut().zip(self.targets) {
            // The drives are off: where they come to rest is not the board's.
            judge.stand_at(at);
        }
    }

    pub(crate) fn mock(&mut self) -> &mut Mock {
        self.board.application()
    }

    /// One cycle of the interrupt.
    pub(crate) fn cycle(&mut self) {
        self.now += 1;
        let stand = self.mock().targets.map(Position::from_counts);
        let mock = self.board.application();
        if mock.stop_open {
            self.player.halt();
            mock.state = BoardState::StopOpen;
        }
        while !mock.is_stuck
            && let Some((ticket, command)) = mock.commands.pop_front()
        {
            mock.ordered.push(command);
            let homes = mock.origins.contains(&Origin::Unknown);
            if command == Command::Home && mock.state == BoardState::Enabled && homes {
                mock.homing = Some(ticket);
                continue;
            }
            if command == Command::Stop && mock.homing.is_some() {
                mock.end_homing(Err(Reason::HomeStopped.at(0, 0, 0)));
            }
            let result = mock.carry_out(command, &mut self.player);
            mock.results.push_back((ticket, result));
        }
        if mock.state != BoardState::Enabled {
            self.player.halt();
        }
        let mut out = self.targets;
        let has_set_points = self.player.advance(self.now, &stand, &mut out);
        if has_set_points {
            assert_eq!(
                mock.state,
                BoardState::Enabled,
                "it moves while it is not enabled"
            );
            if !self.was_moving {
                // From a count on, which may be half a count from where the last stream stopped.
                for (judge, &at) in self.judges.iter_mut().zip(&out) {
                    judge.stand_at(at);
                }
            }
            self.moved += u64::from(out != self.targets);
            self.targets = out;
            mock.targets = out.map(|position| position.counts());
            for (judge, &at) in self.judges.iter_mut().zip(&out) {
                judge.see(at);
            }
        }
        self.was_moving = has_set_points;
    }

    /// What went out kept the limits. A halt is a step.
    pub(crate) fn check_limits(&self) {
        let motion = limits().motion;
        for judge in &self.judges {
            assert!(judge.velocity <= f64::from(motion.velocity()) * 1.000_1);
            assert!(
                judge.acceleration <= f64::from(motion.acceleration()) * 1.000_1,
                "{judge:?}"
            );
        }
    }
}

/// One direction of a wire.
pub(crate) struct Wire {
    random: fastrand::Rng,
    /// Bytes with the time at which they arrive.
    on_the_way: VecDeque<(u64, u8)>,
    pub(crate) longest_delay: u64,
    /// One of so many bytes is lost or damaged; 0 for none.
    pub(crate) one_damaged_of: u32,
}

impl Wire {
    pub(crate) fn new(seed: u64, longest_delay: u64, one_damaged_of: u32) -> Self {
        Self {
            random: fastrand::Rng::with_seed(seed),
            on_the_way: VecDeque::new(),
            longest_delay,
            one_damaged_of,
        }
    }

    pub(crate) fn send(&mut self, now: u64, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let latest = self.on_the_way.back().map_or(0, |last| last.0);
        let at = latest.max(now + self.random.u64(0..=self.longest_delay));
        for &byte in bytes {
            let is_damaged =
                self.one_damaged_of > 0 && self.random.u32(0..self.one_damaged_of) == 0;
            match self.random.u8(0..3) {
                _ if !is_damaged => self.on_the_way.push_back((at, byte)),
                0 => {}
                1 => self
                    .on_the_way
                    .push_back((at, byte ^ (1 << self.random.u8(0..8)))),
                _ => self.on_the_way.push_back((at, self.random.u8(..))),
            }
        }
    }

    pub(crate) fn arrived(&mut self, now: u64) -> Vec<u8> {
        let count = self
            .on_the_way
            .iter()
            .take_while(|byte| byte.0 <= now)
            .count();
        self.on_the_way.drain(..count).map(|byte| byte.1).collect()
    }
}

/// A host, a wire and a board. A step is a millisecond and a cycle.
pub(crate) struct World {
    pub(crate) bench: Bench,
    pub(crate) client: TestClient,
    pub(crate) to_board: Wire,
    pub(crate) to_host: Wire,
    /// Milliseconds.
    pub(crate) time: u64,
    pub(crate) told: Vec<Incoming>,
    /// The host does nothing.
    pub(crate) is_dead: bool,
}

impl World {
    pub(crate) fn new(seed: u64, longest_delay: u64, one_damaged_of: u32) -> Self {
        Self {
            bench: Bench::new(),
            client: TestClient::new(Self::config(), seed as u32 + 1),
            to_board: Wire::new(seed, longest_delay, one_damaged_of),
            to_host: Wire::new(seed + 1_000_000, longest_delay, one_damaged_of),
            time: 0,
            told: Vec::new(),
            is_dead: false,
        }
    }

    pub(crate) fn config() -> ClientConfig {
        ClientConfig {
            timeout_us: 130_000,
            tries: 7,
            ..ClientConfig::default()
        }
    }

    pub(crate) fn now_us(&self) -> u64 {
        7_000_000 + self.time * 1_000
    }

    pub(crate) fn step(&mut self) {
        self.time += 1;
        let (time, now_us) = (self.time, self.now_us());
        let bytes = self.to_host.arrived(time);
        if !self.is_dead {
            self.client.on_bytes(now_us, &bytes);
            self.client.poll(now_us);
            while let Some(incoming) = self.client.next() {
                self.told.push(incoming);
            }
            let out = self.client.output().to_vec();
            self.client.consume(out.len());
            self.to_board.send(time, &out);
        }
        let bytes = self.to_board.arrived(time);
        let bench = &mut self.bench;
        bench.link.on_bytes(&mut bench.board, bench.now, &bytes);
        bench.cycle();
        bench.link.poll(&mut bench.board, bench.now);
        let out = bench.link.output().to_vec();
        bench.link.consume(out.len());
        self.to_host.send(time, &out);
    }

    /// Steps until a condition holds.
    pub(crate) fn until(&mut self, what: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        for _ in 0..120_000 {
            if holds(self) {
                return;
            }
            self.step();
        }
        panic!("{what} never came: {:?}", self.told);
    }

    /// Sends a request until it has a reply.
    pub(crate) fn request(
        &mut self,
        request: board_link::message::Request,
    ) -> Result<board_link::message::Answer, board_link::host::RequestError> {
        let mut ticket = None;
        self.until("a reply", |world| {
            if ticket.is_none() {
                ticket = world.client.request(request.clone()).ok();
            }
            world.reply(ticket).is_some()
        });
        self.reply(ticket).unwrap()
    }

    fn reply(
        &self,
        wanted: Option<u16>,
    ) -> Option<Result<board_link::message::Answer, board_link::host::RequestError>> {
        self.told.iter().find_map(|incoming| match incoming {
            Incoming::Reply { ticket, result } if Some(*ticket) == wanted => Some(result.clone()),
            _ => None,
        })
    }

    pub(crate) fn connect_and_enable(&mut self) {
        self.until("a connection", |world| world.client.is_connected());
        self.request(board_link::message::Request::Enable).unwrap();
    }

    pub(crate) fn begin_here(&mut self, stream: u32, when_dry: WhenDry) {
        let begin = begin(stream, self.bench.mock().targets, when_dry);
        self.client.begin(begin).unwrap();
    }
}

pub(crate) fn begin(stream: u32, from: [i32; AXES], when_dry: WhenDry) -> Begin {
    Begin {
        stream,
        start: None,
        when_dry,
        percent: 100,
        from: from
            .map(|counts| Position::from_counts(counts).units())
            .into_iter()
            .collect(),
    }
}

/// So many segments of 20 ms from rest to rest: axis 0 goes this way, axis 1 half of it back.
pub(crate) fn segments(count: u32, from: [i32; AXES], way: i32) -> Vec<Segment> {
    let share = |place: u32| {
        let u = f64::from(place) / f64::from(count);
        let at = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        let slope = 30.0 * u * u * (1.0 - u) * (1.0 - u) / f64::from(count);
        (at, slope)
    };
    let units = |counts: f64| (counts * Position::UNITS as f64).round() as i64;
    (0..count)
        .map(|place| {
            let axis = |from: i32, way: f64| {
                let ((_, leaving), (at, arriving)) = (share(place), share(place + 1));
                AxisSegment {
                    end: Position::from_counts(from).units() + units(way * at),
                    shape: Shape::Cubic {
                        leaving: units(way * leaving),
                        arriving: units(way * arriving),
                    },
                }
            };
            let axes: OfAxes<AxisSegment> = [
                axis(from[0], f64::from(way)),
                axis(from[1], f64::from(way) / -2.0),
            ]
            .into_iter()
            .collect();
            let duration = Time::from_cycles(20).ticks();
            Segment { duration, axes }
        })
        .collect()
}
