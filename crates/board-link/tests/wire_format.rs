//! The bytes of messages, literally: the wire format cannot change unseen. They were written by hand from the tables of the README.

use board_link::frame::{Losses, decode, encode};
use board_link::message::{
    Answer, AxisSnapshot, BoardState, Counters, Event, FaultEntry, Info, Origin, Request, Snapshot,
    ToBoard, ToHost,
};
use board_link::segment::{AxisSegment, Begin, PlayerState, Segment, Shape, StreamPhase};
use board_link::{Reason, WhenDry};

fn body<M>(message: &M, expected: &[u8])
where
    M: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug,
{
    let mut bytes = [0xA5; 800];
    let written = postcard::to_slice(message, &mut bytes).unwrap();
    assert_eq!(written, expected, "{message:?}");
    assert_eq!(decode::<M>(expected).as_ref(), Some(message));
    // A byte less or more is no message.
    assert_eq!(decode::<M>(&expected[..expected.len() - 1]), None);
    let longer: Vec<u8> = expected.iter().copied().chain([0]).collect();
    assert_eq!(decode::<M>(&longer), None);
}

fn asks(request: Request, expected: &[u8]) {
    // Number 300 and session 5.
    let message = ToBoard {
        number: 300,
        session: 5,
        request,
    };
    let whole: Vec<u8> = [0xAC, 0x02, 5]
        .into_iter()
        .chain(expected.iter().copied())
        .collect();
    body(&message, &whole);
}

fn answers(answer: Answer, expected: &[u8]) {
    let message = ToHost::Reply {
        number: 7,
        result: Ok(answer),
    };
    let whole: Vec<u8> = [0, 7, 0]
        .into_iter()
        .chain(expected.iter().copied())
        .collect();
    body(&message, &whole);
}

#[test]
fn requests() {
    asks(Request::Hello, &[0]);
    asks(
        Request::TimeSync { host_us: 1_000_000 },
        &[1, 0xC0, 0x84, 0x3D],
    );
    asks(Request::ReadSettings { offset: 128 }, &[2, 0x80, 0x01]);
    asks(Request::ReadFault { index: 3 }, &[3, 3]);
    asks(Request::ReadCounters, &[4]);
    asks(Request::Snapshots { period: 50 }, &[5, 50]);
    asks(Request::Events { from: 9 }, &[6, 9]);
    asks(Request::Stop, &[7]);
    asks(Request::Halt, &[8]);
    asks(Request::Claim, &[9]);
    asks(Request::Release, &[10]);
    asks(Request::Heartbeat, &[11]);
    asks(Request::Enable, &[12]);
    asks(Request::Disable, &[13]);
    asks(Request::Clear, &[14]);
    asks(Request::Home, &[15]);
    let begin = Begin {
        stream: 2,
        start: Some(1_000),
        when_dry: WhenDry::Wait,
        percent: 100,
        from: [1 << 24, -1].into_iter().collect(),
    };
    asks(
        Request::Begin(begin),
        // Stream, some start, wait, percent, two axes: 2^24 and -1 as zigzag varints.
        &[16, 2, 1, 0xE8, 0x07, 1, 100, 2, 0x80, 0x80, 0x80, 0x10, 1],
    );
    let part = |end, shape| AxisSegment { end, shape };
    let segment = Segment {
        duration: 20 << 32,
        axes: [
            part(64, Shape::Line),
            part(
                -64,
                Shape::Cubic {
                    leaving: 1,
                    arriving: -1,
                },
            ),
            part(
                0,
                Shape::Quintic {
                    leaving: 1,
                    leaving_acceleration: 2,
                    arriving: 3,
                    arriving_acceleration: 4,
                },
            ),
            part(1, Shape::MinimumJerk),
        ]
        .into_iter()
        .collect(),
    };
    asks(
        Request::Segment {
            stream: 2,
            index: 200,
            segment,
        },
        &[
            17, 2, 0xC8, 0x01, 0x80, 0x80, 0x80, 0x80, 0xC0, 0x02, 4, 0x80, 0x01, 0, 0x7F, 1, 2, 1,
            0, 2, 2, 4, 6, 8, 2, 3,
        ],
    );
    asks(Request::End { stream: 2 }, &[18, 2]);
    asks(Request::Pause, &[19]);
    asks(Request::Resume, &[20]);
    asks(Request::Override { percent: 200 }, &[21, 0xC8, 0x01]);
    let bytes = [7, 8].into_iter().collect();
    asks(
        Request::WriteSettings { offset: 1, bytes },
        &[22, 1, 2, 7, 8],
    );
    asks(
        Request::CheckSettings {
            length: 2,
            checksum: 0xFFFF_FFFF,
        },
        &[23, 2, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F],
    );
    asks(
        Request::CommitSettings {
            length: 2,
            checksum: 1,
        },
        &[24, 2, 1],
    );
    asks(Request::ReadOrigin { axis: 3 }, &[25, 3]);
}

