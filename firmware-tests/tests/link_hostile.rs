//! Whatever bytes come: nothing moves that the rules do not allow, and no cycle is late.

mod orders;

use std::ops::Range;

use board_link::WhenDry;
use board_link::frame::{LONGEST_FRAME, encode};
use board_link::message::{Answer, Request, ToBoard};
use board_link::segment::{AxisSegment, Begin, Segment, Shape};
use firmware_tests::Rig;
use firmware_tests::host::{BIT_RATE, Host};
use orders::{Judge, board, counts_told, forth_and_back, targets};
use trajectory::Time;

/// Bytes of a millisecond at the rate of the line.
const BYTES_PER_MS: usize = BIT_RATE as usize / 10 / 1_000;
/// The interrupt of the cycle: TIM2.
const CYCLE: u16 = 16 + 28;
const RANDOM_BYTES: usize = 1_000_000;
const HOSTILE_MESSAGES: usize = 100_000;

/// Sends bytes at the rate of the line, as many as there are.
fn flood(rig: &mut Rig, bytes: impl IntoIterator<Item = u8>) {
    let mut bytes = bytes.into_iter().peekable();
    while bytes.peek().is_some() {
        let some: Vec<u8> = bytes.by_ref().take(BYTES_PER_MS).collect();
        rig.send_serial(&some);
        rig.run_ms(1);
        // Nobody reads what the board says.
        rig.received_serial();
    }
}

/// No cycle was late, and the cycle was not longer than that of a quiet line.
struct Cost {
    quiet: u64,
    /// Resets before: the settings were put into the flash.
    resets: usize,
}

impl Cost {
    fn of_quiet_line(rig: &mut Rig) -> Self {
        rig.board_mut().clear_accounts();
        rig.run_ms(1_100);
        let quiet = rig.board().load_of(CYCLE).longest;
        rig.board_mut().clear_accounts();
        let resets = rig.board().resets().len();
        Self { quiet, resets }
    }

    fn check(&self, rig: &mut Rig) {
        let longest = rig.board().load_of(CYCLE).longest;
        println!(
            "longest cycle: {longest} instructions, {} on a quiet line",
            self.quiet
        );
        rig.run_ms(1_100);
        assert_eq!(
            (rig.statistic("late"), rig.statistic("missed")),
            (Some(0), Some(0))
        );
        assert_eq!(rig.board().resets().len(), self.resets);
        assert!(rig.board().faults().is_empty());
    }
}

fn ready() -> (Rig, Host) {
    let (mut rig, host) = board();
    rig.make_ready();
    rig.run_ms(100);
    (rig, host)
}

#[test]
fn a_million_random_bytes_move_nothing() {
    for is_enabled in [false, true] {
        let (mut rig, mut host) = ready();
        if is_enabled {
            host.bring_up(&mut rig);
            host.run_ms(&mut rig, 100);
        }
        let cost = Cost::of_quiet_line(&mut rig);
        let from_ns = rig.board().soc().now_ns();
        let mut random = fastrand::Rng::with_seed(2);
        flood(&mut rig, (0..RANDOM_BYTES / 2).map(|_| random.u8(..)));
        assert!(
            counts_told(&rig, from_ns)
                .iter()
                .flatten()
                .all(|counts| *counts == 0)
        );
        assert_eq!(rig.switches_since(from_ns).count(), 0);
        cost.check(&mut rig);
        // The host finds the board again, behind whatever was left of a frame; its session is over.
        host.run_ms(&mut rig, 1_000);
        host.connect(&mut rig);
        let answer = host.ask(&mut rig, Request::ReadCounters);
        assert!(matches!(answer, Ok(Answer::Counters(_))), "{answer:?}");
    }
}

/// Messages as a program would send them that is wrong in everything but the frame.
struct Hostile {
    random: fastrand::Rng,
    sessions: Vec<u32>,
    number: u16,
}

impl Hostile {
    fn new(seed: u64, sessions: Vec<u32>) -> Self {
        Self {
            random: fastrand::Rng::with_seed(seed),
            sessions,
            number: 0,
        }
    }

    fn frame(&mut self) -> Vec<u8> {
        self.number = self.number.wrapping_add(self.random.u16(0..3));
        let request = self.request();
        self.frame_of(request)
    }

    fn frame_of(&mut self, request: Request) -> Vec<u8> {
        let which = self.random.usize(..self.sessions.len());
        let message = ToBoard {
            number: self.number,
            session: self.sessions[which],
            request,
        };
        let mut room = [0; LONGEST_FRAME];
        let length = encode(&message, &mut room).expect("every message fits");
        room[..length].to_vec()
    }

    fn request(&mut self) -> Request {
        let number = self.extreme(0..1 << 40);
        match self.random.u8(0..24) {
            0 => Request::Hello,
            1 => Request::TimeSync {
                host_us: number as u64,
            },
            2 => Request::ReadSettings {
                offset: number as u32,
            },
            3 => Request::ReadFault {
                index: number as u32,
            },
            4 => Request::ReadCounters,
            5 => Request::Snapshots {
                period: number as u32 % 20,
            },
            6 => Request::Events {
                from: number as u32,
            },
            7 => Request::Claim,
            8 => Request::Heartbeat,
            9 => Request::Enable,
            10 => Request::Clear,
            11 => Request::Home,
            12 => Request::Pause,
            13 => Request::Resume,
            14 => Request::Override {
                percent: number as u16,
            },
            15 => Request::End {
                stream: self.random.u32(0..4),
            },
            16 => Request::Begin(self.begin()),
            17 => Request::WriteSettings {
                offset: number as u32 % 300,
                bytes: (0..self.random.usize(0..128))
                    .map(|_| self.random.u8(..))
                    .collect(),
            },
            18 => Request::CommitSettings {
                length: number as u32 % 300,
                checksum: self.random.u32(..),
            },
            _ => Request::Segment {
                stream: self.random.u32(0..4),
                index: self.random.u32(0..4),
                segment: self.segment(),
            },
        }
    }

