//! The image that takes orders follows a motion file that a host sends.

mod orders;

use board_link::host::{RequestError, StreamEnd};
use board_link::message::{Answer, BoardState, Request};
use board_link::segment::StreamPhase;
use board_link::{Reason, WhenDry};
use firmware_tests::Contact;
use firmware_tests::host::Host;
use firmware_tests::orders::{set_up, settings};
use firmware_tests::usart::Symbol;
use orders::{counts_told, pick_and_place, targets};

#[test]
fn four_axes_follow_a_file_of_a_host_that_is_up_to_50_ms_late() {
    // Settings written, restarted.
    let mut rig = orders::new();
    let mut host = Host::new(&mut rig, 1);
    set_up(&mut rig, &mut host, &settings(orders::AXES as u8));
    host.bring_up(&mut rig);
    host.pause_up_to(50);
    let file = pick_and_place();
    let rows = file.rows();
    let from_ns = rig.board().soc().now_ns();
    let stand = targets(&host);
    host.stream(&mut rig, 1, file.segments(&stand), WhenDry::End);
    let is_complete = host.run_until(&mut rig, 9_000, |host, _| {
        host.phases(1).contains(&StreamPhase::Complete)
    });
    assert!(is_complete, "{:?} {:#?}", host.told, rig.board().log());
    let end = host.stream_end();
    assert_eq!(end, Some(StreamEnd::Sent { segments: 600 }));
    host.run_ms(&mut rig, 1_100);
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
    let told = counts_told(&rig, from_ns);
    for (axis, told) in told.iter().enumerate() {
        let expected: Vec<i32> = rows.iter().map(|row| row[axis]).collect();
        let begins = |counts: &[i32]| counts.iter().position(|counts| *counts != 0).unwrap();
        // Both stand at first; from there on it is the same table, cycle by cycle.
        let (begun, planned) = (begins(told), begins(&expected));
        let told = &told[begun - planned..][..expected.len()];
        assert_eq!(told, expected, "axis {axis}");
    }
    // The books of the drives: what the board believes to have sent, and what they got.
    let sums: Vec<i64> = told
        .iter()
        .map(|told| i64::from(told[told.len() - 1]))
        .collect();
    let ends: Vec<i64> = targets(&host)
        .iter()
        .zip(&stand)
        .map(|(end, from)| i64::from(end - from))
        .collect();
    assert_eq!(sums, ends);
}

#[test]
fn a_board_without_settings_answers_and_moves_nothing() {
    let mut rig = orders::new();
    let mut host = Host::new(&mut rig, 1);
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    host.connect(&mut rig);
    let info = host.client().info().cloned().unwrap();
    assert_eq!((info.axes, info.segments), (0, 0));
    assert_eq!(host.state(&mut rig), BoardState::NoSettings);
    for request in [
        Request::Enable,
        Request::Disable,
        Request::Clear,
        Request::Home,
    ] {
        assert_eq!(host.refusal(&mut rig, request), Reason::NotReady);
    }
    host.run_ms(&mut rig, 500);
    assert_eq!(rig.from_board().count(), 0);
}

#[test]
fn settings_that_cannot_work_are_refused_with_a_number_and_those_before_stay() {
    let (mut rig, mut host) = orders::board();
    host.connect(&mut rig);
    let mut wrong = settings(4);
    wrong.axes[2].gear = 499;
    let mut too_many = settings(14);
    too_many
        .axes
        .iter_mut()
        .for_each(|axis| axis.polls.status_us = 1_000);
    let mut two_groups = settings(4);
    two_groups.axes[3].group = 1;
    for (settings, number, axis) in [(wrong, 1_009, Some(2)), (two_groups, 1_047, Some(3))] {
        match host.write_settings(&mut rig, &settings) {
            Err(RequestError::Refused(refused)) => {
                assert_eq!(
                    (refused.number, refused.axis),
                    (number, axis),
                    "{refused:?}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
    match host.write_settings(&mut rig, &too_many) {
        Err(RequestError::Refused(refused)) => {
            assert!((1_018..1_028).contains(&refused.number), "{refused:?}")
        }
        other => panic!("{other:?}"),
    }
    rig.cut_power(1_000, 100_000, 0);
    host.run_ms(&mut rig, 1_000);
    host.connect(&mut rig);
    assert_eq!(host.client().info().unwrap().axes, 4);
}

#[test]
fn settings_are_not_written_while_a_drive_is_enabled() {
    let (mut rig, mut host) = orders::board();
    host.bring_up(&mut rig);
    let refused = host.write_settings(&mut rig, &settings(3));
    let expected = Reason::Enabled.plain();
    assert_eq!(refused, Err(RequestError::Refused(expected)));
    assert!(rig.are_enabled());
    assert_eq!(host.ask(&mut rig, Request::Disable), Ok(Answer::Done));
    host.run_ms(&mut rig, 500);
    assert_eq!(
        host.write_settings(&mut rig, &settings(3)),
        Ok(Answer::Done)
    );
    assert!(
        rig.board().resets().len() <= 1,
        "the watchdog waits for the flash"
    );
}

#[test]
fn errors_of_the_line_are_counted_and_the_next_frames_get_through() {
    let (mut rig, mut host) = orders::board();
    host.connect(&mut rig);
    for _ in 0..5 {
        let now_ns = rig.board().soc().now_ns();
        let damage = [Symbol::Break, Symbol::Noisy(b'x'), Symbol::Break];
        rig.serial_mut().send(now_ns, damage);
        host.run_ms(&mut rig, 20);
        let answer = host.ask(&mut rig, Request::ReadCounters);
        assert!(matches!(answer, Ok(Answer::Counters(_))), "{answer:?}");
    }
    host.run_ms(&mut rig, 1_100);
    assert!(rig.has_logged("serial port:"), "{:#?}", rig.board().log());
}
