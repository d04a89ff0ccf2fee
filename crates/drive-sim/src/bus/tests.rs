use embedded_can::nb::Can;

use super::*;
use crate::confinement::ErrorState;
use crate::controller::{ControllerError, ControllerState};
use crate::fault::AttemptOutcome;
use crate::frame::Frame;
use crate::frame::tests::{extended, remote, standard};
use crate::log::Outcome;
use crate::mailbox::TxOrder;
use crate::outage::OutageKind;
use crate::port::NotBusOff;
use crate::receive::{AcceptanceFilter, Overrun, RxQueue};
use crate::script::{FrameMatch, ScriptedFaults};

/// 1000 ns a bit.
const BIT_NS: u64 = 1_000;

fn bus_of(nodes: usize) -> (Bus<ScriptedFaults>, Vec<NodeId>) {
    let mut bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
    bus.set_log(LogMode::Full);
    let ids = (0..nodes)
        .map(|_| bus.add_node(ControllerConfig::device()))
        .collect();
    (bus, ids)
}

fn send(bus: &mut Bus<ScriptedFaults>, node: NodeId, frame: Frame) {
    assert_eq!(bus.port(node).transmit(&frame), Ok(None));
}

fn read_all(bus: &mut Bus<ScriptedFaults>, node: NodeId) -> Vec<String> {
    std::iter::from_fn(|| bus.port(node).receive().ok())
        .map(|frame| frame.to_string())
        .collect()
}

fn outcomes(bus: &Bus<ScriptedFaults>) -> Vec<Outcome> {
    bus.log().iter().map(|record| record.outcome).collect()
}

fn frames(bus: &Bus<ScriptedFaults>) -> Vec<String> {
    bus.log()
        .iter()
        .map(|record| record.frame.to_string())
        .collect()
}

fn state(bus: &Bus<ScriptedFaults>, node: NodeId) -> (ControllerState, u16) {
    (bus.controller(node).state(), bus.controller(node).tec())
}

const ACTIVE: ControllerState = ControllerState::On(ErrorState::Active);
const PASSIVE: ControllerState = ControllerState::On(ErrorState::Passive);
const BUS_OFF: ControllerState = ControllerState::On(ErrorState::BusOff);

#[test]
fn frame_arrives_at_the_end_of_eof_and_the_bus_is_idle_three_bits_later() {
    let (mut bus, n) = bus_of(3);
    send(&mut bus, n[0], standard(0x001, &[]));
    send(&mut bus, n[0], standard(0x7EF, &[]));
    bus.advance_to(46_999);
    assert_eq!(
        (
            bus.controller(n[1]).rx_pending(),
            bus.controller(n[0]).is_transmitting()
        ),
        (0, true)
    );
    bus.advance_to(47_000);
    assert_eq!(
        (
            bus.controller(n[1]).rx_pending(),
            bus.controller(n[2]).rx_pending()
        ),
        (1, 1)
    );
    assert_eq!(
        (
            bus.controller(n[0]).rx_pending(),
            bus.controller(n[0]).tx_pending()
        ),
        (0, 1)
    );
    bus.advance_to(1_000_000);
    let times: Vec<_> = bus
        .log()
        .iter()
        .map(|r| (r.start_ns, r.end_ns, r.free_ns))
        .collect();
    assert_eq!(times, [(0, 47_000, 50_000), (50_000, 96_000, 99_000)]);
}

#[test]
fn arbitration_by_identifier_kind_and_format() {
    let (mut bus, n) = bus_of(6);
    let in_order = [
        standard(0x122, &[1]),
        standard(0x123, &[1]),
        remote(0x123, 1),
        extended(0x123 << 18, &[1]),
        standard(0x124, &[1]),
    ];
    for (node, frame) in n.iter().zip(in_order).rev() {
        send(&mut bus, *node, frame);
    }
    bus.advance_to(10_000_000);
    assert_eq!(frames(&bus), in_order.map(|frame| frame.to_string()));
}

#[test]
fn frame_handed_in_during_another_waits_and_then_arbitrates() {
    let (mut bus, n) = bus_of(3);
    send(&mut bus, n[0], standard(0x700, &[]));
    bus.advance_to(10_000);
    send(&mut bus, n[1], standard(0x200, &[]));
    bus.advance_to(20_000);
    send(&mut bus, n[2], standard(0x100, &[]));
    bus.advance_to(1_000_000);
    assert_eq!(frames(&bus), ["700#", "100#", "200#"]);
    assert!(
        bus.log()
            .iter()
            .zip(bus.log().iter().skip(1))
            .all(|(a, b)| a.free_ns == b.start_ns)
    );
}

