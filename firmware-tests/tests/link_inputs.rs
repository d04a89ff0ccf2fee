//! The inputs rule over the link: stop circuit and enable input, in every state, against every command.

mod orders;

use board_link::message::{Answer, BoardState, Request};
use board_link::segment::{Begin, StreamPhase};
use board_link::{Reason, WhenDry};
use firmware_tests::host::Host;
use firmware_tests::{Contact, Rig};
use orders::{Judge, board, forth_and_back, targets};

/// Where the board is when an input is opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Situation {
    Off,
    GettingReady,
    Enabled,
    Waiting,
    Moving,
    Paused,
    Held,
}

const ALL: [Situation; 7] = [
    Situation::Off,
    Situation::GettingReady,
    Situation::Enabled,
    Situation::Waiting,
    Situation::Moving,
    Situation::Paused,
    Situation::Held,
];

/// From the opened input until the last set-point: the debouncing, and for a ramp its length.
const HALT_MS: u64 = 30;
const RAMP_MS: u64 = 400;

fn reach(situation: Situation) -> (Rig, Host) {
    let (mut rig, mut host) = board();
    if situation == Situation::Off || situation == Situation::GettingReady {
        rig.make_ready();
        rig.close(Contact::Enable);
        host.run_ms(&mut rig, 50);
        host.connect(&mut rig);
        if situation == Situation::GettingReady {
            host.client().request(Request::Enable).unwrap();
            host.run_ms(&mut rig, 30);
        }
        return (rig, host);
    }
    host.bring_up(&mut rig);
    if situation == Situation::Enabled {
        return (rig, host);
    }
    let judge = Judge::from_now(&rig);
    let mut segments = forth_and_back(&targets(&host));
    if situation == Situation::Waiting {
        segments.clear();
    }
    host.stream(&mut rig, 1, segments, WhenDry::Wait);
    if situation == Situation::Waiting {
        host.stop_feeding();
        host.run_ms(&mut rig, 100);
        return (rig, host);
    }
    judge.wait_for_motion(&mut rig, &mut host);
    match situation {
        Situation::Paused => {
            assert_eq!(host.ask(&mut rig, Request::Pause), Ok(Answer::Done));
            host.run_ms(&mut rig, 600);
        }
        Situation::Held => assert_eq!(host.ask(&mut rig, Request::Halt), Ok(Answer::Done)),
        _ => {}
    }
    (rig, host)
}

#[test]
fn an_open_input_ends_everything_and_only_a_command_brings_it_back() {
    for (contact, reason, state, rest_ms) in [
        (
            Contact::Stop,
            Reason::StopInput,
            BoardState::StopOpen,
            HALT_MS,
        ),
        (
            Contact::Enable,
            Reason::EnableInput,
            BoardState::EnableInactive,
            RAMP_MS,
        ),
    ] {
        for situation in ALL {
            let case = format!("{situation:?}, {contact:?}");
            let (mut rig, mut host) = reach(situation);
            rig.open(contact);
            let rests_ns = rig.board().soc().now_ns() + rest_ms * 1_000_000;
            host.run_ms(&mut rig, 1_500);
            // Drives that were on before the board was are left alone as long as nobody has enabled them.
            let is_left_alone = situation == Situation::Off && contact == Contact::Enable;
            assert_eq!(rig.are_enabled(), is_left_alone, "{case}");
            assert_eq!(rig.set_points_since(rests_ns).count(), 0, "{case}");
            assert!(!host.phases(1).contains(&StreamPhase::Complete));
            assert_eq!(host.state(&mut rig), state, "{case}");
            refuses_everything(&mut rig, &mut host, reason, &case);
            // A halt would end a stream that the input has not.
            let has_stream = matches!(
                situation,
                Situation::Waiting | Situation::Moving | Situation::Paused
            );
            if !has_stream {
                ends_nothing(&mut rig, &mut host, &case);
            }
            // Closing it brings nothing back.
            rig.close(contact);
            let closed_ns = rig.board().soc().now_ns();
            host.run_ms(&mut rig, 1_500);
            assert_eq!(rig.are_enabled(), is_left_alone, "{case}");
            assert_eq!(rig.set_points_since(closed_ns).count(), 0, "{case}");
            // The command does.
            assert_eq!(
                host.ask(&mut rig, Request::Enable),
                Ok(Answer::Done),
                "{case}"
            );
            assert!(rig.are_enabled(), "{case}");
            host.run_ms(&mut rig, 500);
            let told = orders::counts_told(&rig, closed_ns);
            assert!(
                told.iter().flatten().all(|counts| *counts == 0),
                "{case}: an old stream went on"
            );
        }
    }
}

/// What ends things is taken, and there is nothing to end.
fn ends_nothing(rig: &mut Rig, host: &mut Host, case: &str) {
    let from_ns = rig.board().soc().now_ns();
    for request in [Request::Stop, Request::Halt, Request::Clear] {
        assert_eq!(host.ask(rig, request), Ok(Answer::Done), "{case}");
    }
    host.run_ms(rig, 100);
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "{case}");
    assert_eq!(rig.switches_since(from_ns).count(), 0, "{case}");
}

fn refuses_everything(rig: &mut Rig, host: &mut Host, reason: Reason, case: &str) {
    let from_ns = rig.board().soc().now_ns();
    assert_eq!(host.refusal(rig, Request::Enable), reason, "{case}");
    let begin = Begin {
        stream: 9,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: targets(host)
            .iter()
            .map(|target| i64::from(*target) << 24)
            .collect(),
    };
    assert_eq!(host.refusal(rig, Request::Begin(begin)), reason, "{case}");
    assert_eq!(
        host.refusal(rig, Request::Home),
        Reason::Unsupported,
        "{case}"
    );
    host.run_ms(rig, 100);
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "{case}");
    assert_eq!(rig.switches_since(from_ns).count(), 0, "{case}");
}

#[test]
fn inputs_that_are_active_at_power_on_enable_nothing_and_the_run_input_never_does() {
    let (mut rig, mut host) = board();
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    host.run_ms(&mut rig, 1_000);
    host.connect(&mut rig);
    assert_eq!(host.state(&mut rig), BoardState::Off);
    assert_eq!(rig.switches_since(0).count(), 0);
    assert_eq!(host.ask(&mut rig, Request::Enable), Ok(Answer::Done));
    rig.open(Contact::Run);
    host.run_ms(&mut rig, 200);
    rig.close(Contact::Run);
    host.run_ms(&mut rig, 500);
    assert!(
        orders::counts_told(&rig, 0)
            .iter()
            .flatten()
            .all(|counts| *counts == 0)
    );
}
