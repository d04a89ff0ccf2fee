//! Properties of the bus under arbitrary traffic and faults.

use drive_sim::{
    Attempt, AttemptOutcome, BitRate, Bus, ControllerConfig, FaultModel, Frame, LogMode, NoFaults,
    NodeId, Outage, OutageKind, Outcome, Record, TxOrder, wire,
};
use embedded_can::{ExtendedId, Frame as _, Id, StandardId, nb::Can};
use proptest::prelude::*;

const NODES: usize = 4;

/// Time for every frame to go out, retries included.
const DRAIN_NS: u64 = 1_000_000_000;

/// Hand `frame` to `node` after `pause_ns`.
#[derive(Debug, Clone)]
struct Request {
    pause_ns: u64,
    node: usize,
    frame: Frame,
}

/// Frames of different nodes never share an identifier, so that they cannot merge or collide.
fn requests() -> impl Strategy<Value = Vec<Request>> {
    let data = prop::collection::vec(any::<u8>(), 0..=8);
    let request = (
        0..200_000_u64,
        0..NODES,
        0..0x1FF_u16,
        any::<bool>(),
        any::<bool>(),
        data,
    );
    let request = request.prop_map(|(pause_ns, node, id, is_extended, is_remote, data)| {
        let base = id << 2 | node as u16;
        let id = if is_extended {
            Id::Extended(ExtendedId::new(u32::from(base) << 18 | 0x2AAAA).unwrap())
        } else {
            Id::Standard(StandardId::new(base).unwrap())
        };
        let frame = if is_remote {
            Frame::new_remote(id, data.len())
        } else {
            Frame::new(id, &data)
        };
        Request {
            pause_ns,
            node,
            frame: frame.unwrap(),
        }
    });
    prop::collection::vec(request, 1..60)
}

/// Plays `requests` with an arbitrary grid of stops in between and returns all that each node received.
fn play<F: FaultModel>(bus: &mut Bus<F>, nodes: &[NodeId], requests: &[Request]) {
    for request in requests {
        bus.advance_to(bus.now_ns() + request.pause_ns);
        let _ = bus.port(nodes[request.node]).transmit(&request.frame);
    }
    bus.advance_to(bus.now_ns() + DRAIN_NS);
}

fn received<F: FaultModel>(bus: &mut Bus<F>, node: NodeId) -> Vec<Frame> {
    std::iter::from_fn(|| bus.port(node).receive().ok()).collect()
}

fn device_bus<F: FaultModel>(faults: F) -> (Bus<F>, Vec<NodeId>) {
    let mut bus = Bus::with_faults(BitRate::Kbit500, faults);
    bus.set_log(LogMode::Full);
    let nodes = (0..NODES)
        .map(|_| bus.add_node(ControllerConfig::device()))
        .collect();
    (bus, nodes)
}

fn records<F: FaultModel>(bus: &Bus<F>) -> Vec<Record> {
    bus.log().iter().copied().collect()
}

fn never_overlap(records: &[Record]) -> bool {
    records
        .iter()
        .all(|r| r.start_ns < r.end_ns && r.end_ns < r.free_ns)
        && records.windows(2).all(|w| w[0].free_ns <= w[1].start_ns)
}

/// Decides by a fixed list that repeats, which an arbitrary test case supplies.
struct Pattern {
    outcomes: Vec<AttemptOutcome>,
    next: usize,
}

impl FaultModel for Pattern {
    fn on_attempt(&mut self, _attempt: &Attempt) -> AttemptOutcome {
        self.next += 1;
        self.outcomes[self.next % self.outcomes.len()]
    }
}

/// At least every third attempt succeeds, so that nobody becomes bus-off.
fn patterns() -> impl Strategy<Value = Vec<AttemptOutcome>> {
    let faulty = prop_oneof![
        3 => Just(AttemptOutcome::Intact),
        1 => (1..120_u32).prop_map(|at_bit| AttemptOutcome::BitError { at_bit }),
        1 => Just(AttemptOutcome::EofError),
    ];
    prop::collection::vec(faulty, 1..8).prop_map(|faulty| {
        let intact = [AttemptOutcome::Intact; 12];
        faulty
            .into_iter()
            .flat_map(|outcome| [outcome].into_iter().chain(intact))
            .collect()
    })
}