#[test]
fn next_event_names_the_end_of_the_first_bit_and_of_the_frame() {
    let (mut bus, n) = bus_of(2);
    assert_eq!(bus.next_event_ns(), None);
    bus.advance_to(5_000);
    send(&mut bus, n[0], standard(0x001, &[]));
    assert_eq!(bus.next_event_ns(), Some(6_000));
    bus.advance_to(6_000);
    assert_eq!(bus.next_event_ns(), Some(52_000));
    bus.advance_to(52_000);
    assert_eq!(bus.next_event_ns(), None);
}

#[test]
fn load_counts_frames_with_their_interframe_space() {
    let (mut bus, n) = bus_of(2);
    let mark = bus.load_mark();
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(20_000);
    assert_eq!(bus.busy_ns(), 20_000);
    bus.advance_to(48_000);
    assert_eq!(bus.busy_ns(), 48_000);
    bus.advance_to(100_000);
    assert_eq!((bus.busy_ns(), bus.load_since(&mark)), (50_000, 0.5));
    assert_eq!(bus.load_since(&bus.load_mark()), 0.0);
}

#[test]
fn lonely_node_becomes_error_passive_and_stays() {
    let (mut bus, n) = bus_of(1);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(10_000_000);
    assert_eq!(state(&bus, n[0]), (PASSIVE, 128));
    assert!(
        outcomes(&bus)
            .iter()
            .all(|outcome| *outcome == Outcome::AckError)
    );
    let starts: Vec<u64> = bus.log().iter().map(|r| r.start_ns / BIT_NS).collect();
    // 39 bits to the ACK slot and 23 of error frame; 8 more once it is passive, which it is after the 16th error.
    assert_eq!(
        (
            starts[1] - starts[0],
            starts[15] - starts[14],
            starts[16] - starts[15]
        ),
        (62, 62, 70)
    );

    let late = bus.add_node(ControllerConfig::device());
    bus.advance_to(11_000_000);
    assert_eq!(
        (state(&bus, n[0]), read_all(&mut bus, late).len()),
        ((ACTIVE, 127), 1)
    );
}

#[test]
fn corrupted_frame_is_repeated_and_received_once() {
    let (mut bus, n) = bus_of(3);
    bus.faults_mut()
        .corrupt_next(FrameMatch::sent_by(n[0]), 2, 20);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(1_000_000);
    assert_eq!(
        outcomes(&bus),
        [Outcome::BitError, Outcome::BitError, Outcome::Delivered]
    );
    let starts: Vec<u64> = bus.log().iter().map(|r| r.start_ns / BIT_NS).collect();
    assert_eq!(starts, [0, 43, 86]);
    assert_eq!(
        (state(&bus, n[0]), bus.controller(n[1]).rec()),
        ((ACTIVE, 15), 1)
    );
    assert_eq!(
        (
            read_all(&mut bus, n[1]).len(),
            read_all(&mut bus, n[2]).len()
        ),
        (1, 1)
    );
}

#[test]
fn error_position_behind_the_ack_delimiter_means_the_delimiter() {
    let (mut bus, n) = bus_of(2);
    bus.faults_mut().corrupt_next(FrameMatch::ANY, 1, u32::MAX);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(1_000_000);
    assert_eq!(bus.log().iter().map(|r| r.end_ns).next(), Some(40_000));
}

#[test]
fn error_in_the_last_eof_bit_doubles_the_frame() {
    let (mut bus, n) = bus_of(3);
    bus.faults_mut().duplicate_next(FrameMatch::ANY, 1);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(1_000_000);
    assert_eq!(outcomes(&bus), [Outcome::EofError, Outcome::Delivered]);
    assert_eq!(read_all(&mut bus, n[1]), ["001#", "001#"]);
    assert_eq!(bus.log().iter().map(|r| r.free_ns).next(), Some(70_000));
    assert_eq!(state(&bus, n[0]), (ACTIVE, 7));
}

#[test]
fn dropped_reception_concerns_one_node() {
    let (mut bus, n) = bus_of(3);
    bus.faults_mut().drop_next(n[1], FrameMatch::ANY, 1);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(1_000_000);
    assert_eq!(
        (
            read_all(&mut bus, n[1]).len(),
            read_all(&mut bus, n[2]).len()
        ),
        (0, 1)
    );
    assert_eq!(
        (bus.controller(n[1]).counters().rx_dropped, outcomes(&bus)),
        (1, vec![Outcome::Delivered])
    );
}

