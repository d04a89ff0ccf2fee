//! What cannot work is refused when the master is made, with what was expected, what was given and what to do.

use crate::support::assert_none;
use crate::support::servos::{Servos, line, servo};
use crate::support::wheels::{WheelLine, hub, hubs, wheel_line};

/// Finding 10.
#[test]
fn more_wheels_than_64_are_refused() {
    // Their commands every 120 ms and their feedback every 100 ms, by the shorter reading of the timer, fit at 1 Mbit/s.
    let line = wheel_line()
        .kbit1000()
        .cycle_us(120_000)
        .feedback_ticks(200)
        .timeouts(|timeouts| {
            timeouts.feedback_lost_us = 400_000;
            timeouts.confirm_us = 800_000;
        });
    let found = [65, 70, 100]
        .into_iter()
        .filter_map(|count| match line.admits(&hubs(count)) {
            Ok(()) => Some(format!("{count} wheels are accepted, 64 is the most")),
            Err(text) if !text.contains("64") || !text.contains(&count.to_string()) => Some(
                format!("{count} wheels: the refusal does not say why: {text}"),
            ),
            Err(_) => None,
        });
    assert_none(&found.collect::<Vec<_>>());
    line.admits(&hubs(64)).unwrap();
}

/// Finding 10: as many wheels as are accepted can begin a cycle.
#[test]
fn what_is_accepted_can_begin_a_cycle() {
    let wheels = hubs(70);
    let line = wheel_line().kbit1000().cycle_us(40_000);
    if line.admits(&wheels).is_err() {
        return;
    }
    let panicked = std::panic::catch_unwind(|| line.set_up_and_begin_cycles(&wheels));
    assert!(
        panicked.is_ok(),
        "70 wheels are accepted, and the cycle in which the 65th is set up panics"
    );
}

/// Finding 11: timing of wheels that contradicts itself.
#[test]
fn wheel_timing_that_cannot_work_is_refused() {
    type Case = (&'static str, WheelLine, [&'static str; 3]);
    let timeouts =
        |change: fn(&mut can_motion::wheel::WheelTimeouts)| wheel_line().timeouts(change);
    let cases: Vec<Case> = vec![
        (
            "a cycle of 1 s, and drives that stop after 300 ms of silence",
            wheel_line().cycle_us(1_000_000),
            ["offline_ms", "2000", "300"],
        ),
        (
            "a cycle of 200 ms, and drives that stop after 300 ms: one late frame stops them",
            wheel_line().cycle_us(200_000),
            ["offline_ms", "400", "300"],
        ),
        (
            "a heartbeat watch of 1 us for a heartbeat of 100 ms",
            timeouts(|timeouts| timeouts.heartbeat_lost_us = 1),
            ["heartbeat_lost_us", "200000", "1"],
        ),
        (
            "a heartbeat watch of 100 ms for a heartbeat of 100 ms",
            timeouts(|timeouts| timeouts.heartbeat_lost_us = 100_000),
            ["heartbeat_lost_us", "200000", "100000"],
        ),
        (
            "a feedback watch of 1 us for feedback every 10 ms",
            timeouts(|timeouts| timeouts.feedback_lost_us = 1),
            ["feedback_lost_us", "40000", "got 1"],
        ),
        (
            "feedback every 500 ms (1000 ticks) and a watch of 100 ms",
            wheel_line().feedback_ticks(1_000),
            ["feedback_lost_us", "2000000", "100000"],
        ),
        (
            "feedback that never comes (0 ticks)",
            wheel_line().feedback_ticks(0),
            ["feedback", "got 0", "1"],
        ),
        (
            "feedback by SYNC every cycle of 100 ms and a watch of 100 ms",
            wheel_line().by_sync().cycle_us(100_000),
            ["feedback_lost_us", "200000", "100000"],
        ),
        (
            "a confirmation within 1 us",
            timeouts(|timeouts| timeouts.confirm_us = 1),
            ["confirm_us", "80000", "got 1"],
        ),
        (
            "a standstill of 10 s to come within 5 s",
            timeouts(|timeouts| timeouts.standstill_us = 10_000_000),
            ["standstill_limit_us", "10000001", "5000000"],
        ),
        (
            "a standstill of 0 ms",
            timeouts(|timeouts| timeouts.standstill_us = 0),
            ["standstill_us", "got 0", "1"],
        ),
        (
            "an offline time of 1 ms with a cycle of 10 ms",
            timeouts(|timeouts| timeouts.offline_ms = 1),
            ["offline_ms", "20", "got 1"],
        ),
    ];
    let found =
        cases
            .into_iter()
            .filter_map(|(what, line, numbers)| match line.admits(&[hub(1)]) {
                Ok(()) => Some(format!("accepted: {what}")),
                Err(text) if !numbers.iter().all(|number| text.contains(number)) => Some(format!(
                    "{what}: the refusal lacks one of {numbers:?}: {text}"
                )),
                Err(_) => None,
            });
    assert_none(&found.collect::<Vec<_>>());
}

/// Finding 11 for servos: the same kind of contradiction.
#[test]
fn servo_timing_that_cannot_work_is_refused() {
    let cases = [
        (
            "a reply timeout of 1 us",
            line().timeouts(|timeouts| timeouts.reply_us = 1),
        ),
        (
            "a reply timeout shorter than the response of the drives",
            line()
                .responses_up_to_us(9_000)
                .timeouts(|timeouts| timeouts.reply_us = 5_000),
        ),
        (
            "a confirmation within 1 us",
            line().timeouts(|timeouts| timeouts.confirm_us = 1),
        ),
        (
            "a confirmation within the timeout of one reply",
            line().timeouts(|timeouts| timeouts.confirm_us = 5_000),
        ),
        (
            "a standstill of 0 ms",
            line().timeouts(|timeouts| timeouts.standstill_us = 0),
        ),
        (
            "a standstill of 10 s to come within 5 s",
            line().timeouts(|timeouts| timeouts.standstill_us = 10_000_000),
        ),
    ];
    let found = cases.into_iter().filter_map(|(what, line)| {
        let accepted = line.admits(&[servo(1)]).is_ok();
        accepted.then(|| format!("accepted: {what}"))
    });
    assert_none(&found.collect::<Vec<_>>());
}

/// Finding 14: an axis that nobody watches must be declared so.
#[test]
fn a_drive_that_left_the_bus_is_not_streamed_for_ever() {
    let refusal = line().admits(&[servo(1).without_polls(), servo(2)]);
    assert!(
        refusal
            .as_ref()
            .is_err_and(|text| text.contains("drive 1") && text.contains("unwatched")),
        "nobody watches the axis, and nobody said so: {refusal:?}"
    );
    line().admits(&[servo(1).unwatched(), servo(2)]).unwrap();
    // One that is watched is noticed.
    let mut machine = Servos::streaming(&[servo(1), servo(2)]);
    machine.move_all(&[40, 0], 100);
    machine.faults_mut(0).leave_bus();
    let mark = machine.mark();
    machine.move_all(&[40, 0], 1_000);
    let counts: i32 = machine.steps_since(mark, 0).iter().sum();
    assert!(
        machine.fault(0).is_some() && counts < 10_000,
        "a drive that left the bus was streamed {counts} counts, fault {:?}",
        machine.fault(0)
    );
}
