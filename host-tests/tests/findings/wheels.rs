//! What only wheels can get wrong.

use crate::support::wheels::{
    DISABLE_VOLTAGE, ENABLE_OPERATION, QUICK_STOP, Wheels, hub, hubs, wheel_line,
};
use crate::support::{Call, assert_none};

/// More cycles than a wheel needs from enable to streaming.
const ENABLING_CYCLES: usize = 200;

/// Finding 12: states of bits 0 to 3 that the guide does not describe, as a status comes in with one while a wheel is enabled.
#[test]
fn an_undocumented_state_is_not_answered_with_enable_operation() {
    let mut found = Vec::new();
    for state in [
        0b0010_u8, 0b0100, 0b0101, 0b0110, 0b1000, 0b1001, 0b1011, 0b1100, 0b1111,
    ] {
        for later in 0..ENABLING_CYCLES {
            let mut machine = Wheels::new(&hubs(1));
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine.run(later);
            if machine.all_stream() {
                break;
            }
            assert!(later + 1 < ENABLING_CYCLES, "still being enabled");
            let was = machine.words_since(0, 0).last().copied();
            let node = machine.node(0);
            let mark = machine.mark();
            // Stopped by no quick stop, no fault, no speed.
            let status = [0x20 | state, 0, 0, 0, 0, 0, 0, 0];
            machine.0.cycle_with(|rig| {
                Wheels::comes_in(rig, 0x180 + node, &status);
            });
            let words = machine.words_since(mark, 0);
            if words.contains(&ENABLE_OPERATION) && was != Some(ENABLE_OPERATION) {
                found.push(format!(
                    "state {state:04b} {later} cycles after enable: the control word goes from {was:04X?} to {words:04X?}"
                ));
            }
        }
    }
    assert_none(&found);
}

/// A status that was never read is no reason to switch on either.
#[test]
fn enabling_never_begins_with_enable_operation() {
    for sync in [false, true] {
        let line = if sync {
            wheel_line().by_sync()
        } else {
            wheel_line()
        };
        let mut machine = Wheels::on(line, &hubs(2));
        machine.stream();
        for axis in 0..2 {
            let words = machine.words_since(0, axis);
            assert_eq!(
                words,
                [DISABLE_VOLTAGE, 0x0006, 0x0007, ENABLE_OPERATION],
                "wheel {axis}, SYNC {sync}"
            );
        }
    }
}

/// Finding 19: the quick stop of `halt` is on the bus in the cycle of the call.
#[test]
fn halt_is_a_quick_stop_in_the_same_cycle_and_stays_one() {
    let mut machine = Wheels::streaming(&hubs(2));
    machine.drive_at(&[300, 300], 60);
    let mark = machine.mark();
    machine.call(Call::Halt).unwrap();
    machine.run(50);
    for axis in 0..2 {
        assert_eq!(
            machine.words_since(mark, axis),
            [QUICK_STOP],
            "wheel {axis}"
        );
        assert_eq!(machine.commands_since(mark, axis).len(), 50, "wheel {axis}");
        assert!(machine.energised(axis) && machine.speed_rpm(axis) == 0.0);
    }
}

/// Beyond the list: a target in position mode is not sent again as another edge while nothing moves, and `halt` in mid-move leaves
/// the rest of the move behind, whatever comes next.
#[test]
fn after_halt_in_a_move_nothing_goes_on_by_stop_disable_or_enable() {
    let mut found = Vec::new();
    for calls in [
        [Call::Stop, Call::Resume],
        [Call::Halt, Call::Resume],
        [Call::Disable, Call::Enable],
    ] {
        let mut machine = Wheels::streaming(&[hub(1).position(60), hub(2).position(60)]);
        let target = machine.sent(0) + 20_000;
        machine.drive_at(&[target, target], 50);
        machine.call(Call::Halt).unwrap();
        machine.run(50);
        let stood = machine.travel(0);
        for call in calls {
            let _ = machine.call(call);
            machine.run(100);
        }
        machine.run(500);
        let moved = machine.travel(0) - stood;
        if moved != 0 {
            found.push(format!(
                "halt, then {calls:?}: the wheel goes on by {moved} counts"
            ));
        }
    }
    assert_none(&found);
}
