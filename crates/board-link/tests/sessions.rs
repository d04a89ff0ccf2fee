//! Who commands, what the inputs forbid, settings, versions, half messages and floods.

mod bench;

use bench::{AXES, Bench, OUT, World, begin, segments};
use board_link::board::{Command, Link};
use board_link::frame::{Decoder, checksum, decode, encode};
use board_link::host::{Incoming, RequestError, StreamEnd};
use board_link::message::{Answer, BoardState, Request, ToBoard, ToHost};
use board_link::segment::StreamPhase;
use board_link::{Reason, Refused, WhenDry};

/// A message in, the first reply out.
fn ask(
    bench: &mut Bench,
    link: usize,
    links: &mut [Link<OUT>],
    message: &ToBoard,
) -> Result<Answer, Refused> {
    let mut bytes = [0; OUT];
    let length = encode(message, &mut bytes).unwrap();
    let (now, link) = (bench.now, &mut links[link]);
    link.on_bytes(&mut bench.board, now, &bytes[..length]);
    bench.cycle();
    link.poll(&mut bench.board, bench.now);
    replies(link).into_iter().next().unwrap()
}

fn replies(link: &mut Link<OUT>) -> Vec<Result<Answer, Refused>> {
    let bytes = link.output().to_vec();
    link.consume(bytes.len());
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for byte in bytes {
        if let Some(content) = decoder.push(byte)
            && let Some(ToHost::Reply { result, .. }) = decode(content.unwrap().body)
        {
            found.push(result);
        }
    }
    found
}

fn message(number: u16, session: u32, request: Request) -> ToBoard {
    ToBoard {
        number,
        session,
        request,
    }
}

fn reason(result: Result<Answer, Refused>) -> Reason {
    result.unwrap_err().reason().unwrap()
}

#[test]
fn of_two_hosts_one_commands_and_both_read_and_stop() {
    let mut bench = Bench::new();
    let mut links = [Link::new(), Link::new()];
    let mut ask = |link, number, session, request| {
        ask(
            &mut bench,
            link,
            &mut links,
            &message(number, session, request),
        )
    };
    assert_eq!(reason(ask(0, 1, 0, Request::Claim)), Reason::NoSession);
    assert_eq!(reason(ask(0, 2, 11, Request::Enable)), Reason::NoSession);
    assert!(matches!(
        ask(0, 3, 11, Request::Claim),
        Ok(Answer::Claimed { silence: 1_000, .. })
    ));
    let taken = ask(1, 3, 12, Request::Claim).unwrap_err();
    assert_eq!((taken.number, taken.expected, taken.actual), (22, 11, 12));
    assert_eq!(reason(ask(1, 4, 12, Request::Enable)), Reason::Taken);
    assert_eq!(reason(ask(1, 5, 12, Request::Heartbeat)), Reason::Taken);
    assert!(matches!(ask(1, 6, 12, Request::Hello), Ok(Answer::Info(_))));
    assert!(matches!(
        ask(1, 7, 12, Request::ReadSettings { offset: 0 }),
        Ok(Answer::Settings { length: 14, .. })
    ));
    assert_eq!(ask(1, 8, 0, Request::Stop), Ok(Answer::Done));
    assert_eq!(ask(1, 9, 0, Request::Halt), Ok(Answer::Done));
    assert_eq!(ask(0, 4, 11, Request::Enable), Ok(Answer::Done));
    assert_eq!(ask(0, 5, 11, Request::Release), Ok(Answer::Done));
    assert!(matches!(
        ask(1, 10, 12, Request::Claim),
        Ok(Answer::Claimed { .. })
    ));
    assert_eq!(reason(ask(0, 6, 11, Request::Disable)), Reason::Taken);
    assert_eq!(
        bench.mock().ordered,
        [Command::Stop, Command::Halt, Command::Enable]
    );
}

#[test]
fn an_enable_is_not_repeated_behind_a_disable_and_its_number_counts_again_much_later() {
    let mut bench = Bench::new();
    let mut links = [Link::new()];
    let mut ask = |number, request| ask(&mut bench, 0, &mut links, &message(number, 11, request));
    assert!(ask(1, Request::Claim).is_ok());
    assert_eq!(ask(2, Request::Enable), Ok(Answer::Done));
    assert_eq!(ask(3, Request::Disable), Ok(Answer::Done));
    // What was on its way for long.
    assert_eq!(ask(2, Request::Enable), Ok(Answer::Done));
    for number in (4..=u16::MAX).chain([0, 1]) {
        assert!(ask(number, Request::Heartbeat).is_ok());
    }
    assert_eq!(ask(2, Request::Enable), Ok(Answer::Done));
    let orders = [Command::Enable, Command::Disable, Command::Enable];
    assert_eq!(bench.mock().ordered, orders);
}