#[test]
fn equal_identifiers_with_different_data_collide_sixteen_times() {
    let (mut bus, n) = bus_of(3);
    send(&mut bus, n[0], standard(0x123, &[0x80]));
    send(&mut bus, n[1], standard(0x123, &[0x00]));
    bus.advance_to(10_000_000);
    let mut want = vec![Outcome::Collision; 16];
    want.extend([Outcome::Delivered; 2]);
    assert_eq!(outcomes(&bus), want);
    // Each collision costs 21 bits to the first data bit and 23 of error frame: together about 700.
    assert_eq!(
        bus.log().iter().map(|r| r.start_ns / BIT_NS).nth(16),
        Some(16 * 44 + 8)
    );
    // The dominant bit wins once both are passive; the other one sits that frame out and has one error more.
    assert_eq!(read_all(&mut bus, n[2]), ["123#00", "123#80"]);
    assert_eq!(
        (state(&bus, n[0]).1, state(&bus, n[1]).1),
        (128 + 8 - 1, 127)
    );
    assert_eq!(
        (read_all(&mut bus, n[0]), read_all(&mut bus, n[1])),
        (vec![], vec!["123#80".to_string()])
    );
}

#[test]
fn equal_frames_merge_and_neither_sender_receives_the_other() {
    let (mut bus, n) = bus_of(3);
    send(&mut bus, n[0], standard(0x123, &[7]));
    send(&mut bus, n[1], standard(0x123, &[7]));
    bus.advance_to(1_000_000);
    assert_eq!(
        (outcomes(&bus), bus.log().iter().map(|r| r.senders).next()),
        (vec![Outcome::Delivered], Some(2))
    );
    let tx = |node: NodeId| bus.controller(node).counters().tx_frames;
    assert_eq!((tx(n[0]), tx(n[1])), (1, 1));
    assert_eq!(
        n.iter()
            .map(|node| read_all(&mut bus, *node).len())
            .collect::<Vec<_>>(),
        [0, 0, 1]
    );
}

#[test]
fn merged_frame_needs_a_third_node_to_acknowledge() {
    let (mut bus, n) = bus_of(2);
    send(&mut bus, n[0], standard(0x123, &[7]));
    send(&mut bus, n[1], standard(0x123, &[7]));
    bus.advance_to(10_000_000);
    assert!(
        outcomes(&bus)
            .iter()
            .all(|outcome| *outcome == Outcome::AckError)
    );
    assert_eq!(
        (state(&bus, n[0]), state(&bus, n[1])),
        ((PASSIVE, 128), (PASSIVE, 128))
    );
}

#[test]
fn blocked_bus_keeps_frames_pending() {
    let (mut bus, n) = bus_of(2);
    bus.add_outage(Outage {
        kind: OutageKind::Blocked,
        from_ns: 10_000,
        until_ns: 500_000,
    })
    .unwrap();
    send(&mut bus, n[0], standard(0x001, &[]));
    send(&mut bus, n[0], standard(0x002, &[]));
    bus.advance_to(1_000_000);
    let starts: Vec<u64> = bus.log().iter().map(|r| r.start_ns).collect();
    assert_eq!((starts, state(&bus, n[0])), (vec![0, 500_000], (ACTIVE, 0)));
}

#[test]
fn disturbed_bus_drives_the_sender_to_bus_off() {
    let (mut bus, n) = bus_of(2);
    bus.add_outage(Outage {
        kind: OutageKind::Disturbed,
        from_ns: 10_000,
        until_ns: 5_000_000,
    })
    .unwrap();
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(6_000_000);
    assert_eq!(outcomes(&bus), [Outcome::BitError; 32]);
    assert_eq!(
        bus.log()
            .iter()
            .map(|r| r.end_ns)
            .take(2)
            .collect::<Vec<_>>(),
        [11_000, 36_000]
    );
    assert_eq!(
        (state(&bus, n[0]), bus.controller(n[0]).tx_pending()),
        ((BUS_OFF, 256), 1)
    );
    let refused = bus.port(n[0]).transmit(&standard(1, &[]));
    assert_eq!(
        refused,
        Err(nb::Error::Other(ControllerError::BusOff { tec: 256 }))
    );
}

fn bus_off_at_6_ms() -> (Bus<ScriptedFaults>, Vec<NodeId>) {
    let (mut bus, n) = bus_of(3);
    bus.add_outage(Outage {
        kind: OutageKind::Disturbed,
        from_ns: 0,
        until_ns: 5_000_000,
    })
    .unwrap();
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(6_000_000);
    assert_eq!(state(&bus, n[0]).0, BUS_OFF);
    (bus, n)
}

