//! What the link is told, and what is kept, while the bus, the supply of the drives or the flash fails.

mod orders;

use board_link::WhenDry;
use board_link::host::Incoming;
use board_link::message::{Answer, BoardState, FaultEntry, Request};
use board_link::segment::StreamPhase;
use board_settings::FaultNumber;
use drive_sim::NodeId;
use dyn_can::Alarm;
use firmware_tests::chip::Controller;
use firmware_tests::flash::Change;
use firmware_tests::host::Host;
use firmware_tests::{Contact, Rig, rig};

/// TIM5, counts microseconds without an end.
const CLOCK_COUNT: u32 = 0x4000_0C24;
/// TIM2, beats once a cycle.
const BEAT_CONTROL: u32 = 0x4000_0000;

/// The supply of the drives is switched off: nobody is on the bus.
fn disconnect_drives(rig: &mut Rig) {
    let drives = rig.drives().iter().map(|drive| rig.wire().node_of(*drive));
    let mut nodes: Vec<NodeId> = drives.collect();
    nodes.push(rig.stranger());
    for node in nodes {
        rig.wire_mut().bus_mut().set_connected(node, false);
    }
}

fn faults(rig: &mut Rig, host: &mut Host) -> Vec<FaultEntry> {
    let read = |index| match host.ask(rig, Request::ReadFault { index }) {
        Ok(Answer::Fault(entry)) => Some(entry),
        _ => None,
    };
    (0..).map_while(read).collect()
}

fn has_code(faults: &[FaultEntry], code: u16) -> bool {
    faults.iter().any(|fault| fault.code == code)
}

/// A board whose bus is held dominant from its start on, with a host.
fn without_bus() -> (Rig, Host) {
    let (mut rig, _) = orders::board();
    rig.hold_dominant(true);
    rig.run_ms(300);
    let mut host = Host::new(&mut rig, 2);
    host.connect(&mut rig);
    (rig, host)
}

#[test]
fn a_stream_begins_at_once_however_long_the_board_had_waited_for_its_bus() {
    let (mut rig, mut host) = without_bus();
    assert_eq!(host.state(&mut rig), BoardState::Off);
    // As if it had waited for 71 minutes: its microseconds, 100 ms before 32 bits of them begin anew.
    rig.board_mut()
        .soc_mut()
        .write(CLOCK_COUNT, 4, u32::MAX - 100_000);
    host.run_ms(&mut rig, 500);
    rig.hold_dominant(false);
    host.run_ms(&mut rig, 2_000);
    let mut host = Host::new(&mut rig, 3);
    host.bring_up(&mut rig);
    let stand = orders::targets(&host);
    host.stream(&mut rig, 1, orders::forth_and_back(&stand), WhenDry::End);
    host.run_ms(&mut rig, 9_000);
    let phases = host.phases(1);
    assert!(phases.ends_with(&[StreamPhase::Complete]), "{phases:?}");
}

#[test]
fn a_board_that_its_watchdog_locked_says_so_and_stores_it_while_its_bus_is_held() {
    let (mut rig, _) = without_bus();
    rig.board_mut().soc_mut().write(BEAT_CONTROL, 4, 0);
    rig.run_ms(3_000);
    let _ = rig.received_serial();
    let mut host = Host::new(&mut rig, 4);
    host.connect(&mut rig);
    assert_eq!(host.state(&mut rig), BoardState::Locked);
    assert!(has_code(
        &faults(&mut rig, &mut host),
        FaultNumber::WATCHDOG
    ));
    host.run_ms(&mut rig, 3_000);
    // What unlocks it does not take away why it was locked.
    rig.cut_power(100, 20_000, 5);
    let _ = rig.received_serial();
    let mut host = Host::new(&mut rig, 9);
    host.connect(&mut rig);
    assert!(has_code(
        &faults(&mut rig, &mut host),
        FaultNumber::WATCHDOG
    ));
}

#[test]
fn drives_without_supply_leave_the_faults_before_in_the_log_and_the_flash_alone() {
    let (mut rig, mut host) = orders::board();
    host.bring_up(&mut rig);
    let third = rig.drives()[2];
    rig.servo_mut(third)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    host.run_ms(&mut rig, 300);
    rig.open(Contact::Enable);
    host.run_ms(&mut rig, 4_000);
    let alarm = faults(&mut rig, &mut host);
    disconnect_drives(&mut rig);
    host.run_ms(&mut rig, 15_000);
    let stored = rig.board().soc().flash.history().len();
    host.run_ms(&mut rig, 30_000);
    let after = faults(&mut rig, &mut host);
    assert!(has_code(&after, FaultNumber::BUS_OFF), "{after:#?}");
    assert!(after.ends_with(&alarm), "{after:#?}");
    assert_eq!(rig.board().soc().flash.history().len(), stored);
}

#[test]
fn an_error_of_the_flash_does_not_stop_what_is_stored_later() {
    let (mut rig, mut host) = orders::board();
    host.connect(&mut rig);
    let now_ns = rig.board().soc().now_ns();
    let log = match rig::chip().controller {
        Controller::BxCan => 0x0800_C000,
        Controller::FdCan => 0x0807_F000,
    };
    // A store that nobody has permitted sets an error.
    let flash = &mut rig.board_mut().soc_mut().flash;
    flash.store(log, 4, 0, 0, now_ns);
    let settings = firmware_tests::orders::settings(3);
    let written = host.write_settings(&mut rig, &settings);
    assert!(written.is_ok(), "{written:?}");
}

#[test]
fn a_host_stays_connected_while_the_log_is_erased_and_a_cut_of_the_supply_is_a_reset() {
    let (mut rig, mut host) = orders::board();
    host.bring_up(&mut rig);
    assert_eq!(host.ask(&mut rig, Request::Disable), Ok(Answer::Done));
    let erases = |rig: &Rig| {
        let history = rig.board().soc().flash.history().iter();
        history
            .filter(|operation| matches!(operation.change, Change::Erase(_)))
            .count()
    };
    let before = erases(&rig);
    // An area of the log has 51 faults, and all axes are of one group.
    for _ in 0..16 {
        let drive = rig.drives()[0];
        rig.servo_mut(drive).faults_mut().leave_bus();
        host.run_ms(&mut rig, 600);
        rig.servo_mut(drive).faults_mut().wake();
        host.run_ms(&mut rig, 300);
        let _ = host.ask(&mut rig, Request::Clear);
        host.run_ms(&mut rig, 300);
    }
    host.run_ms(&mut rig, 20_000);
    assert!(erases(&rig) > before, "nothing was erased");
    let lost = |host: &Host| host.told.contains(&Incoming::Disconnected);
    assert!(!lost(&host));
    // Without a fault since.
    let seen = |host: &Host, is_reset| host.told.contains(&Incoming::Connected { is_reset });
    host.told.clear();
    rig.cut_power(100, 20_000, 1);
    let _ = rig.received_serial();
    host.run_ms(&mut rig, 3_000);
    assert!(seen(&host, true) && !seen(&host, false));
    host.told.clear();
    rig.cut_power(100, 20_000, 2);
    let _ = rig.received_serial();
    host.run_ms(&mut rig, 3_000);
    assert!(seen(&host, true) && !seen(&host, false));
}
