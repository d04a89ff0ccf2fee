//! From power-on to a running motion: nothing moves until somebody says so.

use dyn_can::DriveId;
use firmware_tests::{Contact, Rig, Stop, rig, soc};

fn power_on() -> Rig {
    Rig::with_numbered_drives(rig::image("shipped"), 2)
}

#[test]
fn it_boots_and_waits_for_the_enable_input() {
    let mut rig = power_on();
    rig.close(Contact::Stop);
    assert_eq!(rig.run_ms(3_000), Stop::Limit);
    assert!(rig.has_logged("on the bus"));
    assert_eq!(rig.set_points_since(0).count(), 0);
    // Drives come up with their servo on, and a load may hang on them.
    assert!(rig.has_logged("-> FoundOn"));
    assert!(rig.has_logged("it is left alone until enable becomes active"));
    assert_eq!(rig.switches_since(0).count(), 0);
    assert!(rig.are_enabled());
    assert_eq!(rig.statistic("late"), Some(0));
}

#[test]
fn inputs_that_are_active_at_power_on_start_nothing() {
    let mut rig = power_on();
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    rig.run_ms(2_000);
    assert!(rig.has_logged("release the enable input"));
    assert_eq!(rig.switches_since(0).count(), 0);
    assert_eq!(rig.set_points_since(0).count(), 0);
    // Its release is the word to take their power.
    rig.open(Contact::Enable);
    rig.run_ms(100);
    assert!(!rig.are_enabled());
}

#[test]
fn it_adopts_the_drives_that_it_finds_on_and_then_holds_still() {
    let mut rig = power_on();
    rig.make_ready();
    rig.enable();
    assert_eq!(
        rig.switches_since(0).count(),
        0,
        "a drive was switched although it was on"
    );
    holds_still(&rig);
}

#[test]
fn it_enables_the_drives_that_are_off_and_then_holds_still() {
    let mut rig = power_on();
    // The circuit is open for longer than the firmware lets the motors stop.
    rig.run_ms(1_000);
    assert!(!rig.are_enabled());
    rig.make_ready();
    let from_ns = rig.board().soc().now_ns();
    rig.enable();
    assert_eq!(rig.switches_since(from_ns).count(), 2);
    holds_still(&rig);
}

fn holds_still(rig: &Rig) {
    for drive in rig.wire().devices() {
        assert_eq!(
            (
                drive.books().commanded_counts,
                drive.books().pd_frames_ignored
            ),
            (0, 0)
        );
    }
}

#[test]
fn a_bouncing_enable_switch_does_not_count() {
    let mut rig = power_on();
    rig.make_ready();
    for _ in 0..50 {
        rig.close(Contact::Enable);
        rig.run_ms(10);
        rig.open(Contact::Enable);
        rig.run_ms(1);
    }
    assert_eq!(rig.switches_since(0).count(), 0);
    assert_eq!(rig.set_points_since(0).count(), 0);
}

#[test]
fn run_moves_and_its_release_ends_the_motion_where_it_began() {
    let mut rig = power_on();
    rig.bring_up();
    rig.run_ms(1_000);
    assert!(rig.commanded_counts()[0] > 4_000);
    assert!(rig.commanded_counts()[1] < -4_000);
    rig.open(Contact::Run);
    assert!(rig.run_until_logged("the motion has ended", 3_000));
    rig.run_ms(20);
    assert_eq!(rig.commanded_counts(), [0, 0]);
    rig.open(Contact::Enable);
    rig.run_ms(500);
    assert!(rig.wire().devices().all(|drive| !drive.is_enabled()));
}

#[test]
fn a_drive_that_is_missing_keeps_the_others_still() {
    let drive = drive_sim::DynDriveConfig::new(DriveId::MIN);
    let mut rig = Rig::with_drives(rig::image("shipped"), [drive]);
    rig.make_ready();
    rig.close(Contact::Enable);
    rig.run_ms(6_000);
    assert!(rig.has_logged("no answer: check power"));
    assert_eq!(rig.set_points_since(0).count(), 0);
    assert_eq!(rig.switches_since(0).count(), 0);
}

#[test]
fn a_drive_with_another_gear_number_is_not_enabled() {
    let mut drives = [1, 2].map(|id| drive_sim::DynDriveConfig::numbered(id).unwrap());
    drives[1].group3.gear_number = dyn_can::GearNumber::new(8_192).unwrap();
    let mut rig = Rig::with_drives(rig::image("shipped"), drives);
    rig.make_ready();
    rig.close(Contact::Enable);
    rig.run_ms(2_000);
    assert!(rig.has_logged("its gear number is 8192, the configuration says 4096"));
    for _ in 0..3 {
        rig.open(Contact::Enable);
        rig.run_ms(100);
        rig.close(Contact::Enable);
        rig.run_ms(1_000);
    }
    assert_eq!(rig.set_points_since(0).count(), 0);
    assert!(!rig.are_enabled(), "the release of enable disables it too");
}

#[test]
fn the_brown_out_level_is_set_once_in_the_life_of_the_chip() {
    let mut rig = power_on();
    rig.run_ms(50);
    let soc = rig.board().soc();
    assert_eq!(soc.storage.peek(soc::FLASH_OPTCR) & 0b1100, 0);
    let writes = soc.storage.touched()[&soc::FLASH_OPTCR].writes;
    rig.board_mut().soc_mut().reset_request = Some(firmware_tests::ResetCause::Software);
    rig.run_ms(50);
    assert_eq!(rig.board().resets().len(), 1);
    assert_eq!(
        rig.board().soc().storage.touched()[&soc::FLASH_OPTCR].writes,
        writes
    );
}

#[test]
fn the_status_led_shows_the_state() {
    let mut rig = power_on();
    let lit_ms = |rig: &mut Rig| {
        (0..2_000)
            .filter(|_| {
                rig.run_ms(1);
                rig.is_led_lit() == Some(true)
            })
            .count()
    };
    rig.run_ms(100);
    // The stop circuit is open: three flashes of an eighth of a second in two seconds.
    assert!(lit_ms(&mut rig).abs_diff(375) < 5);
    rig.make_ready();
    assert!(lit_ms(&mut rig).abs_diff(1_000) < 5);
    rig.enable();
    assert!(lit_ms(&mut rig).abs_diff(1_750) < 5);
    rig.close(Contact::Run);
    rig.run_ms(100);
    assert_eq!(lit_ms(&mut rig), 2_000);
}

#[test]
fn two_runs_are_the_same_to_the_instruction() {
    let run = || {
        let mut rig = power_on();
        let mut instructions = Vec::new();
        rig.bring_up();
        for _ in 0..300 {
            rig.run_ms(1);
            instructions.push(rig.board().soc().instructions);
        }
        let traffic: Vec<_> = rig.wire().bus().log().iter().copied().collect();
        (instructions, traffic, rig.board().log().to_vec())
    };
    assert!(run() == run());
}