proptest! {
    #[test]
    fn without_faults_nothing_is_lost_or_doubled_and_order_is_kept(requests in requests()) {
        let (mut bus, nodes) = device_bus(NoFaults);
        play(&mut bus, &nodes, &requests);
        let records = records(&bus);
        prop_assert!(never_overlap(&records));
        prop_assert!(records.iter().all(|record| record.outcome == Outcome::Delivered));
        for (index, node) in nodes.iter().enumerate() {
            let sent: Vec<Frame> = requests.iter().filter(|r| r.node == index).map(|r| r.frame).collect();
            let logged: Vec<Frame> = records.iter().filter(|r| r.node == *node).map(|r| r.frame).collect();
            prop_assert_eq!(sent, logged);
            let of_others: Vec<Frame> = records.iter().filter(|r| r.node != *node).map(|r| r.frame).collect();
            prop_assert_eq!(received(&mut bus, *node), of_others);
        }
    }

    #[test]
    fn frame_holds_the_wire_for_its_length_within_the_bounds(requests in requests()) {
        let (mut bus, nodes) = device_bus(NoFaults);
        play(&mut bus, &nodes, &requests);
        let bit_ns = bus.bit_rate().bit_ns();
        for record in bus.log().iter() {
            let bits = (record.free_ns - record.start_ns) / bit_ns;
            prop_assert!(bits >= u64::from(wire::unstuffed_bits_with_ifs(&record.frame)));
            prop_assert!(bits <= u64::from(wire::worst_bits_with_ifs(&record.frame)));
        }
        let busy_ns: u64 = bus.log().iter().map(|record| record.free_ns - record.start_ns).sum();
        prop_assert_eq!(bus.busy_ns(), busy_ns);
    }

    #[test]
    fn bus_is_never_idle_while_a_frame_waits(requests in requests()) {
        let (mut bus, nodes) = device_bus(NoFaults);
        let mut handed_in = Vec::new();
        for request in &requests {
            bus.advance_to(bus.now_ns() + request.pause_ns);
            handed_in.push(bus.now_ns());
            bus.port(nodes[request.node]).transmit(&request.frame).unwrap();
        }
        bus.advance_to(bus.now_ns() + DRAIN_NS);
        let starts: Vec<u64> = bus.log().iter().map(|r| r.start_ns).collect();
        let mut idle_from_ns = 0;
        for (index, record) in bus.log().iter().enumerate() {
            // The next start is that of the first frame that has not gone out yet, or the end of the frame before.
            prop_assert_eq!(starts[index], handed_in[index].max(idle_from_ns));
            idle_from_ns = record.free_ns;
        }
    }

    #[test]
    fn with_faults_every_frame_arrives_and_only_eof_errors_double(requests in requests(), outcomes in patterns()) {
        let (mut bus, nodes) = device_bus(Pattern { outcomes, next: 0 });
        play(&mut bus, &nodes, &requests);
        let records = records(&bus);
        prop_assert!(never_overlap(&records));
        for (index, node) in nodes.iter().enumerate() {
            let sent = requests.iter().filter(|r| r.node == index).count();
            let delivered = records.iter().filter(|r| r.node == *node && r.outcome == Outcome::Delivered).count();
            prop_assert_eq!(sent, delivered);
            let of_others: Vec<Frame> =
                records.iter().filter(|r| r.node != *node && r.outcome.is_received()).map(|r| r.frame).collect();
            prop_assert_eq!(received(&mut bus, *node), of_others);
        }
    }

    #[test]
    fn stops_on_the_way_change_nothing(requests in requests(), outcomes in patterns(), step_ns in 1_000..50_000_u64) {
        let run = |step_ns: Option<u64>| {
            let (mut bus, nodes) = device_bus(Pattern { outcomes: outcomes.clone(), next: 0 });
            let outage = Outage { kind: OutageKind::Blocked, from_ns: 500_000, until_ns: 900_000 };
            bus.add_outage(outage).unwrap();
            for request in &requests {
                let at_ns = bus.now_ns() + request.pause_ns;
                while let Some(step_ns) = step_ns.filter(|step_ns| bus.now_ns() + step_ns < at_ns) {
                    bus.advance_to(bus.now_ns() + step_ns);
                }
                bus.advance_to(at_ns);
                bus.port(nodes[request.node]).transmit(&request.frame).unwrap();
            }
            bus.advance_to(bus.now_ns() + DRAIN_NS);
            records(&bus)
        };
        prop_assert_eq!(run(None), run(Some(step_ns)));
    }

    #[test]
    fn mailboxes_account_for_every_frame(requests in requests(), by_identifier: bool) {
        let order = if by_identifier { TxOrder::ByIdentifier } else { TxOrder::Fifo };
        let mut bus = Bus::new(BitRate::Kbit125);
        bus.set_log(LogMode::Full);
        let master = bus.add_node(ControllerConfig::bxcan(order));
        let listener = bus.add_node(ControllerConfig::device());
        let (mut stored, mut displaced, mut refused) = (0, 0, 0);
        for request in &requests {
            bus.advance_to(bus.now_ns() + request.pause_ns);
            match bus.port(master).transmit(&request.frame) {
                Ok(None) => stored += 1,
                Ok(Some(_)) => displaced += 1,
                Err(nb::Error::WouldBlock) => refused += 1,
                Err(nb::Error::Other(error)) => prop_assert!(false, "{}", error),
            }
        }
        bus.advance_to(bus.now_ns() + DRAIN_NS);
        prop_assert_eq!(received(&mut bus, listener).len(), stored);
        prop_assert_eq!(stored + displaced + refused, requests.len());
        prop_assert!(by_identifier || displaced == 0);
    }
}
