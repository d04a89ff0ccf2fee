//! The firmware itself fails: it stalls, panics, runs out of stack, faults. The image is the one with failures on command.

use firmware_tests::rig::MS;
use firmware_tests::{Contact, ResetCause, Rig, rig};

const STALL: u8 = 1;
const PANIC: u8 = 2;
const FILL_THE_STACK: u8 = 3;
const UNDEFINED_INSTRUCTION: u8 = 4;

fn failed(how: u8) -> Rig {
    let mut rig = Rig::with_numbered_drives(rig::image("misbehaving"), 2);
    rig.bring_up();
    rig.board_mut().poke("MISBEHAVE", how);
    let failed_ns = rig.board().soc().now_ns();
    rig.run_ms(100);
    assert_eq!(rig.board().resets().len(), 1, "{:#?}", rig.board().log());
    assert!(
        rig.set_points_since(failed_ns + 2 * MS).next().is_none(),
        "set-points after the failure"
    );
    assert!(
        rig.servos().all(|drive| !drive.is_enabled()),
        "a drive is still enabled"
    );
    rig
}

/// No input brings the machine back.
fn stays_locked(mut rig: Rig) {
    let from_ns = rig.board().soc().now_ns();
    let resets = rig.board().resets().len();
    rig.run_ms(1_000);
    for _ in 0..3 {
        for contact in [Contact::Run, Contact::Enable, Contact::Stop] {
            rig.open(contact);
        }
        rig.run_ms(200);
        for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
            rig.close(contact);
            rig.run_ms(500);
        }
    }
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    assert!(rig.servos().all(|drive| !drive.is_enabled()));
    assert_eq!(rig.board().resets().len(), resets);
}

#[test]
fn a_stalled_cycle_is_ended_by_the_watchdog_and_nothing_moves_afterwards() {
    let rig = failed(STALL);
    let reset = rig.board().resets()[0];
    assert_eq!(reset.cause, ResetCause::Watchdog);
    assert!(rig.has_logged("the watchdog reset the board"));
    stays_locked(rig);
}

#[test]
fn a_panic_resets_says_where_and_nothing_moves_afterwards() {
    let rig = failed(PANIC);
    assert_eq!(rig.board().resets()[0].cause, ResetCause::Software);
    assert!(rig.has_logged("the firmware panicked at src/misbehaviour/on_command.rs:"));
    stays_locked(rig);
}

#[test]
fn a_stack_that_is_too_deep_ends_in_a_reset_and_not_in_other_variables() {
    let rig = failed(FILL_THE_STACK);
    assert_eq!(rig.board().faults().len(), 1, "{:x?}", rig.board().faults());
    assert!(
        rig.has_logged("the processor failed"),
        "{:#?}",
        rig.board().log()
    );
    stays_locked(rig);
}

#[test]
fn a_fault_of_the_processor_resets_and_is_reported() {
    let rig = failed(UNDEFINED_INSTRUCTION);
    assert_eq!(rig.board().faults().len(), 1, "{:x?}", rig.board().faults());
    assert!(rig.has_logged("the processor failed"));
    stays_locked(rig);
}

#[test]
fn no_reset_ends_the_lock() {
    for how in [PANIC, STALL] {
        let mut rig = failed(how);
        for cause in [ResetCause::Pin, ResetCause::Software, ResetCause::Pin] {
            rig.board_mut().soc_mut().reset_request = Some(cause);
            rig.run_ms(500);
        }
        assert!(rig.has_logged("locked: nothing moves until the board is switched off and on"));
        stays_locked(rig);
    }
}

#[test]
fn switching_the_board_off_and_on_ends_the_lock() {
    let mut rig = failed(PANIC);
    rig.board_mut().soc_mut().reset_request = Some(ResetCause::PowerOn);
    for contact in [Contact::Run, Contact::Enable] {
        rig.open(contact);
    }
    rig.make_ready();
    rig.enable();
}
