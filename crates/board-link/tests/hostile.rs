//! Framed messages with any fields, in any order, at any time: nothing moves that the rules do not allow, and each is answered with a
//! number.

mod bench;

use bench::{AXES, Bench, OUT, begin, segments};
use board_link::WhenDry;
use board_link::board::Command;
use board_link::frame::{Decoder, decode, encode};
use board_link::message::{Answer, BoardState, Chunk, Request, ToBoard, ToHost};
use board_link::segment::{AxisSegment, Begin, OfAxes, Segment, Shape};

/// What a hostile host makes up.
struct Hostile {
    random: fastrand::Rng,
    sessions: [u32; 3],
}

impl Hostile {
    /// Often small, sometimes anything.
    fn number(&mut self) -> u64 {
        match self.random.u8(0..4) {
            0 => self.random.u64(..),
            1 => self.random.u64(..) >> self.random.u32(0..64),
            _ => self.random.u64(0..4),
        }
    }

    fn signed(&mut self) -> i64 {
        self.number()
            .cast_signed()
            .wrapping_sub(self.random.i64(0..2))
    }

    fn shape(&mut self) -> Shape {
        match self.random.u8(0..4) {
            0 => Shape::Line,
            1 => Shape::MinimumJerk,
            2 => Shape::Cubic {
                leaving: self.signed(),
                arriving: self.signed(),
            },
            _ => Shape::Quintic {
                leaving: self.signed(),
                leaving_acceleration: self.signed(),
                arriving: self.signed(),
                arriving_acceleration: self.signed(),
            },
        }
    }

    fn segment(&mut self, bench: &mut Bench) -> Segment {
        if self.random.bool() {
            // One that would be right, if all else were.
            return segments(40, bench.mock().targets, 300)[0].clone();
        }
        let mut axes = OfAxes::new();
        for _ in 0..self.random.usize(0..4) {
            let part = AxisSegment {
                end: self.signed(),
                shape: self.shape(),
            };
            axes.push(part).unwrap();
        }
        Segment {
            duration: self.number() << self.random.u32(0..34),
            axes,
        }
    }

    fn begin(&mut self, bench: &mut Bench) -> Begin {
        let mut begin = begin(self.number() as u32, bench.mock().targets, WhenDry::Wait);
        if self.random.bool() {
            begin.start = Some(bench.now.wrapping_add(self.number()));
        }
        if self.random.u8(0..8) == 0 {
            begin.percent = self.number() as u16;
        }
        if self.random.u8(0..8) == 0 {
            begin.from = (0..self.random.usize(0..5))
                .map(|_| self.signed())
                .collect();
        }
        begin
    }

    fn request(&mut self, bench: &mut Bench) -> Request {
        let mut word = || self.number() as u32;
        match word() % 25 {
            0 => Request::Hello,
            1 => Request::TimeSync {
                host_us: self.number(),
            },
            2 => Request::ReadSettings { offset: word() },
            3 => Request::ReadFault { index: word() },
            4 => Request::ReadCounters,
            5 => Request::Snapshots { period: word() },
            6 => Request::Events { from: word() },
            7 if word() == 3 => Request::Stop,
            8 if word() == 3 => Request::Halt,
            9 => Request::Claim,
            10 if word() == 3 => Request::Release,
            11 => Request::Heartbeat,
            12 => Request::Enable,
            13 if word() == 3 => Request::Disable,
            7 | 8 | 10 | 13 => Request::Enable,
            14 => Request::Clear,
            15 => Request::Home,
            16 => Request::Begin(self.begin(bench)),
            17 => Request::End { stream: word() },
            18 => Request::Pause,
            19 => Request::Resume,
            20 => Request::Override {
                percent: word() as u16,
            },
            21 => Request::WriteSettings {
                offset: word(),
                bytes: (0..self.random.usize(0..129))
                    .map(|place| place as u8)
                    .collect::<Chunk>(),
            },
            24 => Request::ReadOrigin { axis: word() as u8 },
            22 => Request::CheckSettings {
                length: word(),
                checksum: word(),
            },
            _ => Request::CommitSettings {
                length: word(),
                checksum: word(),
            },
        }
    }

    fn message(&mut self, number: u16, bench: &mut Bench) -> ToBoard {
        // Mostly the one that commands, so that what follows is reached.
        let session = match (self.random.u8(0..10), bench.board.session()) {
            (0, _) => self.number() as u32,
            (1, _) | (_, None) => self.sessions[self.random.usize(0..3)],
            (_, Some(session)) => session,
        };
        let request = if self.random.u8(0..3) == 0 {
            let stream = bench.board.snapshot(0).stream;
            let next = bench.board.snapshot(0).next_segment;
            let is_right = self.random.u8(0..3) > 0;
            Request::Segment {
                stream: if is_right {
                    stream
                } else {
                    self.number() as u32
                },
                index: if is_right { next } else { self.number() as u32 },
                segment: self.segment(bench),
            }
        } else {
            self.request(bench)
        };
        ToBoard {
            number,
            session,
            request,
        }
    }
}

/// The rules, kept apart from the code under test: who commands, and whether something may move.
#[derive(Debug, Default)]
struct Rules {
    owner: Option<u32>,
    latest: u64,
    began: bool,
}

fn replies(bench: &mut Bench, decoder: &mut Decoder) -> Vec<ToHost> {
    let bytes = bench.link.output().to_vec();
    bench.link.consume(bytes.len());
    let mut found = Vec::new();
    for byte in bytes {
        if let Some(result) = decoder.push(byte) {
            found.push(decode(result.unwrap().body).unwrap());
        }
    }
    found
}

