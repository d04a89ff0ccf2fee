//! Streams that do not come to their end: a host that dies, segments that run out, orders to stop.

mod orders;

use board_link::Reason;
use board_link::WhenDry;
use board_link::host::{Incoming, RequestError};
use board_link::message::{Answer, BoardState, Event, Request};
use board_link::segment::StreamPhase;
use orders::{Judge, board, forth_and_back, pick_and_place, targets};

/// Milliseconds until the axes rest, from the end of the last segment that came: what is buffered, silence, ramp.
const REST_MS: u64 = 2_500;

#[test]
fn a_host_that_dies_in_motion_leaves_axes_that_come_to_rest_on_their_path() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    let judge = Judge::from_now(&rig);
    let stand = targets(&host);
    let file = forth_and_back(&stand);
    host.stream(&mut rig, 1, file, WhenDry::End);
    host.run_ms(&mut rig, 1_500);
    assert!(judge.is_moving(&rig));
    host.is_dead = true;
    host.run_ms(&mut rig, REST_MS);
    // It has not reached the end, which comes five seconds later.
    assert!(!judge.is_moving(&rig));
    let way = judge.check_limits(&rig);
    assert!(way.iter().any(|counts| *counts != 0));
    // The drives are still enabled, and another host may go on.
    assert!(rig.are_enabled());
    host.is_dead = false;
    let is_lost = host.run_until(&mut rig, 500, |host, _| {
        host.told.contains(&Incoming::Disconnected)
    });
    assert!(is_lost, "its session is over");
    host.connect(&mut rig);
    assert_eq!(host.state(&mut rig), BoardState::Enabled);
    assert_ne!(targets(&host), stand);
    let answer = host.ask(&mut rig, Request::ReadCounters);
    assert!(
        matches!(&answer, Ok(Answer::Counters(counters)) if counters.silent_hosts == 1),
        "{answer:?}"
    );
}

#[test]
fn segments_that_run_out_end_in_a_ramp_and_the_next_one_is_late() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    let judge = Judge::from_now(&rig);
    host.stream(
        &mut rig,
        7,
        pick_and_place().segments(&targets(&host)),
        WhenDry::End,
    );
    judge.wait_for_motion(&mut rig, &mut host);
    host.stop_feeding();
    let is_over = host.run_until(&mut rig, REST_MS, |host, _| {
        host.phases(7).contains(&StreamPhase::DriedUp)
    });
    assert!(is_over, "{:?}", host.told);
    host.run_ms(&mut rig, 10);
    assert!(!judge.is_moving(&rig));
    judge.check_limits(&rig);
    assert_eq!(host.state(&mut rig), BoardState::Enabled);
}

#[test]
fn stop_is_a_ramp_on_the_path_and_halt_is_at_once() {
    for (request, phase) in [
        (Request::Stop, StreamPhase::Stopped),
        (Request::Release, StreamPhase::Stopped),
        (Request::Disable, StreamPhase::Stopped),
        (Request::Halt, StreamPhase::Stopped),
    ] {
        let (mut rig, mut host) = board();
        host.bring_up(&mut rig);
        let judge = Judge::from_now(&rig);
        host.stream(
            &mut rig,
            1,
            pick_and_place().segments(&targets(&host)),
            WhenDry::End,
        );
        judge.wait_for_motion(&mut rig, &mut host);
        let is_halt = request == Request::Halt;
        let asked_ns = rig.board().soc().now_ns();
        assert_eq!(
            host.ask(&mut rig, request.clone()),
            Ok(Answer::Done),
            "{request:?}"
        );
        if is_halt {
            host.run_ms(&mut rig, 8);
            assert!(!judge.is_moving(&rig));
            let last = rig.set_points_since(asked_ns).last();
            assert!(last.is_none_or(|record| record.start_ns < asked_ns + 6_000_000));
        } else {
            host.run_ms(&mut rig, 1_200);
            assert!(!judge.is_moving(&rig));
            judge.check_limits(&rig);
        }
        assert!(
            host.phases(1).contains(&phase),
            "{request:?} {:?}",
            host.phases(1)
        );
        host.run_ms(&mut rig, 1_000);
        assert_eq!(
            rig.are_enabled(),
            request != Request::Disable,
            "{request:?}"
        );
    }
}

#[test]
fn after_halt_nothing_moves_until_enable_is_commanded() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    host.stream(
        &mut rig,
        1,
        pick_and_place().segments(&targets(&host)),
        WhenDry::End,
    );
    host.run_ms(&mut rig, 1_300);
    assert_eq!(host.ask(&mut rig, Request::Halt), Ok(Answer::Done));
    let from_ns = rig.board().soc().now_ns() + 2_000_000;
    host.stop_feeding();
    let begin = board_link::segment::Begin {
        stream: 2,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: [0; 4].into_iter().collect(),
    };
    assert_eq!(
        host.refusal(&mut rig, Request::Begin(begin)),
        Reason::NotEnabled
    );
    host.run_ms(&mut rig, 300);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    assert_eq!(host.state(&mut rig), BoardState::Halted);
    assert_eq!(host.ask(&mut rig, Request::Enable), Ok(Answer::Done));
    assert_eq!(host.state(&mut rig), BoardState::Enabled);
    // And a stream goes on from there.
    let judge = Judge::from_now(&rig);
    let stand = targets(&host);
    host.stream(&mut rig, 3, forth_and_back(&stand), WhenDry::End);
    host.run_ms(&mut rig, 1_500);
    assert!(judge.is_moving(&rig));
}

#[test]
fn a_fault_must_be_cleared_by_name() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    host.stream(
        &mut rig,
        1,
        pick_and_place().segments(&targets(&host)),
        WhenDry::End,
    );
    host.run_ms(&mut rig, 1_300);
    let drive = rig.drives()[1];
    rig.servo_mut(drive).faults_mut().leave_bus();
    let is_told = host.run_until(&mut rig, 500, |host, _| {
        host.told.iter().any(|told| {
            matches!(
                told,
                Incoming::Event {
                    event: Event::Fault {
                        axis: Some(1),
                        code: 10,
                        ..
                    },
                    ..
                }
            )
        })
    });
    assert!(is_told, "{:?}", host.told);
    host.run_ms(&mut rig, 300);
    assert_eq!(host.state(&mut rig), BoardState::Faulted);
    assert!(host.phases(1).contains(&StreamPhase::Stopped));
    assert_eq!(host.refusal(&mut rig, Request::Enable), Reason::Faulted);
    rig.servo_mut(drive).faults_mut().wake();
    host.run_ms(&mut rig, 300);
    assert_eq!(host.refusal(&mut rig, Request::Enable), Reason::Faulted);
    assert_eq!(host.ask(&mut rig, Request::Clear), Ok(Answer::Done));
    host.run_ms(&mut rig, 500);
    let enabled = host.ask(&mut rig, Request::Enable);
    assert_eq!(enabled, Ok(Answer::Done), "{:#?}", rig.board().log());
    assert!(rig.are_enabled());
}

#[test]
fn two_hosts_do_not_command_one_board() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    let session = host.client().session();
    assert_ne!(session, 0);
    // Another program on the same line, with a session of its own.
    let mut other = firmware_tests::host::Host::new(&mut rig, 2);
    host.is_dead = true;
    other.run_ms(&mut rig, 200);
    assert!(
        other.told.iter().any(|told| matches!(told, Incoming::Unavailable(refused) if refused.reason() == Some(Reason::Taken))),
        "{:?}",
        other.told
    );
    assert!(matches!(
        other.client().request(Request::Enable),
        Err(RequestError::Offline)
    ));
}
