//! The supply of the board fails and comes back while the drives keep theirs.

use firmware_tests::{Contact, ResetCause, Rig, rig};

#[test]
fn after_a_cut_of_the_supply_it_starts_anew_and_nothing_moves_until_the_enable_is_released() {
    let mut rig = Rig::with_numbered_drives(rig::image("shipped"), 2);
    rig.bring_up();
    assert!(rig.set_points_since(0).count() > 0);
    rig.cut_power(0, 1_000_000, 1);
    let back_ns = rig.board().soc().now_ns();
    let causes: Vec<_> = rig
        .board()
        .resets()
        .iter()
        .map(|reset| reset.cause)
        .collect();
    assert_eq!(causes, [ResetCause::PowerOn]);
    // The contacts are still closed.
    rig.run_ms(2_000);
    assert!(rig.has_logged("release the enable input"));
    assert_eq!(rig.set_points_since(back_ns).count(), 0);
    rig.open(Contact::Enable);
    rig.run_ms(500);
    assert!(!rig.are_enabled());
    let starts: Vec<u64> = rig.from_board().map(|record| record.start_ns).collect();
    let (before, after): (Vec<u64>, Vec<u64>) =
        starts.into_iter().partition(|at_ns| *at_ns < back_ns);
    let (before, after) = (before[before.len() - 1], after[0]);
    assert!(after - before > 1_000_000_000, "the board was off for 1 s");
}
