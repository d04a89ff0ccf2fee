//! What ends the motion: the stop circuit, a drive in alarm, a drive that is lost.

use drive_sim::{DeviceId, Record};
use dyn_can::Alarm;
use embedded_can::{Frame as _, Id};
use firmware_tests::chip::Controller;
use firmware_tests::rig::MS;
use firmware_tests::{Contact, Rig, fault, rig};

const AXES: i32 = 8;
/// Set-points that still go out when the order to stop comes: bxCAN gives back what waits in its mailboxes, all but the frame that goes
/// next; FDCAN cannot.
fn on_their_way() -> usize {
    match rig::chip().controller {
        Controller::BxCan => 1,
        Controller::FdCan => 3,
    }
}

fn moving() -> Rig {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), AXES);
    rig.bring_up();
    rig
}

fn devices(rig: &Rig) -> Vec<DeviceId> {
    rig.drives().to_vec()
}

/// Enable alone brings nothing back; released and made active again it does.
fn comes_back_on_command(rig: &mut Rig) {
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "moved by itself");
    for contact in [Contact::Run, Contact::Enable] {
        rig.open(contact);
    }
    rig.run_ms(500);
    rig.enable();
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(10);
    assert!(rig.set_points_since(from_ns).count() >= 9 * AXES as usize);
}

#[test]
fn the_stop_circuit_ends_all_set_points_in_the_same_cycle_and_disables_later() {
    let mut rig = moving();
    rig.open(Contact::Stop);
    let opened_ns = rig.board().soc().now_ns();
    rig.run_ms(2);
    // The pin is looked at once a cycle: the one under way is the last.
    assert_eq!(rig.set_points_since(opened_ns + MS).count(), 0);
    assert!(
        rig.servos().all(|drive| drive.is_enabled()),
        "the drives must hold to stop the motors"
    );
    rig.run_ms(600);
    assert!(rig.servos().all(|drive| !drive.is_enabled()));
    rig.close(Contact::Stop);
    comes_back_on_command(&mut rig);
}

/// The drive goes into alarm; returns when its alarm frame is on the wire, whole, and how many set-points were sent behind it.
fn behind_an_alarm(rig: &mut Rig) -> (u64, usize) {
    let drive = devices(rig)[3];
    let raised_ns = rig.board().soc().now_ns();
    rig.servo_mut(drive)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.run_ms(3);
    let alarm_ns = rig
        .wire()
        .bus()
        .log()
        .iter()
        .find(|record| record.start_ns >= raised_ns && record.frame.to_string().starts_with("09D#"))
        .map(|record| record.end_ns)
        .expect("the alarm frame of drive 4 is on the wire");
    (alarm_ns, rig.set_points_since(alarm_ns).count())
}

#[test]
fn an_alarm_ends_the_set_points_of_all_axes_in_the_same_cycle() {
    let mut rig = moving();
    let (alarm_ns, _) = behind_an_alarm(&mut rig);
    assert_eq!(rig.set_points_since(alarm_ns + MS).count(), 0);
    assert!(
        rig.run_until_logged("alarm, its shaft is free", 20)
            || rig.has_logged("alarm, its shaft is free")
    );
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
}

/// What was taken back does not count as sent, either: the other drives hold where the master believes them to be.
#[test]
fn set_points_are_taken_back_whenever_in_the_cycle_the_alarm_comes() {
    let mut most = 0;
    for delay_us in (0..1_000).step_by(53) {
        let mut rig = moving();
        rig.run_us(delay_us);
        let (_, sent) = behind_an_alarm(&mut rig);
        assert!(
            sent <= on_their_way(),
            "{delay_us} us: {sent} behind the alarm"
        );
        most = most.max(sent);
        rig.run_ms(600);
        assert!(rig.has_logged("alarm, its shaft is free"));
        assert!(
            !rig.has_logged("counts at rest, as after"),
            "{delay_us} us: {:#?}",
            rig.board().log()
        );
    }
    assert!(most > 0, "no alarm came while set-points were waiting");
}

/// Off within 0.7 s, and nothing brings it back but the inputs.
fn goes_off_and_stays_off(mut rig: Rig, moved_from_ns: u64, what: &str) {
    rig.run_ms(700);
    assert!(!rig.are_enabled(), "{what}: {:#?}", rig.board().log());
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(200);
    assert!(!rig.are_enabled(), "{what}");
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "{what}");
    assert_eq!(rig.largest_step_since(moved_from_ns), 0, "{what}");
}

#[test]
fn releasing_enable_disables_drives_that_are_not_identified_yet() {
    // The drives are asked for the first time 150 ms after power-on.
    for released_ms in [70, 100, 140, 150, 152, 155, 160, 165, 170, 180] {
        let mut rig = Rig::with_numbered_drives(rig::image("shipped"), 2);
        rig.close(Contact::Stop);
        rig.run_ms(42);
        rig.close(Contact::Enable);
        rig.run_ms(released_ms - 42);
        rig.open(Contact::Enable);
        goes_off_and_stays_off(rig, 0, &format!("released after {released_ms} ms"));
    }
}

#[test]
fn the_stop_circuit_counts_before_the_drives_are_identified() {
    for opened_ms in [70, 140, 151, 158, 170] {
        let mut rig = Rig::with_numbered_drives(rig::image("shipped"), 2);
        for contact in [Contact::Stop, Contact::Run] {
            rig.close(contact);
        }
        rig.run_ms(opened_ms);
        rig.open(Contact::Stop);
        goes_off_and_stays_off(rig, 0, &format!("opened after {opened_ms} ms"));
    }
}

