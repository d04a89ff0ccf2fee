//! To a hard stop.

use dyn_can::Revision;
use homing::{Abort, Config, Direction, Method, Progress};
use proptest::prelude::*;

use crate::stage::{Machine, Stage};

pub(crate) fn machines() -> impl Strategy<Value = Machine> {
    (
        any::<bool>(),
        any::<bool>(),
        -1_000_000..1_000_000_i32,
        1_000..9_000_i32,
        any::<bool>(),
    )
        .prop_map(
            |(is_new, is_up, start_counts, distance, is_low_active)| Machine {
                revision: if is_new {
                    Revision::V1_6A
                } else {
                    Revision::V1_2A
                },
                direction: if is_up {
                    Direction::Positive
                } else {
                    Direction::Negative
                },
                start_counts,
                distance,
                is_low_active,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the position, the direction and the revision: the stop is found where it is, the motor does not push when it is over,
    /// and the set-points never lead further into the stop than the limit.
    #[test]
    fn a_stop_is_found_where_it_is(machine in machines()) {
        let mut stage = Stage::with_stop(machine);
        let home = stage.found(machine.hard_stop());
        let expected = machine.expected_counts();
        prop_assert!(home.found_counts.abs_diff(expected) <= 1, "{home:?} {expected}");
        prop_assert!(home.uncertainty_counts <= 10);
        prop_assert!(home.contact_permille.is_some_and(|torque| torque >= 200));
        // The reference is at -50 counts of the axis.
        prop_assert_eq!(home.frame.to_axis(expected).abs_diff(-50) <= 1, true);
        let rest = home.found_counts - machine.direction.sign() * 400;
        prop_assert!(stage.position().abs_diff(rest) <= 1, "{} {rest}", stage.position());
        prop_assert!(stage.inputs().torque_permille.is_some_and(|torque| torque.value.abs() < 20));
        let into = machine.direction.sign() * (stage.farthest_sent - expected);
        prop_assert!((90..2_000).contains(&into), "{into}");
    }
}

#[test]
fn a_stop_that_is_not_there_ends_at_the_end_of_the_way() {
    for direction in [Direction::Positive, Direction::Negative] {
        let machine = Machine {
            direction,
            start_counts: 777,
            ..Machine::PLAIN
        };
        let mut stage = Stage::new(machine);
        let config = Config {
            way_counts: 3_000,
            ..machine.hard_stop()
        };
        assert_eq!(stage.failed(config), Abort::NotFound { way_counts: 3_000 });
        assert_eq!(stage.position(), 777 + direction.sign() * 3_000);
        assert_eq!(stage.farthest_sent, stage.position());
    }
}

/// 200 thousandths are a following error of 91 counts in the simulator: the limit of the torque decides where the error is small.
#[test]
fn the_torque_of_the_contact_decides() {
    let mut found = Vec::new();
    for contact_permille in [100, 300, 500] {
        let machine = Machine::PLAIN;
        let mut config = machine.hard_stop();
        if let Method::HardStop(stop) = &mut config.method {
            stop.contact_permille = contact_permille;
            stop.contact_counts = 20;
        }
        let mut stage = Stage::with_stop(machine);
        let home = stage.found(config);
        assert!(
            home.contact_permille >= Some(contact_permille as i16),
            "{home:?}"
        );
        found.push(home.contact_permille);
    }
    assert!(found.is_sorted_by(|a, b| a < b), "{found:?}");
}

#[test]
fn it_can_be_cancelled_at_any_time() {
    let machine = Machine::PLAIN;
    for at in [10, 300, 700, 900, 1_200, 1_300] {
        let mut stage = Stage::with_stop(machine);
        let end = stage.run(machine.hard_stop(), |_, homing, cycle| {
            if cycle == at {
                homing.cancel();
            }
        });
        assert_eq!(end, Progress::Failed(Abort::Cancelled), "{at}");
        // In contact or not: nothing pushes any more.
        let torque = stage.inputs().torque_permille.unwrap();
        assert!(torque.value.abs() < 100, "{at}: {torque:?}");
    }
}

#[test]
fn where_it_stands_nothing_moves() {
    for start_counts in [0, -12_345] {
        let machine = Machine {
            start_counts,
            ..Machine::PLAIN
        };
        let mut stage = Stage::new(machine);
        let home = stage.found(Config {
            method: Method::Here,
            ..machine.hard_stop()
        });
        assert_eq!(
            (home.found_counts, home.uncertainty_counts),
            (start_counts, 0)
        );
        assert_eq!(home.frame.to_axis(start_counts), -50);
        assert_eq!(stage.position(), start_counts);
        assert_eq!(stage.rig.drive(0).commanded_counts(), 0);
    }
}