#[test]
fn snapshots_that_nobody_takes_leave_room_for_an_answer() {
    let mut bench = Bench::new();
    let mut link = Link::<OUT>::new();
    let mut say = |link: &mut Link<OUT>, number, request| {
        let mut bytes = [0; OUT];
        let length = encode(&message(number, 0, request), &mut bytes).unwrap();
        link.on_bytes(&mut bench.board, bench.now, &bytes[..length]);
        for _ in 0..200 {
            bench.cycle();
            link.poll(&mut bench.board, bench.now);
        }
    };
    say(&mut link, 1, Request::Snapshots { period: 1 });
    let before = link.output().len();
    say(&mut link, 2, Request::Hello);
    assert!(link.output().len() > before, "Hello was not answered");
    assert_eq!(replies(&mut link).len(), 2);
}

#[test]
fn the_drives_can_be_switched_off_while_they_are_on_their_way() {
    let mut bench = Bench::new();
    let mut links = [Link::new()];
    let claim = message(1, 11, Request::Claim);
    ask(&mut bench, 0, &mut links, &claim).unwrap();
    bench.mock().is_stuck = true;
    for (number, request) in [(2, Request::Enable), (3, Request::Disable)] {
        let mut bytes = [0; OUT];
        let length = encode(&message(number, 11, request), &mut bytes).unwrap();
        links[0].on_bytes(&mut bench.board, bench.now, &bytes[..length]);
        links[0].poll(&mut bench.board, bench.now);
    }
    assert_eq!(replies(&mut links[0]), [], "neither is refused");
    // Nothing else may be commanded meanwhile.
    let clear = message(4, 11, Request::Clear);
    assert_eq!(reason(ask(&mut bench, 0, &mut links, &clear)), Reason::Busy);
    bench.mock().is_stuck = false;
    for _ in 0..4 {
        bench.cycle();
        links[0].poll(&mut bench.board, bench.now);
    }
    assert_eq!(bench.mock().ordered, [Command::Enable, Command::Disable]);
    let answers = replies(&mut links[0]);
    assert_eq!(answers, [Ok(Answer::Done), Ok(Answer::Done)]);
}

#[test]
fn a_request_that_comes_again_is_answered_again_and_not_carried_out_again() {
    let mut bench = Bench::new();
    let mut links = [Link::new()];
    let mut ask = |number, session, request| {
        ask(
            &mut bench,
            0,
            &mut links,
            &message(number, session, request),
        )
    };
    ask(1, 11, Request::Claim).unwrap();
    for _ in 0..3 {
        assert_eq!(ask(2, 11, Request::Enable), Ok(Answer::Done));
    }
    // The same number with something else is another request.
    assert_eq!(ask(2, 11, Request::Disable), Ok(Answer::Done));
    let Ok(Answer::Counters(counters)) = ask(3, 0, Request::ReadCounters) else {
        panic!()
    };
    assert_eq!(counters.repeated, 2);
    assert_eq!(bench.mock().ordered, [Command::Enable, Command::Disable]);
}

#[test]
fn after_a_silence_an_old_request_is_not_answered_as_if_it_still_counted() {
    let mut bench = Bench::new();
    let mut links = [Link::new()];
    ask(&mut bench, 0, &mut links, &message(1, 11, Request::Claim)).unwrap();
    ask(&mut bench, 0, &mut links, &message(2, 11, Request::Enable)).unwrap();
    for _ in 0..1_100 {
        bench.cycle();
        links[0].poll(&mut bench.board, bench.now);
    }
    replies(&mut links[0]);
    let again = ask(&mut bench, 0, &mut links, &message(2, 11, Request::Enable));
    assert_eq!(reason(again), Reason::NoSession);
    assert_eq!(bench.mock().ordered, [Command::Enable, Command::Stop]);
}