    /// Small, large, and at the ends of what fits.
    fn extreme(&mut self, usual: Range<i64>) -> i64 {
        match self.random.u8(0..10) {
            0 => i64::MIN,
            1 => i64::MAX,
            2 => 0,
            3 => -1,
            4 => self.random.i64(..),
            _ => self.random.i64(usual),
        }
    }

    fn begin(&mut self) -> Begin {
        let axes = self.axes();
        Begin {
            stream: self.random.u32(0..4),
            start: self.random.bool().then(|| self.extreme(0..60_000) as u64),
            when_dry: if self.random.bool() {
                WhenDry::End
            } else {
                WhenDry::Wait
            },
            percent: self.random.u16(0..300),
            from: (0..axes).map(|_| self.extreme(-2..2) << 24).collect(),
        }
    }

    fn axes(&mut self) -> usize {
        if self.random.u8(0..4) > 0 {
            4
        } else {
            self.random.usize(0..=14)
        }
    }

    fn segment(&mut self) -> Segment {
        let axes = self.axes();
        Segment {
            duration: match self.random.u8(0..4) {
                0 => self.random.u64(..),
                _ => Time::from_cycles(self.random.u32(1..2_000)).ticks(),
            },
            axes: (0..axes).map(|_| self.axis_segment()).collect(),
        }
    }

    fn axis_segment(&mut self) -> AxisSegment {
        let mut value = || self.extreme(-(1_000 << 24)..1_000 << 24);
        let (end, leaving, arriving, one, other) = (value(), value(), value(), value(), value());
        AxisSegment {
            end,
            shape: match self.random.u8(0..4) {
                0 => Shape::Line,
                1 => Shape::Cubic { leaving, arriving },
                2 => Shape::Quintic {
                    leaving,
                    leaving_acceleration: one,
                    arriving,
                    arriving_acceleration: other,
                },
                _ => Shape::MinimumJerk,
            },
        }
    }
}

#[test]
fn hostile_messages_enable_nothing_while_the_enable_input_is_not_active() {
    let (mut rig, mut host) = ready();
    let cost = Cost::of_quiet_line(&mut rig);
    let mut hostile = Hostile::new(3, vec![0, 1, 2]);
    flood(
        &mut rig,
        (0..HOSTILE_MESSAGES / 4).flat_map(|_| hostile.frame()),
    );
    assert_eq!(rig.switches_since(0).count(), 0);
    assert_eq!(rig.set_points_since(0).count(), 0);
    cost.check(&mut rig);
    // The hostile session has been silent since.
    host.run_ms(&mut rig, 1_000);
    host.connect(&mut rig);
}

#[test]
fn hostile_messages_of_sessions_that_do_not_command_move_nothing() {
    let (mut rig, mut host) = ready();
    host.bring_up(&mut rig);
    let cost = Cost::of_quiet_line(&mut rig);
    // The host lives on, and its frames get through between the others.
    host.connect(&mut rig);
    let from_ns = rig.board().soc().now_ns();
    let mut hostile = Hostile::new(4, vec![0, 1, 2]);
    for _ in 0..HOSTILE_MESSAGES / 4 / 50 {
        let bytes: Vec<u8> = (0..50).flat_map(|_| hostile.frame()).collect();
        let line_ms = bytes.len().div_ceil(BYTES_PER_MS) as u64;
        rig.send_serial(&bytes);
        host.run_ms(&mut rig, line_ms + 1);
    }
    assert!(
        counts_told(&rig, from_ns)
            .iter()
            .flatten()
            .all(|counts| *counts == 0)
    );
    assert!(rig.are_enabled());
    assert_eq!(rig.switches_since(from_ns).count(), 0);
    cost.check(&mut rig);
}

#[test]
fn hostile_messages_of_the_session_that_commands_keep_the_limits() {
    let (mut rig, mut host) = ready();
    host.bring_up(&mut rig);
    let cost = Cost::of_quiet_line(&mut rig);
    host.connect(&mut rig);
    let mut hostile = Hostile::new(5, vec![host.client().session()]);
    let judge = Judge::from_now(&rig);
    let (mut sent, mut ms_moved, mut streams) = (0, 0, 100);
    while sent < HOSTILE_MESSAGES / 2 {
        if !judge.is_moving(&rig) {
            // Whatever they left: another stream, and at full speed.
            host.connect(&mut rig);
            let stand = host.look_at_machine(&mut rig);
            streams += 1;
            if !stand.player.phase.is_active() {
                host.told.clear();
                let _ = host.ask(&mut rig, Request::Enable);
                host.stream(
                    &mut rig,
                    streams,
                    forth_and_back(&targets(&host)),
                    WhenDry::End,
                );
            }
            let _ = host.client().request(Request::Resume);
            host.run_ms(&mut rig, 400);
        }
        let bytes: Vec<u8> = (0..20).flat_map(|_| hostile.frame()).collect();
        sent += 20;
        let line_ms = bytes.len().div_ceil(BYTES_PER_MS) as u64;
        rig.send_serial(&bytes);
        host.run_ms(&mut rig, line_ms + 2);
        ms_moved += if judge.is_moving(&rig) { line_ms } else { 0 };
    }
    let streams = streams - 100;
    println!("{sent} messages, {streams} streams, {ms_moved} ms of them in motion");
    assert!(ms_moved > 1_000, "they were not in the way of anything");
    judge.check_limits(&rig);
    cost.check(&mut rig);
}