#[test]
fn recovery_takes_a_command_and_1408_recessive_bits() {
    let (mut bus, n) = bus_off_at_6_ms();
    bus.advance_to(60_000_000);
    assert_eq!(state(&bus, n[0]).0, BUS_OFF);
    bus.port(n[0]).request_recovery().unwrap();
    bus.advance_to(60_500_000);
    bus.port(n[0]).request_recovery().unwrap();
    let end_ns = 60_000_000 + 1408 * BIT_NS;
    assert_eq!(bus.next_event_ns(), Some(end_ns));
    bus.advance_to(end_ns - 1);
    assert_eq!(state(&bus, n[0]).0, BUS_OFF);
    bus.advance_to(end_ns);
    assert_eq!(state(&bus, n[0]), (ACTIVE, 0));
    assert_eq!(
        bus.port(n[0]).request_recovery(),
        Err(NotBusOff { state: ACTIVE })
    );
    // The frame that waited goes out unless it was aborted.
    bus.advance_to(70_000_000);
    assert_eq!(read_all(&mut bus, n[1]), ["001#"]);
}

#[test]
fn traffic_and_outages_slow_recovery_down() {
    let (mut bus, n) = bus_off_at_6_ms();
    bus.port(n[0]).abort_all();
    bus.port(n[0]).request_recovery().unwrap();
    // 100 ms of a dominant bus count nothing.
    bus.add_outage(Outage {
        kind: OutageKind::Blocked,
        from_ns: 6_000_000 + 110 * BIT_NS,
        until_ns: 106_000_000,
    })
    .unwrap();
    bus.advance_to(106_000_000);
    // Ten sequences before the outage; then frames back to back count one each, where 118 sequences of an idle bus would take 1298 bits.
    (0..30).for_each(|_| send(&mut bus, n[1], standard(0x001, &[])));
    bus.advance_to(107_500_000);
    assert_eq!(state(&bus, n[0]).0, BUS_OFF);
    let end_ns = 106_000_000 + (30 * 50 + (118 - 30) * 11) * BIT_NS;
    assert_eq!(bus.next_event_ns(), Some(end_ns));
    bus.advance_to(end_ns);
    assert_eq!(
        (state(&bus, n[0]), bus.controller(n[0]).rx_pending()),
        ((ACTIVE, 0), 0)
    );
}

#[test]
fn sender_switched_off_in_mid_frame_leaves_an_error() {
    let (mut bus, n) = bus_of(2);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(20_000);
    bus.port(n[0]).power_off();
    bus.advance_to(1_000_000);
    assert_eq!(
        (outcomes(&bus), read_all(&mut bus, n[1]).len()),
        (vec![Outcome::Interrupted], 0)
    );
    assert_eq!(bus.controller(n[1]).rec(), 1);
}

#[test]
fn unplugged_receiver_misses_the_frame_and_its_own_stays_pending() {
    let (mut bus, n) = bus_of(3);
    send(&mut bus, n[0], standard(0x001, &[]));
    bus.advance_to(10_000);
    bus.set_connected(n[1], false);
    send(&mut bus, n[1], standard(0x002, &[]));
    bus.advance_to(20_000);
    bus.set_connected(n[1], true);
    bus.set_connected(n[2], false);
    bus.advance_to(49_000);
    // Nobody heard it from the beginning to the end.
    assert_eq!(
        (outcomes(&bus), read_all(&mut bus, n[1]).len()),
        (vec![Outcome::AckError], 0)
    );
    bus.advance_to(1_000_000);
    assert_eq!(
        (read_all(&mut bus, n[1]), read_all(&mut bus, n[0])),
        (vec!["001#".into()], vec!["002#".into()])
    );
}

#[test]
fn filter_keeps_frames_out_but_acknowledges_them() {
    let mut bus = Bus::new(BitRate::Kbit500);
    let sender = bus.add_node(ControllerConfig::device());
    let receiver = bus.add_node(ControllerConfig::device().with_filter(AcceptanceFilter::NONE));
    bus.port(sender).transmit(&standard(0x001, &[])).unwrap();
    bus.advance_to(1_000_000);
    assert_eq!(
        (
            bus.controller(sender).counters().tx_frames,
            bus.controller(receiver).rx_pending()
        ),
        (1, 0)
    );
}