#[test]
fn a_stop_for_a_silent_host_waits_for_room_in_the_application() {
    let mut bench = Bench::new();
    let mut links = [Link::new()];
    ask(&mut bench, 0, &mut links, &message(1, 11, Request::Claim)).unwrap();
    bench.mock().is_stuck = true;
    for number in 2..6 {
        let mut bytes = [0; OUT];
        let length = encode(&message(number, 11, Request::Halt), &mut bytes).unwrap();
        links[0].on_bytes(&mut bench.board, bench.now, &bytes[..length]);
    }
    for _ in 0..1_100 {
        bench.cycle();
        links[0].poll(&mut bench.board, bench.now);
    }
    assert_eq!(bench.board.session(), None);
    assert!(bench.mock().ordered.is_empty());
    bench.mock().is_stuck = false;
    for _ in 0..3 {
        bench.cycle();
        links[0].poll(&mut bench.board, bench.now);
    }
    let halts = [Command::Halt; 4];
    assert_eq!(bench.mock().ordered[..4], halts);
    assert_eq!(bench.mock().ordered[4..], [Command::Stop]);
}

#[test]
fn a_stream_that_a_fault_refuses_is_told_the_axis_and_the_number_of_the_fault() {
    let mut world = World::new(1, 0, 0);
    world.until("a connection", |world| world.client.is_connected());
    world.bench.mock().state = BoardState::Faulted;
    let start = Request::Begin(begin(1, [0; AXES], WhenDry::End));
    for (faults, expected) in [
        ([0, 105], Reason::Faulted.at(1, 0, 105)),
        // A fault of the board is no fault of an axis.
        (
            [0, 0],
            Reason::Faulted.because(BoardState::Enabled as i64, BoardState::Faulted as i64),
        ),
    ] {
        world.bench.mock().faults = faults;
        let answer = world.request(start.clone());
        assert_eq!(answer, Err(RequestError::Refused(expected)));
    }
}

#[test]
fn the_inputs_rule_over_the_link() {
    let mut world = World::new(1, 0, 0);
    world.until("a connection", |world| world.client.is_connected());
    let refused = |result: Result<Answer, RequestError>| match result {
        Err(RequestError::Refused(refused)) => refused.reason(),
        other => panic!("{other:?}"),
    };
    world.bench.mock().stop_open = true;
    assert_eq!(
        refused(world.request(Request::Enable)),
        Some(Reason::StopInput)
    );
    let start = begin(1, [0; AXES], WhenDry::End);
    assert_eq!(
        refused(world.request(Request::Begin(start.clone()))),
        Some(Reason::StopInput)
    );
    world.bench.mock().stop_open = false;
    world.bench.mock().state = BoardState::Off;
    assert_eq!(
        refused(world.request(Request::Begin(start))),
        Some(Reason::NotEnabled)
    );
    world.request(Request::Enable).unwrap();
    world.begin_here(2, WhenDry::Wait);
    let mut source = segments(200, [0, 0], 15_000).into_iter();
    world.until("motion", |world| {
        world.client.feed(&mut source);
        world.bench.moved > 700
    });
    world.bench.mock().stop_open = true;
    let targets = world.bench.mock().targets;
    world.until("a refusal of the stream", |world| {
        world.client.feed(&mut source);
        world
            .told
            .iter()
            .any(|told| matches!(told, Incoming::Stream(StreamEnd::Refused { .. })))
    });
    assert_eq!(world.bench.player.phase(), StreamPhase::Stopped);
    assert!((world.bench.mock().targets[0] - targets[0]).abs() <= 1);
}