#[test]
fn answers_and_refusals() {
    answers(Answer::Done, &[0]);
    let info = Info {
        board: "B".try_into().unwrap(),
        firmware: "1.2".try_into().unwrap(),
        boot: 3,
        cycle_us: 1_000,
        uptime: 300,
        axes: 2,
        segments: 32,
        settings: 4_096,
        faults: 0,
    };
    answers(
        Answer::Info(info),
        &[
            1, 1, b'B', 3, b'1', b'.', b'2', 3, 0xE8, 0x07, 0xAC, 0x02, 2, 32, 0x80, 0x20, 0,
        ],
    );
    answers(
        Answer::Time {
            host_us: 1,
            cycle: 128,
        },
        &[2, 1, 0x80, 0x01],
    );
    let bytes = [9].into_iter().collect();
    answers(
        Answer::Settings {
            length: 1,
            checksum: 2,
            offset: 0,
            bytes,
        },
        &[3, 1, 2, 0, 1, 9],
    );
    let entry = FaultEntry {
        number: 5,
        boot: 8,
        uptime_ms: 6,
        firmware: "1".try_into().unwrap(),
        axis: Some(1),
        code: 7,
        detail: -1,
        place: "x".try_into().unwrap(),
    };
    answers(
        Answer::Fault(entry),
        &[4, 5, 8, 6, 1, b'1', 1, 1, 7, 1, 1, b'x'],
    );
    let counters = Counters {
        frames: 1,
        losses: Losses {
            length: 2,
            stuffing: 3,
            checksum: 4,
            version: 5,
            body: 6,
        },
        repeated: 7,
        refused: 8,
        unanswered: 9,
        snapshots_left_out: 10,
        events_lost: 11,
        segments: 12,
        silent_hosts: 13,
        late_cycles: 14,
    };
    answers(
        Answer::Counters(counters),
        &[5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14],
    );
    answers(Answer::Events { oldest: 1, next: 2 }, &[6, 1, 2]);
    answers(
        Answer::Claimed {
            silence: 500,
            events: 2,
        },
        &[7, 0xF4, 0x03, 2],
    );
    answers(
        Answer::Alive {
            events: 1,
            next: 2,
            credit: 3,
        },
        &[8, 1, 2, 3],
    );
    answers(Answer::Taken { next: 2, credit: 3 }, &[9, 2, 3]);
    answers(Answer::Staged { received: 4 }, &[10, 4]);
    let found = Origin::Found {
        counts: -65,
        uncertainty: 2,
    };
    answers(Answer::Origin(Origin::OfDrive), &[11, 0]);
    answers(Answer::Origin(Origin::Unknown), &[11, 1]);
    answers(Answer::Origin(found), &[11, 2, 0x81, 0x01, 2]);
    let refused = |refused| ToHost::Reply {
        number: 7,
        result: Err(refused),
    };
    body(
        &refused(Reason::Order.because(3, 4)),
        &[0, 7, 1, 4, 0, 6, 8],
    );
    body(
        &refused(Reason::Travel.at(1, 64, -65)),
        &[0, 7, 1, 7, 1, 1, 0x80, 0x01, 0x81, 0x01],
    );
}

