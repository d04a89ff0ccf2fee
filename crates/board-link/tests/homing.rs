//! Homing over the link: its reply comes when it ends, and segments count from what it has found.

mod bench;

use bench::{AXES, Bench, World, limits};
use board_link::board::Command;
use board_link::frame::{Decoder, decode, encode};
use board_link::host::{Incoming, RequestError};
use board_link::message::{Answer, Origin, Request, ToBoard, ToHost};
use board_link::segment::{AxisSegment, Begin, OfAxes, Segment, Shape};
use board_link::{Reason, Refused, WhenDry};
use proptest::prelude::*;

const SESSION: u32 = 7;

fn send(bench: &mut Bench, number: u16, request: Request) {
    let message = ToBoard {
        number,
        session: SESSION,
        request,
    };
    let mut bytes = [0; 512];
    let length = encode(&message, &mut bytes).unwrap();
    let now = bench.now;
    bench.link.on_bytes(&mut bench.board, now, &bytes[..length]);
}

fn pass(bench: &mut Bench) {
    bench.cycle();
    let now = bench.now;
    bench.link.poll(&mut bench.board, now);
}

/// The replies since the last call, by their numbers.
fn replies(bench: &mut Bench) -> Vec<(u16, Result<Answer, Refused>)> {
    let bytes = bench.link.output().to_vec();
    bench.link.consume(bytes.len());
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for byte in bytes {
        if let Some(content) = decoder.push(byte)
            && let Some(ToHost::Reply { number, result }) = decode(content.unwrap().body)
        {
            found.push((number, result));
        }
    }
    found
}

fn ask(bench: &mut Bench, number: u16, request: Request) -> Result<Answer, Refused> {
    send(bench, number, request);
    pass(bench);
    let found = replies(bench).into_iter().find(|reply| reply.0 == number);
    found.expect("a reply").1
}

fn reason(result: Result<Answer, Refused>) -> Reason {
    result.unwrap_err().reason().unwrap()
}

fn found(counts: [i32; AXES]) -> OfAxes<Origin> {
    let found = counts.into_iter().map(|counts| Origin::Found {
        counts,
        uncertainty: 1,
    });
    found.collect()
}

/// Enabled, with axes that are to be homed.
fn enabled() -> Bench {
    let mut bench = Bench::new();
    bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
    assert!(ask(&mut bench, 1, Request::Claim).is_ok());
    assert_eq!(ask(&mut bench, 2, Request::Enable), Ok(Answer::Done));
    bench
}

fn begin_at(stream: u32, counts: [i32; AXES]) -> Request {
    Request::Begin(Begin {
        stream,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: counts
            .map(|counts| i64::from(counts) << 24)
            .into_iter()
            .collect(),
    })
}

fn segment_to(counts: [i64; AXES]) -> Segment {
    Segment {
        duration: 5_000 << 32,
        axes: counts
            .map(|counts| AxisSegment {
                end: counts << 24,
                shape: Shape::MinimumJerk,
            })
            .into_iter()
            .collect(),
    }
}

/// Ten times as long as any other command may take, with a host that lives.
#[test]
fn the_reply_comes_when_the_homing_ends_however_long_it_takes() {
    for result in [Ok(()), Err(Reason::HomeNotFound.at(1, 500, 500))] {
        let mut bench = enabled();
        send(&mut bench, 3, Request::Home);
        for beat in 0..1_000 {
            // The host asks again, as it does for a reply that is late: it is one homing.
            send(&mut bench, 3, Request::Home);
            send(&mut bench, 100 + beat, Request::Heartbeat);
            for _ in 0..100 {
                pass(&mut bench);
            }
            assert!(replies(&mut bench).iter().all(|reply| reply.0 != 3));
        }
        let homings = bench.mock().ordered.iter();
        assert_eq!(homings.filter(|of| **of == Command::Home).count(), 1);
        bench.mock().end_homing(result);
        pass(&mut bench);
        let expected = result.map(|()| Answer::Done);
        assert_eq!(replies(&mut bench), [(3, expected)]);
        // Asked again, it is answered again and not carried out again.
        send(&mut bench, 3, Request::Home);
        assert_eq!(replies(&mut bench).len(), 1);
        pass(&mut bench);
        assert_eq!(bench.mock().homing, None);
    }
}