/// After enable was closed: just believed, waiting for standstill, anchoring, enabling, confirmed, streaming.
const ENABLING_MS: [u64; 8] = [21, 90, 172, 173, 174, 175, 176, 190];

#[test]
fn both_ways_to_stop_count_at_every_moment_of_enabling() {
    for contact in [Contact::Stop, Contact::Enable] {
        for found_on in [true, false] {
            for delay_ms in ENABLING_MS {
                let mut rig = Rig::with_numbered_drives(rig::image("shipped"), 2);
                if !found_on {
                    // The circuit is open for longer than the firmware lets the motors stop.
                    rig.run_ms(650);
                    assert!(!rig.are_enabled());
                }
                rig.make_ready();
                rig.close(Contact::Enable);
                let from_ns = rig.board().soc().now_ns();
                rig.run_ms(delay_ms);
                rig.open(contact);
                let what = format!("{contact:?} opened {delay_ms} ms after enable, {found_on}");
                goes_off_and_stays_off(rig, from_ns, &what);
            }
        }
    }
}

#[test]
fn a_disable_command_that_a_drive_does_not_confirm_is_repeated_logged_and_shown() {
    let mut rig = moving();
    let drive = devices(&rig)[7];
    rig.servo_mut(drive).faults_mut().leave_bus();
    rig.open(Contact::Enable);
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert!(
        rig.has_logged("the drive may still have power"),
        "{:#?}",
        rig.board().log()
    );
    assert_eq!(rig.flashes_ms(), UNCONFIRMED_MS);
    let repeated = rig.switches_since(from_ns + 1_000 * MS).count();
    assert!((10..=24).contains(&repeated), "{repeated} in four seconds");
    assert!(rig.servo(drive).is_enabled());
    rig.servo_mut(drive).faults_mut().wake();
    rig.run_ms(500);
    assert!(!rig.are_enabled());
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(
        rig.switches_since(from_ns).count(),
        0,
        "repeated although it was confirmed"
    );
}

/// Flashes of the LED: three eighths and one eighth of a second.
const UNCONFIRMED_MS: [usize; 2] = [125, 375];

/// The drive that a frame is for: the upper bits of its identifier.
fn drive_of(record: &Record) -> Option<u16> {
    match record.frame.id() {
        Id::Standard(id) => Some(id.as_raw() >> 5),
        Id::Extended(_) => None,
    }
}

/// Every drive in motion loses the bus, and then enable is released.
fn nobody_confirms(rig: &mut Rig) {
    rig.bring_up();
    for drive in devices(rig) {
        rig.servo_mut(drive).faults_mut().leave_bus();
    }
    rig.open(Contact::Enable);
    rig.run_ms(1_000);
}

#[test]
fn a_disable_command_that_no_drive_confirms_is_repeated_to_each_logged_and_shown() {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), AXES);
    nobody_confirms(&mut rig);
    let log = rig.board().log().iter();
    let unconfirmed = log.filter(|line| line.contains("the drive may still have power"));
    assert!(
        unconfirmed.count() >= AXES as usize,
        "{:#?}",
        rig.board().log()
    );
    let from_ns = rig.board().soc().now_ns();
    assert_eq!(rig.flashes_ms(), UNCONFIRMED_MS);
    for id in 1..=AXES as u16 {
        let commands = rig.switches_since(from_ns);
        let to_it = commands.filter(|record| drive_of(record) == Some(id));
        assert!(to_it.count() >= 3, "drive {id}");
    }
    for drive in devices(&rig) {
        rig.servo_mut(drive).faults_mut().wake();
    }
    rig.run_ms(1_000);
    assert!(!rig.are_enabled(), "{:#?}", rig.board().log());
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(rig.switches_since(from_ns).count(), 0);
}

#[test]
fn a_board_that_does_not_show_it_is_noticed() {
    let mut rig = Rig::with_numbered_drives(rig::image("misbehaving"), 2);
    rig.put_back(fault::HIDE_UNCONFIRMED);
    nobody_confirms(&mut rig);
    assert_ne!(rig.flashes_ms(), UNCONFIRMED_MS);
}

#[test]
fn a_drive_that_comes_up_on_while_the_stop_circuit_is_open_is_disabled() {
    let mut rig = moving();
    rig.open(Contact::Stop);
    rig.run_ms(800);
    assert!(!rig.are_enabled());
    let drive = devices(&rig)[2];
    rig.servo_mut(drive).faults_mut().reboot();
    rig.run_ms(1_500);
    assert!(!rig.are_enabled(), "{:#?}", rig.board().log());
}

#[test]
fn a_lost_drive_ramps_the_others_down_in_step() {
    let mut rig = moving();
    let drive = devices(&rig)[7];
    rig.run_ms(50);
    rig.servo_mut(drive).faults_mut().leave_bus();
    rig.run_ms(500);
    assert!(rig.has_logged("no answer: check power"));
    assert!(rig.has_logged("RampingDown"));
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(100);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    let counts = rig.commanded_counts();
    assert!(
        counts[..7].windows(2).all(|pair| pair[0] == pair[1]),
        "{counts:?}"
    );
    rig.servo_mut(drive).faults_mut().wake();
    comes_back_on_command(&mut rig);
}