#[test]
fn unread_hardware_fifo_overruns() {
    let mut bus = Bus::new(BitRate::Kbit1000);
    let sender = bus.add_node(ControllerConfig::device());
    let config = ControllerConfig {
        rx: RxQueue::Fifo(Overrun::Lock),
        ..ControllerConfig::bxcan(TxOrder::Fifo)
    };
    let receiver = bus.add_node(config);
    for id in 0..5 {
        bus.port(sender).transmit(&standard(id, &[])).unwrap();
    }
    bus.advance_to(1_000_000);
    assert_eq!(
        (
            bus.controller(receiver).rx_pending(),
            bus.controller(receiver).counters().rx_overruns
        ),
        (3, 2)
    );
}

#[test]
fn frame_on_the_wire_cannot_be_displaced_but_one_about_to_start_can() {
    let mut bus = Bus::new(BitRate::Kbit1000);
    let master = bus.add_node(ControllerConfig::bxcan(TxOrder::ByIdentifier));
    bus.add_node(ControllerConfig::device());
    for id in [0x30, 0x40, 0x50] {
        assert_eq!(bus.port(master).transmit(&standard(id, &[])), Ok(None));
    }
    assert_eq!(
        bus.port(master).transmit(&standard(0x2F, &[])),
        Ok(Some(standard(0x50, &[])))
    );
    bus.advance_to(1);
    for (id, displaced) in [(0x01, 0x40), (0x02, 0x30)] {
        assert_eq!(
            bus.port(master).transmit(&standard(id, &[])),
            Ok(Some(standard(displaced, &[])))
        );
    }
    assert_eq!(
        bus.port(master).transmit(&standard(0x03, &[])),
        Err(nb::Error::WouldBlock)
    );
}

#[test]
fn fault_model_sees_the_number_of_the_attempt() {
    struct Numbers(Vec<u32>);
    impl FaultModel for Numbers {
        fn on_attempt(&mut self, attempt: &crate::Attempt) -> AttemptOutcome {
            self.0.push(attempt.number);
            if attempt.number < 3 {
                AttemptOutcome::BitError { at_bit: 30 }
            } else {
                AttemptOutcome::Intact
            }
        }
    }
    let mut bus = Bus::with_faults(BitRate::Kbit1000, Numbers(Vec::new()));
    let sender = bus.add_node(ControllerConfig::device());
    bus.add_node(ControllerConfig::device());
    bus.port(sender).transmit(&standard(1, &[])).unwrap();
    bus.port(sender).transmit(&standard(2, &[])).unwrap();
    bus.advance_to(1_000_000);
    assert_eq!(bus.faults().0, [1, 2, 3, 1, 2, 3]);
}

#[test]
fn outage_without_end_leaves_no_event() {
    let (mut bus, n) = bus_of(2);
    let forever = Outage {
        kind: OutageKind::Blocked,
        from_ns: 0,
        until_ns: u64::MAX,
    };
    bus.add_outage(forever).unwrap();
    send(&mut bus, n[0], standard(0x001, &[]));
    assert_eq!(bus.next_event_ns(), None);
    bus.advance_to(10_000_000_000);
    assert_eq!((bus.controller(n[0]).tx_pending(), bus.log().len()), (1, 0));
}

#[test]
fn error_passive_node_lets_others_in_between_its_frames() {
    let (mut bus, n) = bus_of(3);
    bus.faults_mut()
        .corrupt_next(FrameMatch::sent_by(n[0]), 17, 20);
    (0..3).for_each(|_| send(&mut bus, n[0], standard(0x001, &[])));
    // The 16th error makes it passive; it then waits 8 bits behind the error frame of the 17th.
    let passive_from_ns = (16 * 43 + 8 + 43) * BIT_NS;
    bus.advance_to(passive_from_ns);
    assert_eq!(state(&bus, n[0]), (PASSIVE, 136));
    send(&mut bus, n[1], standard(0x7EF, &[]));
    bus.advance_to(passive_from_ns + 1_000_000);
    let after: Vec<_> = bus
        .log()
        .iter()
        .skip(17)
        .map(|r| (r.start_ns, r.frame.to_string()))
        .collect();
    assert_eq!(after[0], (passive_from_ns, "7EF#".to_string()));
    // Behind the frame of another node it waits no longer, behind its own it does.
    assert_eq!(
        after[1],
        (passive_from_ns + 49 * BIT_NS, "001#".to_string())
    );
    assert_eq!(after[2].0 - after[1].0, (50 + 8) * BIT_NS);
}
