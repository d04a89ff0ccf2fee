//! From power-on to a running motion: nothing moves until somebody says so.

use dyn_can::DriveId;
use firmware_tests::chip::Controller;
use firmware_tests::gpio::Pin;
use firmware_tests::watchdog::FASTEST_LSI_HZ;
use firmware_tests::{Contact, ResetCause, Rig, Stop, fault, rig};

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
    for drive in rig.servos() {
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
    assert!(rig.servos().all(|drive| !drive.is_enabled()));
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

fn option_byte_writes(rig: &Rig) -> u64 {
    let (register, ..) = rig.board().soc().chip.option_bytes;
    let touched = rig.board().soc().storage.touched();
    touched[&register].writes
}

#[test]
fn the_option_bytes_are_not_written_unasked() {
    let mut rig = power_on();
    rig.run_ms(3_000);
    assert!(rig.has_logged("set its brown-out level once with `cargo fw --commission`"));
    assert_eq!(option_byte_writes(&rig), 0);
}

#[test]
fn the_image_for_commissioning_writes_them_once_and_only_with_a_steady_supply() {
    let mut rig = Rig::with_numbered_drives(rig::image("commission"), 2);
    let (register, mask, new) = rig.board().soc().chip.option_bytes;
    let options = |rig: &Rig| rig.board().soc().storage.peek(register);
    for _ in 0..5 {
        rig.run_ms(900);
        rig.board_mut().soc_mut().supply_is_low = true;
        rig.run_ms(10);
        rig.board_mut().soc_mut().supply_is_low = false;
    }
    assert_eq!((options(&rig), option_byte_writes(&rig)), (new, 0));
    rig.run_ms(1_100);
    let level = options(&rig) & mask;
    let highest = rig.board().soc().chip.highest_brown_out_level;
    assert_eq!(level, highest, "{:#?}", rig.board().log());
    assert!(rig.has_logged("the brown-out level is set: switch the board off and on"));
    let written = option_byte_writes(&rig);
    rig.board_mut().soc_mut().reset_request = Some(ResetCause::Pin);
    rig.run_ms(2_000);
    assert!(rig.has_logged("set already: nothing was written"));
    assert_eq!(option_byte_writes(&rig), written);
    assert_eq!(rig.from_board().count(), 0);
}

#[test]
fn caches_and_prefetch_are_on_with_the_wait_states_of_the_clock() {
    const PREFETCH_AND_CACHES: u32 = 0b111 << 8;
    let mut rig = power_on();
    rig.run_ms(50);
    let chip = rig.board().soc().chip;
    let access = rig.board().soc().storage.peek(chip.flash_access);
    assert_eq!(access & PREFETCH_AND_CACHES, PREFETCH_AND_CACHES);
    // 168 MHz: a wait state for each 30 MHz begun; 160 MHz with the raised supply: one for each 34 MHz.
    assert_eq!(
        access & 0xF,
        if chip.controller == Controller::BxCan {
            5
        } else {
            4
        }
    );
}

#[test]
fn the_prefetch_of_the_first_revision_of_the_stm32f405_stays_off() {
    if rig::chip().controller != Controller::BxCan {
        return;
    }
    let mut rig = power_on();
    rig.board_mut()
        .soc_mut()
        .storage
        .poke(0xE004_2000, 0x1000_6413);
    rig.run_ms(50);
    let register = rig.board().soc().chip.flash_access;
    let access = rig.board().soc().storage.peek(register);
    assert_eq!(access >> 8 & 0b111, 0b110);
}

#[test]
fn the_controller_is_connected_to_the_pins_of_the_board_and_to_no_others() {
    let mut rig = power_on();
    rig.run_ms(50);
    let (pins, function) = rig.board().soc().chip.can_pins;
    let gpio = &rig.board().soc().gpio;
    for (port, number) in ('A'..='C').flat_map(|port| (0..16).map(move |number| (port, number))) {
        let pin = Pin::new(port, number);
        let has_it = gpio.alternate_function(pin) == Some(function);
        assert_eq!(has_it, pins.contains(&pin), "{pin:?}");
    }
}

#[test]
fn watchdog_and_led_come_before_the_first_thing_that_can_wait() {
    let mut rig = Rig::without_crystal(rig::image("shipped"));
    rig.run_ms(1);
    assert!(rig.board().soc().watchdog.expires_ns().is_some());
    assert_eq!(rig.is_led_lit(), Some(true));
}

#[test]
fn the_fastest_watchdog_is_fed_in_time_also_by_a_start_that_waits() {
    for (crystal, image, drives) in [(true, "axes-8", 8), (false, "shipped", 2)] {
        let mut rig = if crystal {
            Rig::with_numbered_drives(rig::image(image), drives)
        } else {
            Rig::without_crystal(rig::image(image))
        };
        rig.board_mut().soc_mut().watchdog.oscillator_hz = FASTEST_LSI_HZ;
        if crystal {
            rig.bring_up();
        }
        rig.run_ms(1_000);
        // A start that begins with a failure disables the drives first.
        rig.board_mut().soc_mut().reset_request = Some(ResetCause::Watchdog);
        rig.run_ms(1_000);
        assert_eq!(rig.board().resets().len(), 1, "{:?}", rig.board().resets());
    }
}

#[test]
fn without_a_crystal_it_shows_it_and_leaves_the_bus_alone() {
    let mut rig = Rig::without_crystal(rig::image("shipped"));
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    rig.run_ms(500);
    assert!(
        rig.has_logged("the crystal does not run"),
        "{:#?}",
        rig.board().log()
    );
    // Five flashes of an eighth of a second.
    assert!(rig.lit_ms().abs_diff(625) < 10);
    for contact in [Contact::Enable, Contact::Run] {
        rig.open(contact);
        rig.run_ms(500);
        rig.close(contact);
    }
    rig.run_ms(2_000);
    assert_eq!(rig.board().resets(), []);
    assert_eq!(rig.from_board().count(), 0);
}

#[test]
fn a_start_that_waits_for_the_crystal_without_an_end_is_noticed() {
    let mut rig = Rig::without_crystal(rig::image("misbehaving"));
    rig.put_back(fault::WAIT_FOR_THE_CRYSTAL);
    rig.run_ms(2_000);
    assert!(!rig.has_logged("the crystal does not run"));
    // Only the watchdog gets it out of there, again and again.
    assert!(rig.board().resets().len() > 1);
}

#[test]
fn a_crystal_that_stops_in_motion_ends_it_and_the_board_stays_off() {
    let mut rig = power_on();
    rig.bring_up();
    rig.board_mut().soc_mut().lose_crystal();
    let lost_ns = rig.board().soc().now_ns();
    rig.run_ms(500);
    assert_eq!(rig.board().resets().len(), 1);
    assert!(rig.has_logged("the crystal stopped in motion"));
    assert!(rig.has_logged("the crystal does not run"));
    assert!(rig.lit_ms().abs_diff(625) < 10);
    // Only what was on the wire.
    assert!(rig.set_points_since(lost_ns).count() <= 1);
}

#[test]
fn a_crystal_that_is_not_watched_is_noticed() {
    let mut rig = Rig::with_numbered_drives(rig::image("misbehaving"), 2);
    rig.put_back(fault::NO_CLOCK_SECURITY);
    rig.bring_up();
    rig.board_mut().soc_mut().lose_crystal();
    let lost_ns = rig.board().soc().now_ns();
    rig.run_ms(500);
    assert_eq!(rig.board().resets(), []);
    assert!(rig.set_points_since(lost_ns).count() > 900);
}

#[test]
fn a_bus_that_is_dominant_at_power_on_is_shown_and_joined_when_it_is_free() {
    let mut rig = power_on();
    rig.hold_dominant(true);
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    rig.run_ms(2_500);
    assert!(
        rig.has_logged("the bus is never idle"),
        "{:#?}",
        rig.board().log()
    );
    // Two flashes of an eighth of a second.
    assert!(rig.lit_ms().abs_diff(250) < 10);
    assert_eq!(
        (rig.board().resets(), rig.from_board().count()),
        (&[][..], 0)
    );
    rig.hold_dominant(false);
    rig.run_ms(2_000);
    assert!(rig.has_logged("on the bus"));
    assert!(rig.has_logged("release the enable input"));
    assert_eq!(rig.set_points_since(0).count(), 0);
    for contact in [Contact::Enable, Contact::Run] {
        rig.open(contact);
    }
    rig.run_ms(500);
    rig.enable();
}

#[test]
fn a_start_that_waits_for_the_bus_is_noticed() {
    let mut rig = Rig::with_numbered_drives(rig::image("misbehaving"), 2);
    rig.put_back(fault::WAIT_FOR_THE_BUS);
    rig.hold_dominant(true);
    rig.run_ms(2_500);
    assert!(!rig.has_logged("the bus is never idle"));
    assert!(rig.board().resets().len() > 1);
}

#[test]
fn the_status_led_shows_the_state() {
    let mut rig = power_on();
    rig.run_ms(100);
    // The stop circuit is open: three flashes of an eighth of a second in two seconds.
    assert!(rig.lit_ms().abs_diff(375) < 5);
    rig.make_ready();
    assert!(rig.lit_ms().abs_diff(1_000) < 5);
    rig.enable();
    assert!(rig.lit_ms().abs_diff(1_750) < 5);
    rig.close(Contact::Run);
    rig.run_ms(100);
    assert_eq!(rig.lit_ms(), 2_000);
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