#[test]
fn while_it_goes_on_only_what_ends_it_is_taken() {
    let mut bench = enabled();
    send(&mut bench, 3, Request::Home);
    pass(&mut bench);
    assert_eq!(reason(ask(&mut bench, 4, Request::Home)), Reason::Busy);
    assert_eq!(reason(ask(&mut bench, 5, Request::Enable)), Reason::Busy);
    let stream = ask(&mut bench, 6, begin_at(1, [0; AXES]));
    assert_eq!(reason(stream), Reason::NotHomed);
    send(&mut bench, 7, Request::Stop);
    pass(&mut bench);
    let replies = replies(&mut bench);
    let stopped = Err(Reason::HomeStopped.at(0, 0, 0));
    assert!(replies.contains(&(3, stopped)), "{replies:?}");
    assert!(replies.contains(&(7, Ok(Answer::Done))), "{replies:?}");
}

#[test]
fn a_host_that_is_silent_or_gives_the_command_back_ends_it() {
    for is_silent in [true, false] {
        let mut bench = enabled();
        send(&mut bench, 3, Request::Home);
        if !is_silent {
            send(&mut bench, 4, Request::Release);
        }
        pass(&mut bench);
        let silence = if is_silent { 1_001 } else { 1 };
        for _ in 0..silence {
            assert!(bench.mock().homing.is_some() || !is_silent);
            pass(&mut bench);
        }
        pass(&mut bench);
        assert_eq!(bench.mock().homing, None, "{is_silent}");
        assert!(bench.mock().ordered.contains(&Command::Stop));
        let answered = replies(&mut bench);
        let stopped = Err(Reason::HomeStopped.at(0, 0, 0));
        assert!(answered.contains(&(3, stopped)), "{answered:?}");
    }
}

#[test]
fn a_stream_that_waits_or_moves_is_ended_first() {
    let mut bench = enabled();
    bench.mock().origins = found([0; AXES]);
    assert_eq!(ask(&mut bench, 3, begin_at(9, [0; AXES])), Ok(Answer::Done));
    let moving = ask(&mut bench, 4, Request::Home).unwrap_err();
    assert_eq!(moving, Reason::Moving.because(9, 0));
    // In the same moment: the player has not heard of the stream.
    let mut bench = enabled();
    bench.mock().origins = found([0; AXES]);
    send(&mut bench, 3, begin_at(9, [0; AXES]));
    send(&mut bench, 4, Request::Home);
    pass(&mut bench);
    let home = replies(&mut bench).into_iter().find(|reply| reply.0 == 4);
    assert_eq!(reason(home.unwrap().1), Reason::Moving);
}

#[test]
fn everybody_may_read_the_origins() {
    let mut bench = enabled();
    bench.mock().origins = [Origin::OfDrive, Origin::Unknown].into_iter().collect();
    let mut read = |axis| {
        let message = ToBoard {
            number: u16::from(axis) + 4,
            session: 0,
            request: Request::ReadOrigin { axis },
        };
        let mut bytes = [0; 64];
        let length = encode(&message, &mut bytes).unwrap();
        let now = bench.now;
        bench.link.on_bytes(&mut bench.board, now, &bytes[..length]);
        replies(&mut bench).remove(0).1
    };
    assert_eq!(read(0), Ok(Answer::Origin(Origin::OfDrive)));
    assert_eq!(read(1), Ok(Answer::Origin(Origin::Unknown)));
    assert_eq!(read(2), Err(Reason::NoEntry.because(2, 2)));
    assert_eq!(read(255), Err(Reason::NoEntry.because(2, 255)));
}

#[test]
fn an_axis_without_an_origin_takes_no_segment_and_the_others_wait_with_it() {
    let mut bench = enabled();
    bench.mock().origins = [Origin::OfDrive, Origin::Unknown].into_iter().collect();
    let refused = ask(&mut bench, 3, begin_at(1, [0; AXES])).unwrap_err();
    assert_eq!(refused, Reason::NotHomed.at(1, 0, 0));
    bench.mock().origins = [Origin::OfDrive; AXES].into_iter().collect();
    assert_eq!(ask(&mut bench, 4, begin_at(1, [0; AXES])), Ok(Answer::Done));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever was homed before, the ends of the travel are those from the latest origin, to the count.
    #[test]
    fn travels_move_with_their_origins(
        origins in prop::collection::vec(-(1_i32 << 27)..1 << 27, 1..4),
        is_high in any::<bool>(),
    ) {
        let mut bench = enabled();
        let mut number = 10;
        let mut ask_next = |bench: &mut Bench, request| {
            number += 1;
            ask(bench, number, request)
        };
        for (stream, &origin) in (1..).zip(&origins) {
            let ends = limits();
            let end = if is_high { ends.highest } else { ends.lowest };
            let end = i64::from(origin) + end.units() / (1 << 24);
            let beyond = if is_high { end + 1 } else { end - 1 };
            // The last one starts from where it may be, by the axis that is not looked at too.
            let stand = [origin; AXES];
            bench.mock().origins = found(stand);
            bench.mock().targets = stand;
            prop_assert_eq!(ask_next(&mut bench, begin_at(stream, stand)), Ok(Answer::Done));
            let push = |index, counts| Request::Segment {
                stream,
                index,
                segment: segment_to([i64::from(origin), counts]),
            };
            let refused = ask_next(&mut bench, push(0, beyond)).unwrap_err();
            prop_assert_eq!(refused, Reason::Travel.at(1, end << 24, beyond << 24));
            let taken = ask_next(&mut bench, push(0, end));
            prop_assert!(taken.is_ok(), "{:?}", taken);
            prop_assert_eq!(ask_next(&mut bench, Request::Halt), Ok(Answer::Done));
            pass(&mut bench);
        }
    }
}

