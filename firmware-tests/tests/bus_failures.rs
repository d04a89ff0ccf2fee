//! The bus fails: nobody acknowledges, bus-off, a receive FIFO overruns.

use drive_sim::{ControllerState, ErrorState, FrameMatch, NodeId};
use firmware_tests::rig::MS;
use firmware_tests::scenario::is_set_point_frame;
use firmware_tests::{Contact, Rig, fault, rig};

fn moving(image: &str, axes: i32) -> Rig {
    let mut rig = Rig::with_numbered_drives(rig::image(image), axes);
    rig.bring_up();
    rig
}

fn set_connected(rig: &mut Rig, connected: bool) {
    let mut nodes: Vec<NodeId> = rig
        .drives()
        .iter()
        .map(|drive| rig.wire().node_of(*drive))
        .collect();
    nodes.push(rig.stranger());
    for node in nodes {
        rig.wire_mut().bus_mut().set_connected(node, connected);
    }
}

/// Nothing moves by itself; after enable was released and made active again, everything does, and the sums are equal.
fn comes_back_on_command(rig: &mut Rig) {
    let (from_ns, before) = (rig.board().soc().now_ns(), rig.commanded_counts());
    rig.run_ms(2_000);
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "moved by itself");
    assert_eq!(rig.commanded_counts(), before);
    for contact in [Contact::Run, Contact::Enable] {
        rig.open(contact);
    }
    rig.run_ms(500);
    rig.enable();
    rig.close(Contact::Run);
    assert!(rig.run_until_logged("the motion starts", 100));
    let started = rig.logged_counts("the motion starts").unwrap();
    assert_eq!(
        started,
        rig.commanded_counts(),
        "anchored where the drives stand"
    );
}

#[test]
fn without_acknowledge_old_set_points_are_thrown_away_and_nothing_moves_later() {
    let mut rig = moving("axes-8", 8);
    set_connected(&mut rig, false);
    rig.run_ms(100);
    assert!(rig.has_logged("nobody acknowledges"));
    assert!(rig.has_logged("no set-point got out"));
    rig.run_ms(2_000);
    let reconnected_ns = rig.board().soc().now_ns();
    set_connected(&mut rig, true);
    rig.run_ms(2_000);
    assert_eq!(rig.set_points_since(reconnected_ns).count(), 0);
    comes_back_on_command(&mut rig);
}

#[test]
fn all_drives_unplugged_for_a_second_in_motion_are_a_fault_and_no_large_step_afterwards() {
    // The step that the configuration of this image allows.
    const MAX_STEP: u32 = 200;
    for out_ms in [1_000, 24, 21, 19, 12] {
        let mut rig = moving("axes-8", 8);
        rig.run_ms(20);
        let unplugged_ns = rig.board().soc().now_ns();
        set_connected(&mut rig, false);
        rig.run_ms(out_ms);
        let plugged_ns = rig.board().soc().now_ns();
        set_connected(&mut rig, true);
        rig.run_ms(2_000);
        assert!(
            rig.largest_step_since(unplugged_ns) <= MAX_STEP,
            "{out_ms} ms: {}",
            rig.largest_step_since(unplugged_ns)
        );
        if out_ms < 20 {
            assert!(
                !rig.has_logged("no set-point got out"),
                "{out_ms} ms are no outage"
            );
            continue;
        }
        assert!(rig.has_logged("no set-point got out"), "{out_ms} ms");
        // What was in the first mailbox may go out when the bus is back before it is stale.
        assert!(
            rig.set_points_since(plugged_ns).count() <= 1,
            "{out_ms} ms: {}",
            rig.set_points_since(plugged_ns).count()
        );
        comes_back_on_command(&mut rig);
    }
}

#[test]
fn drives_that_are_switched_on_after_the_board_are_found_on_command() {
    let mut rig = Rig::with_numbered_drives(rig::image("shipped"), 2);
    set_connected(&mut rig, false);
    rig.close(Contact::Stop);
    rig.run_ms(3_000);
    assert!(rig.has_logged("nobody acknowledges"));
    set_connected(&mut rig, true);
    rig.run_ms(2_000);
    assert_eq!(rig.set_points_since(0).count(), 0);
    rig.close(Contact::Enable);
    rig.run_ms(2_000);
    assert!(rig.are_enabled());
    assert!(
        rig.set_points_since(0).count() > 0,
        "{:#?}",
        rig.board().log()
    );
}

#[test]
fn bus_off_stops_everything_and_comes_back_only_on_command() {
    let mut rig = moving("axes-8", 8);
    let node = rig.board().soc().can.node();
    let errors = FrameMatch::sent_by(node);
    rig.wire_mut()
        .bus_mut()
        .faults_mut()
        .corrupt_next(errors, 32, 20);
    rig.run_ms(20);
    assert!(rig.has_logged("bus: off"), "{:#?}", rig.board().log());
    assert!(rig.run_until_logged("bus: works again", 100) || rig.has_logged("bus: works again"));
    comes_back_on_command(&mut rig);
}