#[test]
fn settings_go_round_in_pieces_and_are_stored_only_when_they_are_right() {
    let mut world = World::new(2, 3, 3_000);
    world.until("a connection", |world| world.client.is_connected());
    let new: Vec<u8> = (0..280).map(|place| (place % 230) as u8).collect();
    let write = |world: &mut World, bytes: &[u8]| {
        for (place, piece) in bytes.chunks(100).enumerate() {
            let offset = 100 * place as u32;
            let bytes = piece.iter().copied().collect();
            let staged = world.request(Request::WriteSettings { offset, bytes });
            assert_eq!(
                staged,
                Ok(Answer::Staged {
                    received: offset + piece.len() as u32
                })
            );
        }
    };
    let refused = |result: Result<Answer, RequestError>| match result {
        Err(RequestError::Refused(refused)) => refused.reason().unwrap(),
        other => panic!("{other:?}"),
    };
    write(&mut world, &new);
    let (length, right) = (280, checksum(&new));
    assert_eq!(
        refused(world.request(Request::CheckSettings {
            length: 279,
            checksum: right
        })),
        Reason::Length
    );
    assert_eq!(
        refused(world.request(Request::CommitSettings {
            length,
            checksum: right + 1
        })),
        Reason::Checksum
    );
    let gap = Request::WriteSettings {
        offset: 290,
        bytes: [1].into_iter().collect(),
    };
    assert_eq!(refused(world.request(gap)), Reason::Chunk);
    let long = Request::WriteSettings {
        offset: 280,
        bytes: [1; 100].into_iter().collect(),
    };
    assert_eq!(refused(world.request(long)), Reason::Length);
    world.request(Request::Enable).unwrap();
    assert_eq!(
        refused(world.request(Request::CommitSettings {
            length,
            checksum: right
        })),
        Reason::Enabled
    );
    world.request(Request::Disable).unwrap();
    assert_eq!(world.bench.mock().stored, b"first settings");
    assert_eq!(
        world.request(Request::CheckSettings {
            length,
            checksum: right
        }),
        Ok(Answer::Done)
    );
    assert_eq!(
        world.request(Request::CommitSettings {
            length,
            checksum: right
        }),
        Ok(Answer::Done)
    );
    let mut read = Vec::new();
    while read.len() < 280 {
        let offset = read.len() as u32;
        let Ok(Answer::Settings {
            length: 280,
            checksum,
            bytes,
            ..
        }) = world.request(Request::ReadSettings { offset })
        else {
            panic!()
        };
        assert_eq!(checksum, right);
        read.extend_from_slice(&bytes);
    }
    assert_eq!(read, new);
    // What the application does not take.
    write(&mut world, &[0xEE; 10]);
    let bad = Request::CommitSettings {
        length: 10,
        checksum: checksum(&[0xEE; 10]),
    };
    assert_eq!(refused(world.request(bad)), Reason::Settings);
    let Ok(Answer::Fault(entry)) = world.request(Request::ReadFault { index: 1 }) else {
        panic!()
    };
    assert_eq!(entry.number, 39);
    assert_eq!(
        refused(world.request(Request::ReadFault { index: 2 })),
        Reason::NoEntry
    );
}

#[test]
fn another_version_is_answered_with_both_versions() {
    let mut bench = Bench::new();
    let mut raw = vec![2, 1, 0, 0];
    raw.extend(checksum(&raw).to_le_bytes());
    let mut bytes = [0; 64];
    let length = cobs::try_encode(&raw, &mut bytes).unwrap();
    bench.link.on_bytes(&mut bench.board, 0, &bytes[..=length]);
    let expected = Reason::Version.because(1, 2);
    assert_eq!(replies(&mut bench.link), [Err(expected)]);
    assert!(
        expected.to_string().contains("expected 1, got 2"),
        "{expected}"
    );
}

#[test]
fn half_messages_are_counted_and_what_follows_is_taken() {
    let mut bench = Bench::new();
    let mut bytes = [0; OUT];
    let whole = encode(&message(1, 0, Request::ReadCounters), &mut bytes).unwrap();
    for half in 1..whole - 1 {
        bench.link.on_bytes(&mut bench.board, 0, &bytes[..half]);
        bench.link.on_bytes(&mut bench.board, 0, &[0]);
    }
    assert_eq!(replies(&mut bench.link).len(), 0);
    bench.link.on_bytes(&mut bench.board, 0, &bytes[..whole]);
    let found = replies(&mut bench.link);
    let [Ok(Answer::Counters(counters))] = found.as_slice() else {
        panic!("{found:?}")
    };
    let losses = counters.losses;
    assert_eq!(
        losses.stuffing + losses.checksum + losses.length,
        whole as u32 - 2
    );
    assert_eq!(counters.frames, 1);
}

#[test]
fn a_flood_that_nobody_drains_is_counted_and_a_stop_in_it_counts() {
    let mut bench = Bench::new();
    let mut bytes = [0; OUT];
    let length = encode(&message(1, 0, Request::Hello), &mut bytes).unwrap();
    for _ in 0..1_000 {
        bench.link.on_bytes(&mut bench.board, 0, &bytes[..length]);
    }
    let length = encode(&message(2, 0, Request::Halt), &mut bytes).unwrap();
    bench.link.on_bytes(&mut bench.board, 0, &bytes[..length]);
    bench.cycle();
    assert_eq!(bench.mock().ordered, [Command::Halt]);
    let answered = replies(&mut bench.link).len();
    let length = encode(&message(3, 0, Request::ReadCounters), &mut bytes).unwrap();
    bench.link.on_bytes(&mut bench.board, 0, &bytes[..length]);
    let found = replies(&mut bench.link);
    let [Ok(Answer::Counters(counters))] = found.as_slice() else {
        panic!("{found:?}")
    };
    assert!(answered > 10);
    assert_eq!(counters.unanswered as usize + answered, 1_001);
}