/// The whole way, with a client: its request for a homing does not give up, and a lost connection ends it.
#[test]
fn a_client_waits_for_a_homing_as_long_as_its_connection_lives() {
    let mut world = World::new(1, 3, 0);
    world.connect_and_enable();
    world.bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
    let ticket = world.client.request(Request::Home).unwrap();
    let replied = |world: &World| {
        let told = world.told.iter();
        let mut replies = told.filter_map(|told| match told {
            Incoming::Reply { ticket: of, result } if *of == ticket => Some(result.clone()),
            _ => None,
        });
        replies.next()
    };
    for _ in 0..400_000 {
        world.step();
        assert_eq!(replied(&world), None);
    }
    world.bench.mock().origins = found([100, -100]);
    world.bench.mock().end_homing(Ok(()));
    world.until("the end", |world| replied(world).is_some());
    assert_eq!(replied(&world), Some(Ok(Answer::Done)));
    // And a board that is gone is gone.
    world.bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
    let ticket = world.client.request(Request::Home).unwrap();
    world.to_host.longest_delay = 1_000_000;
    world.until("a loss", |world| {
        let lost = Err(RequestError::Lost);
        world.told.contains(&Incoming::Reply {
            ticket,
            result: lost,
        })
    });
}

/// The reply is lost, and the host has lived on meanwhile: its homing is answered again, and nothing moves again.
#[test]
fn a_homing_whose_reply_was_lost_is_not_carried_out_again_after_other_commands() {
    let stopped = Reason::HomeStopped.at(0, 0, 0);
    for (between, result) in [
        (Request::Heartbeat, Ok(())),
        (Request::Stop, Err(stopped)),
        (Request::End { stream: 1 }, Ok(())),
    ] {
        let mut bench = enabled();
        send(&mut bench, 3, Request::Home);
        pass(&mut bench);
        bench.mock().end_homing(result);
        pass(&mut bench);
        let expected = (3, result.map(|()| Answer::Done));
        assert_eq!(replies(&mut bench), std::slice::from_ref(&expected));
        send(&mut bench, 4, between);
        pass(&mut bench);
        replies(&mut bench);
        send(&mut bench, 3, Request::Home);
        pass(&mut bench);
        assert_eq!(bench.mock().homing, None);
        assert_eq!(replies(&mut bench), [expected]);
    }
}

/// The same of drives that were enabled, and halted meanwhile.
#[test]
fn an_enable_whose_reply_was_lost_does_not_enable_again_behind_a_halt() {
    let mut bench = enabled();
    send(&mut bench, 3, Request::Enable);
    pass(&mut bench);
    pass(&mut bench);
    assert_eq!(replies(&mut bench), [(3, Ok(Answer::Done))]);
    assert_eq!(ask(&mut bench, 4, Request::Halt), Ok(Answer::Done));
    let ordered = bench.mock().ordered.len();
    send(&mut bench, 3, Request::Enable);
    pass(&mut bench);
    assert_eq!(replies(&mut bench), [(3, Ok(Answer::Done))]);
    assert_eq!(bench.mock().ordered.len(), ordered);
    // Another one is another one.
    assert_eq!(ask(&mut bench, 5, Request::Enable), Ok(Answer::Done));
    assert_eq!(bench.mock().ordered.last(), Some(&Command::Enable));
}