/// A machine in motion that has just gone bus-off with three set-points in its mailboxes; the error frames end with it. A poll may be
/// among them instead, so it is tried in one cycle after the other.
fn off_with_three_set_points(moving: impl Fn() -> Rig) -> Rig {
    for delay_ms in 0..40 {
        let mut rig = moving();
        rig.run_ms(delay_ms);
        go_off(&mut rig);
        let waiting = rig.board().soc().can.waiting();
        if waiting.len() == 3 && waiting.iter().all(is_set_point_frame) {
            return rig;
        }
    }
    panic!("there was always a poll among them");
}

fn go_off(rig: &mut Rig) {
    let node = rig.board().soc().can.node();
    // Bus-off is the 32nd error, and a cycle has passed by then: its set-points have filled the mailboxes.
    rig.wire_mut()
        .bus_mut()
        .faults_mut()
        .corrupt_next(FrameMatch::sent_by(node), 32, 20);
    let off = ControllerState::On(ErrorState::BusOff);
    for _ in 0..20_000 {
        if rig.wire().bus().controller(node).state() == off {
            return;
        }
        rig.run_us(1);
    }
    panic!("the controller did not go bus-off");
}

#[test]
fn three_set_points_that_wait_when_the_bus_goes_off_never_go_out() {
    for (image, axes) in [("axes-8", 8), ("misbehaving", 2)] {
        let mut rig = off_with_three_set_points(|| moving(image, axes));
        let off_ns = rig.board().soc().now_ns();
        rig.run_ms(100);
        assert!(rig.has_logged("bus: off"), "{:#?}", rig.board().log());
        assert!(
            rig.has_logged("bus: works again"),
            "{:#?}",
            rig.board().log()
        );
        assert!(rig.has_logged("bus: works"), "{:#?}", rig.board().log());
        assert_eq!(rig.set_points_since(off_ns).count(), 0, "{image}");
        comes_back_on_command(&mut rig);
    }
}

#[test]
fn a_recovery_that_keeps_them_is_noticed() {
    let mut rig = off_with_three_set_points(|| {
        let mut rig = Rig::with_numbered_drives(rig::image("misbehaving"), 2);
        rig.put_back(fault::KEEP_OLD_FRAMES);
        rig.bring_up();
        rig
    });
    let off_ns = rig.board().soc().now_ns();
    rig.run_ms(100);
    assert_eq!(rig.set_points_since(off_ns).count(), 3);
}

#[test]
fn a_controller_that_does_not_give_them_up_is_reset() {
    let mut rig = off_with_three_set_points(|| {
        let mut rig = moving("axes-8", 8);
        rig.board_mut().soc_mut().can.keep_frames(true);
        rig
    });
    let off_ns = rig.board().soc().now_ns();
    rig.run_ms(100);
    assert!(!rig.has_logged("bus: works again"));
    rig.run_ms(200);
    assert!(
        rig.has_logged("bus: works again"),
        "{:#?}",
        rig.board().log()
    );
    assert_eq!(rig.set_points_since(off_ns).count(), 0);
    rig.board_mut().soc_mut().can.keep_frames(false);
    comes_back_on_command(&mut rig);
}

#[test]
fn every_error_on_the_bus_is_counted() {
    let mut rig = moving("axes-8", 8);
    assert!(rig.run_until_logged(" cycles, ", 1_100));
    let node = rig.board().soc().can.node();
    // Fewer than an error-passive controller has seen; they come one after the other, several in a cycle.
    rig.wire_mut()
        .bus_mut()
        .faults_mut()
        .corrupt_next(FrameMatch::sent_by(node), 12, 20);
    assert!(rig.run_until_logged(" cycles, ", 1_100));
    assert_eq!(rig.statistic("bus errors"), Some(12));
}

#[test]
fn an_overrun_of_the_receive_fifo_is_reported() {
    let mut rig = moving("misbehaving", 2);
    // The firmware looks at nothing for two milliseconds, in which more replies come than a FIFO holds.
    rig.board_mut().poke("MISBEHAVE", 5);
    rig.run_ms(1);
    for id in 0x100..0x108_u16 {
        let id = embedded_can::StandardId::new(id).unwrap();
        let frame: drive_sim::Frame = embedded_can::Frame::new(id, &[0]).unwrap();
        rig.send(&frame);
    }
    rig.run_ms(20);
    assert!(rig.board().soc().can.overruns() > 0);
    assert!(
        rig.has_logged("bus: error: Overrun"),
        "{:#?}",
        rig.board().log()
    );
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(10);
    assert!(
        rig.set_points_since(from_ns).count() >= 18,
        "an overrun is no reason to stop"
    );
}

#[test]
fn frames_of_others_are_reported_and_change_nothing() {
    let mut rig = moving("shipped", 2);
    let id = embedded_can::ExtendedId::new(0x03C).unwrap();
    let extended: drive_sim::Frame = embedded_can::Frame::new(id, &[1, 2]).unwrap();
    rig.send(&extended);
    rig.run_ms(5);
    assert_eq!(rig.board().soc().can.unfiltered(), 1);
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(10);
    assert!(rig.set_points_since(from_ns + MS).count() >= 16);
}