#[test]
fn an_application_that_does_not_answer_is_reported() {
    let mut world = World::new(4, 0, 0);
    world.until("a connection", |world| world.client.is_connected());
    world.bench.mock().is_stuck = true;
    let ticket = world.client.request(Request::Enable).unwrap();
    world.until("the end of patience", |world| {
        world
            .told
            .iter()
            .any(|told| matches!(told, Incoming::Reply { ticket: of, .. } if *of == ticket))
    });
    // The host gives up first; another command waits for the board's patience.
    let busy = world.request(Request::Clear);
    assert_eq!(busy, Err(RequestError::Refused(Reason::Busy.because(0, 1))));
    for _ in 0..10_500 {
        world.step();
    }
    world.bench.mock().is_stuck = false;
    assert_eq!(world.request(Request::Clear), Ok(Answer::Done));
}

/// What was asked for last goes out, and is lost.
fn lose(world: &mut World) {
    let now_us = world.now_us();
    world.client.poll(now_us);
    let lost = world.client.output().len();
    assert!(lost > 0);
    world.client.consume(lost);
}

/// A stream with so many segments is asked for, and nothing of it has gone out.
fn beginning(longest_delay: u64, count: u32) -> World {
    let mut world = World::new(1, longest_delay, 0);
    world.connect_and_enable();
    world.begin_here(9, WhenDry::End);
    let mut source = segments(count, [0, 0], 500).into_iter();
    world.client.feed(&mut source);
    world
}

/// The beginning of a stream is lost, and what ends it is not: nothing moves after it.
#[test]
fn a_stream_whose_beginning_was_lost_does_not_begin_behind_a_stop() {
    for end in [Request::Stop, Request::Halt, Request::Disable] {
        let mut world = beginning(3, 20);
        lose(&mut world);
        assert_eq!(world.request(end.clone()), Ok(Answer::Done));
        world.request(Request::Enable).unwrap();
        let given_up = Incoming::Stream(StreamEnd::TimedOut);
        world.until("an end", |world| world.told.contains(&given_up));
        assert_eq!(world.bench.moved, 0, "{end:?}");
        // The next one is another one.
        world.begin_here(10, WhenDry::End);
        world
            .client
            .feed(&mut segments(15, [0, 0], 300).into_iter());
        world.client.finish();
        world.until("the motion", |world| world.bench.mock().targets[0] == 300);
    }
}

/// The same of one that has not gone out yet.
#[test]
fn a_stop_does_not_overtake_the_beginning_of_a_stream() {
    for end in [Request::Stop, Request::Halt, Request::Disable] {
        let mut world = beginning(3, 15);
        world.client.finish();
        assert_eq!(world.request(end.clone()), Ok(Answer::Done));
        for _ in 0..2_000 {
            world.step();
        }
        assert_eq!(world.bench.moved, 0, "{end:?}");
    }
}

/// The reply is lost, and the board has begun it: the stop has found it.
#[test]
fn a_stream_that_has_begun_before_a_stop_ends_with_it() {
    let mut world = beginning(0, 20);
    world.step();
    assert_eq!(world.request(Request::Stop), Ok(Answer::Done));
    let is_refused = |told: &Incoming| {
        matches!(told, Incoming::Stream(StreamEnd::Refused { refused, .. })
            if refused.reason() == Some(Reason::Ended))
    };
    world.until("an end", |world| world.told.iter().any(is_refused));
    assert_eq!(world.bench.player.phase(), StreamPhase::Stopped);
}

/// Another speed was asked for before a stop, and lost: the stream that is begun behind it keeps its own.
#[test]
fn a_speed_that_was_lost_is_not_that_of_the_stream_behind_a_stop() {
    let mut world = World::new(1, 3, 0);
    world.connect_and_enable();
    let override_of_before = Request::Override { percent: 200 };
    let ticket = world.client.request(override_of_before).unwrap();
    lose(&mut world);
    assert_eq!(world.request(Request::Stop), Ok(Answer::Done));
    world.begin_here(9, WhenDry::End);
    world
        .client
        .feed(&mut segments(16, [0, 0], 500).into_iter());
    let given_up = Incoming::Reply {
        ticket,
        result: Err(RequestError::TimedOut { tries: 1 }),
    };
    world.until("an end", |world| world.told.contains(&given_up));
}