/// Nor one that was refused: what forbade it may be gone.
#[test]
fn an_enable_that_was_refused_is_refused_again_behind_other_commands() {
    let mut bench = enabled();
    bench.mock().stop_open = true;
    send(&mut bench, 3, Request::Enable);
    pass(&mut bench);
    pass(&mut bench);
    let refused = replies(&mut bench);
    assert!(matches!(refused[..], [(3, Err(_))]), "{refused:?}");
    bench.mock().stop_open = false;
    assert_eq!(ask(&mut bench, 4, Request::Stop), Ok(Answer::Done));
    let ordered = bench.mock().ordered.len();
    send(&mut bench, 3, Request::Enable);
    pass(&mut bench);
    pass(&mut bench);
    assert_eq!(replies(&mut bench), refused);
    assert_eq!(bench.mock().ordered.len(), ordered);
}

/// The cycle has not taken the homing yet, so a stream may begin: a stop is one of both.
#[test]
fn a_stop_ends_a_homing_behind_which_a_stream_was_begun() {
    for end in [Request::Stop, Request::Release] {
        let mut bench = enabled();
        // As the homing before has found them.
        bench.mock().origins = found([0; AXES]);
        send(&mut bench, 3, Request::Home);
        send(&mut bench, 4, begin_at(9, [0; AXES]));
        send(&mut bench, 5, end);
        bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
        for _ in 0..5 {
            pass(&mut bench);
        }
        let replies = replies(&mut bench);
        assert_eq!(bench.mock().homing, None, "{replies:?}");
    }
}

/// The request for a homing is lost, and a stop is not: nothing moves after it.
#[test]
fn a_homing_that_was_lost_does_not_begin_behind_a_stop() {
    for stop in [Request::Stop, Request::Halt] {
        let mut world = World::new(1, 3, 0);
        world.connect_and_enable();
        world.bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
        let ticket = world.client.request(Request::Home).unwrap();
        let now_us = world.now_us();
        world.client.poll(now_us);
        let lost = world.client.output().len();
        assert!(lost > 0);
        world.client.consume(lost);
        assert_eq!(world.request(stop), Ok(Answer::Done));
        let given_up = Incoming::Reply {
            ticket,
            result: Err(RequestError::TimedOut { tries: 1 }),
        };
        world.until("an end", |world| world.told.contains(&given_up));
        assert!(!world.bench.mock().ordered.contains(&Command::Home));
    }
}

#[test]
fn an_enable_that_was_lost_does_not_enable_behind_a_halt() {
    for stop in [Request::Stop, Request::Halt] {
        let mut world = World::new(1, 3, 0);
        world.connect_and_enable();
        let ordered = |world: &mut World| {
            let all = &world.bench.mock().ordered;
            all.iter().filter(|one| **one == Command::Enable).count()
        };
        let before = ordered(&mut world);
        let ticket = world.client.request(Request::Enable).unwrap();
        let now_us = world.now_us();
        world.client.poll(now_us);
        let lost = world.client.output().len();
        world.client.consume(lost);
        assert_eq!(world.request(stop), Ok(Answer::Done));
        let given_up = Incoming::Reply {
            ticket,
            result: Err(RequestError::TimedOut { tries: 1 }),
        };
        world.until("an end", |world| world.told.contains(&given_up));
        assert_eq!(ordered(&mut world), before);
    }
}

/// Whatever is under way, and has been stopped: drives that are on their way are switched off at once.
#[test]
fn a_disable_waits_for_nothing() {
    for stop in [None, Some(Request::Stop), Some(Request::Halt)] {
        let mut world = World::new(1, 3, 0);
        world.connect_and_enable();
        let ticket = world.client.request(Request::Enable).unwrap();
        if let Some(stop) = stop {
            assert_eq!(world.request(stop), Ok(Answer::Done));
        }
        assert_eq!(world.request(Request::Disable), Ok(Answer::Done));
        let is_it =
            |one: &&Incoming| matches!(one, Incoming::Reply { ticket: of, .. } if *of == ticket);
        assert_eq!(world.told.iter().filter(is_it).count(), 1);
        assert_eq!(world.bench.mock().ordered.last(), Some(&Command::Disable));
    }
}

/// The reply to a homing that was stopped comes when the axis has slowed down.
#[test]
fn a_homing_that_was_stopped_has_its_reply() {
    let mut world = World::new(1, 3, 0);
    world.connect_and_enable();
    world.bench.mock().origins = [Origin::Unknown; AXES].into_iter().collect();
    let ticket = world.client.request(Request::Home).unwrap();
    world.until("a homing", |world| world.bench.mock().homing.is_some());
    assert_eq!(world.request(Request::Stop), Ok(Answer::Done));
    let stopped = Incoming::Reply {
        ticket,
        result: Err(RequestError::Refused(Reason::HomeStopped.at(0, 0, 0))),
    };
    world.until("an end", |world| world.told.contains(&stopped));
}