fn frame(message: &ToBoard) -> Vec<u8> {
    let mut bytes = [0; OUT];
    let length = encode(message, &mut bytes).unwrap();
    bytes[..length].to_vec()
}

#[test]
fn a_hundred_thousand_hostile_messages_move_nothing_that_the_rules_do_not_allow() {
    let mut bench = Bench::new();
    let mut hostile = Hostile {
        random: fastrand::Rng::with_seed(18),
        sessions: [5, 6, 0],
    };
    let mut decoder = Decoder::new();
    let mut rules = Rules::default();
    let (mut answered, mut refused) = (0, std::collections::BTreeMap::new());
    let mut open = std::collections::BTreeMap::new();
    for turn in 0..100_000_u32 {
        // 0 is for replies to what cannot be read.
        let number = (turn % 65_000) as u16 + 1;
        let message = hostile.message(number, &mut bench);
        let mut bytes = frame(&message);
        if hostile.random.u8(0..16) == 0 {
            // It comes twice.
            bytes.extend(frame(&message));
        }
        if hostile.random.u16(0..2_000) == 0 {
            bench.mock().stop_open = true;
        }
        let moved = bench.moved;
        let now = bench.now;
        if now - rules.latest > 1_000 {
            // It was silent for too long.
            rules.owner = None;
        }
        if rules.owner == Some(message.session) {
            rules.latest = now;
        }
        open.insert(number, (now, message.clone()));
        bench.link.on_bytes(&mut bench.board, now, &bytes);
        for _ in 0..hostile.random.u32(1..12) {
            bench.cycle();
            let now = bench.now;
            bench.link.poll(&mut bench.board, now);
            for reply in replies(&mut bench, &mut decoder) {
                let ToHost::Reply { number, result } = reply else {
                    continue;
                };
                let Some((sent, message)) = open.remove(&number) else {
                    continue;
                };
                answered += 1;
                match result {
                    Ok(Answer::Claimed { .. }) => {
                        assert!(
                            rules.owner.is_none_or(|owner| owner == message.session),
                            "turn {turn}: {message:?} at {sent}, {rules:?}"
                        );
                        rules.owner = Some(message.session);
                        rules.latest = sent;
                    }
                    Ok(_) if matches!(message.request, Request::Begin(_)) => {
                        assert_eq!(rules.owner, Some(message.session));
                        rules.began = true;
                    }
                    Ok(_) if message.request == Request::Release => rules.owner = None,
                    Ok(_) if message.request.is_reading() || message.request.is_stopping() => {}
                    Ok(_) => assert_eq!(rules.owner, Some(message.session), "{message:?}"),
                    Err(error) => {
                        assert!(error.reason().is_some(), "{error:?}");
                        *refused.entry(error.number).or_insert(0) += 1;
                        continue;
                    }
                }
            }
        }
        if bench.moved > moved {
            assert!(rules.began, "{message:?}");
            assert_eq!(bench.mock().state, BoardState::Enabled);
        }
        if bench.mock().stop_open && hostile.random.u8(0..4) == 0 {
            bench.mock().stop_open = false;
            bench.mock().state = BoardState::Off;
        }
    }
    bench.check_limits();
    for _ in 0..20 {
        bench.cycle();
        let now = bench.now;
        bench.link.poll(&mut bench.board, now);
        for reply in replies(&mut bench, &mut decoder) {
            if let ToHost::Reply { number, .. } = reply {
                answered += usize::from(open.remove(&number).is_some());
            }
        }
    }
    assert_eq!(
        (answered, open.len()),
        (100_000, 0),
        "{:?}",
        open.values().next()
    );
    // It was about something: nearly every kind of refusal, and motion.
    assert!(refused.len() >= 22, "{refused:?}");
    assert!(bench.moved > 300, "{}", bench.moved);
    assert!(bench.mock().ordered.contains(&Command::Enable));
    assert!(bench.board.snapshot(0).axes.len() == AXES);
}

#[test]
fn a_body_that_is_no_message_is_answered_with_its_number() {
    let mut bench = Bench::new();
    let mut random = fastrand::Rng::with_seed(1);
    let mut decoder = Decoder::new();
    let (mut unreadable, mut sent) = (0, 0);
    for _ in 0..5_000 {
        let length = random.usize(1..60);
        let body: Vec<u8> = (0..length)
            .map(|_| random.u8(..) >> random.u32(0..8))
            .collect();
        let mut bytes = [0; OUT];
        // A tuple of bytes is its bytes.
        let mut raw = vec![1];
        raw.extend(&body);
        raw.extend(board_link::frame::checksum(&raw).to_le_bytes());
        let length = cobs_of(&raw, &mut bytes);
        sent += 1;
        let now = bench.now;
        bench.link.on_bytes(&mut bench.board, now, &bytes[..length]);
        bench.cycle();
        bench.link.poll(&mut bench.board, now);
        for reply in replies(&mut bench, &mut decoder) {
            if let ToHost::Reply {
                result: Err(error), ..
            } = reply
            {
                unreadable += usize::from(error.number == 37);
            }
        }
    }
    assert!(unreadable > 4_000 && unreadable <= sent, "{unreadable}");
    assert_eq!(bench.moved, 0);
}

/// Byte stuffing written for the test: each zero is replaced by the distance to the next one.
fn cobs_of(raw: &[u8], out: &mut [u8]) -> usize {
    let mut length = 0;
    for group in raw.split(|&byte| byte == 0) {
        assert!(group.len() < 254);
        out[length] = group.len() as u8 + 1;
        out[length + 1..=length + group.len()].copy_from_slice(group);
        length += group.len() + 1;
    }
    out[length] = 0;
    length + 1
}
