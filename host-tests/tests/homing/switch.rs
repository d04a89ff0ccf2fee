//! To a switch.

use homing::{Abort, Config, Direction};
use proptest::prelude::*;

use crate::stage::{Machine, Stage};
use crate::stop::machines;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The edge is found on both sides of it, in both polarities.
    #[test]
    fn an_edge_is_found_where_it_is(machine in machines(), starts_operated in any::<bool>()) {
        let distance = if starts_operated { -machine.distance } else { machine.distance };
        let machine = Machine { distance, ..machine };
        let mut stage = Stage::with_switch(machine);
        let home = stage.found(machine.limit_switch());
        let expected = machine.expected_counts();
        let off = home.found_counts.abs_diff(expected);
        prop_assert!(off <= home.uncertainty_counts.max(8), "{home:?} {expected}");
        prop_assert!(home.uncertainty_counts <= 40, "{home:?}");
        let rest = home.found_counts - machine.direction.sign() * 400;
        prop_assert!(stage.position().abs_diff(rest) <= 1);
        prop_assert!(!stage.rig.drive(0).switch_is_operated(stage.rig.bench.now_ns()));
    }
}

#[test]
fn a_switch_that_is_not_there_ends_at_the_end_of_the_way() {
    let machine = Machine {
        direction: Direction::Negative,
        ..Machine::PLAIN
    };
    let mut stage = Stage::new(machine);
    let config = Config {
        way_counts: 2_500,
        ..machine.limit_switch()
    };
    assert_eq!(stage.failed(config), Abort::NotFound { way_counts: 2_500 });
    assert_eq!(stage.position(), -2_500);
}

/// With the other polarity the switch looks operated from the start, and stays so.
#[test]
fn a_switch_of_the_other_polarity_is_stuck() {
    let machine = Machine::PLAIN;
    let mut stage = Stage::with_switch(machine);
    let upside_down = Machine {
        is_low_active: true,
        ..machine
    };
    let config = Config {
        way_counts: 3_000,
        ..upside_down.limit_switch()
    };
    assert_eq!(
        stage.failed(config),
        Abort::SwitchStuck { way_counts: 3_000 }
    );
    assert_eq!(stage.position(), -3_000);
}