#[test]
fn events_and_snapshots() {
    let event = |event| ToHost::Event { number: 6, event };
    body(&event(Event::State(BoardState::Enabled)), &[1, 6, 0, 6]);
    let stream = Event::Stream {
        stream: 2,
        phase: StreamPhase::DriedUp,
        finished: 3,
    };
    body(&event(stream), &[1, 6, 1, 2, 5, 3]);
    body(
        &event(Event::Fault {
            axis: None,
            code: 2,
            detail: 1,
        }),
        &[1, 6, 2, 0, 2, 2],
    );
    body(&event(Event::Claimed { session: 5 }), &[1, 6, 3, 5]);
    body(&event(Event::Released { session: 5 }), &[1, 6, 4, 5]);
    body(&event(Event::SilentHost { session: 5 }), &[1, 6, 5, 5]);
    let homed = Event::Homed {
        axis: 1,
        counts: -2,
        uncertainty: 7,
    };
    body(&event(homed), &[1, 6, 6, 1, 3, 7]);
    let snapshot = Snapshot {
        cycle: 300,
        state: BoardState::Faulted,
        stream: 2,
        player: PlayerState {
            phase: StreamPhase::Moving,
            time_cycles: 20,
            finished: 1,
            percent: 100,
        },
        next_segment: 3,
        credit: 4,
        events: 5,
        axes: [AxisSnapshot {
            target: 1,
            position: -1,
            error: 2,
            fault: 9,
        }]
        .into_iter()
        .collect(),
    };
    body(
        &ToHost::Snapshot(snapshot),
        &[2, 0xAC, 0x02, 9, 2, 2, 20, 1, 100, 3, 4, 5, 1, 2, 1, 4, 9],
    );
}

/// The example of the README.
#[test]
fn an_exchange() {
    let frame = |message: &dyn Fn(&mut [u8]) -> usize| {
        let mut bytes = [0xA5; 64];
        let length = message(&mut bytes);
        bytes[..length].to_vec()
    };
    let claim = ToBoard {
        number: 1,
        session: 5,
        request: Request::Claim,
    };
    // Stuffed, with the CRC-32 of Python's zlib.
    let expected = [9, 1, 1, 5, 9, 0xAF, 0x9E, 0x91, 0x9C, 0];
    assert_eq!(frame(&|out| encode(&claim, out).unwrap()), expected);
    let result = Ok(Answer::Claimed {
        silence: 500,
        events: 1,
    });
    let claimed = ToHost::Reply { number: 1, result };
    let expected = [2, 1, 2, 1, 9, 7, 0xF4, 3, 1, 0xB2, 0x8C, 0xE4, 0x11, 0];
    assert_eq!(frame(&|out| encode(&claimed, out).unwrap()), expected);
    let end = ToBoard {
        number: 2,
        session: 5,
        request: Request::End { stream: 2 },
    };
    let expected = [10, 1, 2, 5, 18, 2, 0x32, 0xC5, 0x7A, 0xC1, 0];
    assert_eq!(frame(&|out| encode(&end, out).unwrap()), expected);
    let refused = ToHost::Reply {
        number: 2,
        result: Err(Reason::NotAtRest.at(0, 0, 3 << 23)),
    };
    let expected = [
        2, 1, 5, 2, 1, 16, 1, 1, 9, 0x80, 0x80, 0x80, 0x18, 0x47, 0xD9, 0xB1, 0x0D, 0,
    ];
    assert_eq!(frame(&|out| encode(&refused, out).unwrap()), expected);
}
