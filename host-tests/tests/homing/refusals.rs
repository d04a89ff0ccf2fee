//! What cannot work is refused before anything moves, with what is expected.

use homing::{Config, Homing, Method, Refusal};
use trajectory::Limits;

use crate::stage::Machine;

const PLAIN: Machine = Machine::PLAIN;

fn refused(change: impl FnOnce(&mut Config)) -> String {
    let mut config = PLAIN.hard_stop();
    change(&mut config);
    Homing::new(config, 0).map(drop).unwrap_err().to_string()
}

fn stop(config: &mut Config) -> &mut homing::HardStop {
    match &mut config.method {
        Method::HardStop(stop) => stop,
        _ => unreachable!("the configuration of a hard stop"),
    }
}

#[test]
fn each_refusal_names_what_it_expects() {
    assert!(Homing::new(PLAIN.hard_stop(), 0).is_ok());
    assert!(Homing::new(PLAIN.limit_switch(), 0).is_ok());
    for (actual, expected) in [
        (
            refused(|config| config.way_counts = 0),
            "the way of the search in counts must be 1..=2147483647, it is 0",
        ),
        (
            refused(|config| config.back_off_counts = 0),
            "the way back in counts must be 1..=20000, it is 0",
        ),
        (
            refused(|config| config.back_off_counts = 20_001),
            "the way back in counts must be 1..=20000, it is 20001",
        ),
        (
            refused(|config| stop(config).contact_permille = 0),
            "the torque of a contact in thousandths must be 1..=1000, it is 0",
        ),
        (
            refused(|config| stop(config).most_permille = 199),
            "the highest torque in thousandths must be 200..=1000, it is 199",
        ),
        (
            refused(|config| stop(config).contact_counts = 2_000),
            "the following error of a contact in counts must be 1..=1999, it is 2000",
        ),
        (
            refused(|config| config.watch.max_age_us = 999),
            "the age of readings in microseconds must be 1000..=10000000, it is 999",
        ),
        (
            refused(|config| config.cycle_us = 0),
            "the cycle in microseconds must be 1..=1000000, it is 0",
        ),
        (
            refused(|config| config.watch.settle_us = 0),
            "the time to settle in microseconds must be 1000..=60000000, it is 0",
        ),
        (
            refused(|config| config.slow = Limits::new(8.5, 0.5, 0.05).unwrap()),
            "the second approach must not be faster than the search, 8 counts per cycle, it is 8.5",
        ),
        (
            refused(|config| config.travel.min_counts = -449),
            "the axis comes to rest at -450, which must be within its travel, -449..=60000 counts",
        ),
    ] {
        assert_eq!(actual, expected);
    }
}

#[test]
fn a_search_that_is_too_fast_for_its_readings_is_refused() {
    let mut config = PLAIN.hard_stop();
    config.search = Limits::new(20.0, 0.5, 0.05).unwrap();
    // Two readings of 50 ms at 20 counts a cycle are 2000 counts, and there is room for 1910.
    let refusal = Homing::new(config, 0).map(drop).unwrap_err();
    let expected = Refusal::TooFast {
        most: 19.1,
        actual: 20.0,
    };
    assert_eq!(refusal, expected);
}

#[test]
fn a_way_beyond_32_bit_is_refused() {
    let refusal = Homing::new(PLAIN.hard_stop(), i32::MAX - 5)
        .map(drop)
        .unwrap_err();
    assert!(matches!(
        refusal,
        Refusal::WayTooFar {
            actual: 2_147_483_648..
        }
    ));
}
