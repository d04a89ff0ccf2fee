//! The response time analysis against the simulated bus: no frame takes longer than its bound.

use std::collections::VecDeque;

use can_motion::plan::analysis::{Message, Rules, response};
use can_motion::plan::wire::worst_bits;
use drive_sim::{BitRate, Bus, ControllerConfig, Frame, LogMode, NodeId, Outcome};
use embedded_can::nb::Can;
use embedded_can::{Frame as _, StandardId};
use proptest::prelude::*;

/// One bit at 1 Mbit/s.
const BIT_NS: u64 = 1_000;
const SIMULATED_BITS: u64 = 8_000;

const RULES: Rules = Rules {
    error_interval_bits: None,
    horizon_bits: 60_000,
};

/// Frames of one message: its traffic, and how long each release takes as a share of the jitter, in quarters.
#[derive(Debug, Clone)]
struct Stream {
    ids: Vec<u16>,
    /// Frames that arrive together.
    count: usize,
    payload: Vec<u8>,
    period_bits: u32,
    jitter_bits: u32,
    first_bits: u64,
    delays: Vec<u32>,
    extra_bits: u32,
}

impl Stream {
    fn message(&self) -> Message {
        let len = self.payload.len() as u8;
        let bits = self.ids.iter().map(|&id| worst_bits(id, len)).max();
        let first_id = *self.ids.iter().min().expect("an identifier");
        Message {
            first_id,
            last_id: *self.ids.iter().max().expect("an identifier"),
            count: self.count as u32,
            jitter_bits: self.jitter_bits,
            ..Message::periodic(
                first_id,
                u32::from(bits.expect("an identifier")),
                self.period_bits,
            )
        }
    }
}

/// A frame on its way to the controller.
#[derive(Debug)]
struct Release {
    at_bits: u64,
    arrival_bits: u64,
    message: usize,
    id: u16,
}

fn releases(streams: &[Stream]) -> Vec<Release> {
    let mut releases = Vec::new();
    for (message, stream) in streams.iter().enumerate() {
        let (mut arrival_bits, mut not_before) = (stream.first_bits, 0);
        let mut delays = stream.delays.iter().cycle();
        while arrival_bits < SIMULATED_BITS {
            let delay_bits = stream.jitter_bits * delays.next().expect("a delay") / 4;
            // Frames of one message are released in the order in which they arrive.
            not_before = (arrival_bits + u64::from(delay_bits)).max(not_before);
            for place in 0..stream.count {
                releases.push(Release {
                    at_bits: not_before,
                    arrival_bits,
                    message,
                    id: stream.ids[place % stream.ids.len()],
                });
            }
            arrival_bits += u64::from(stream.period_bits + stream.extra_bits);
        }
    }
    releases.sort_by_key(|release| release.at_bits);
    releases
}

/// The only sender of an identifier, and the frames that it was handed: their message and arrival.
struct Sender {
    id: u16,
    node: NodeId,
    sent: VecDeque<(usize, u64)>,
}

/// A node for each identifier, and one that listens.
struct Nodes {
    bus: Bus,
    senders: Vec<Sender>,
}

impl Nodes {
    fn new(streams: &[Stream]) -> Self {
        let mut bus = Bus::new(BitRate::Kbit1000);
        bus.set_log(LogMode::Full);
        bus.add_node(ControllerConfig::device());
        let ids = streams.iter().flat_map(|stream| &stream.ids);
        let senders = ids
            .map(|&id| Sender {
                id,
                node: bus.add_node(ControllerConfig::device()),
                sent: VecDeque::new(),
            })
            .collect();
        Self { bus, senders }
    }

    fn send(&mut self, release: &Release, payload: &[u8]) {
        self.bus.advance_to(release.at_bits * BIT_NS);
        let id = StandardId::new(release.id).expect("11 bits");
        let frame = Frame::new(id, payload).expect("at most 8 bytes");
        let mut senders = self.senders.iter_mut();
        let sender = senders
            .find(|sender| sender.id == release.id)
            .expect("a sender for each identifier");
        self.bus
            .port(sender.node)
            .transmit(&frame)
            .expect("an unbounded queue");
        sender
            .sent
            .push_back((release.message, release.arrival_bits));
    }

    /// Longest response of each message, from arrival to the end of the interframe space.
    fn longest(mut self, messages: usize) -> Vec<u64> {
        self.bus.advance_to(100 * SIMULATED_BITS * BIT_NS);
        let mut longest = vec![0; messages];
        for record in self.bus.log_mut().drain() {
            assert_eq!(record.outcome, Outcome::Delivered);
            let mut senders = self.senders.iter_mut();
            let sender = senders.find(|sender| sender.node == record.node);
            let sent = sender.and_then(|sender| sender.sent.pop_front());
            let (message, arrival_bits) = sent.expect("a frame that was handed over");
            longest[message] = longest[message].max(record.free_ns / BIT_NS - arrival_bits);
        }
        assert!(self.senders.iter().all(|sender| sender.sent.is_empty()));
        longest
    }
}

/// Streams with identifiers of their own, as on a bus that works.
fn streams() -> impl Strategy<Value = Vec<Stream>> {
    let ids = proptest::sample::subsequence((0..2_048_u16).collect::<Vec<_>>(), 24);
    let shapes = proptest::collection::vec(shape(), 1..8);
    (ids.prop_shuffle(), shapes).prop_map(|(mut ids, mut streams)| {
        for stream in &mut streams {
            let own = stream.ids.len();
            stream.ids = ids.split_off(ids.len() - own);
        }
        streams
    })
}

/// A stream with the number of its identifiers, but not yet the identifiers.
fn shape() -> impl Strategy<Value = Stream> {
    let payload = prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..=8),
        proptest::collection::vec(prop_oneof![Just(0), Just(0xFF), Just(0x0F)], 0..=8),
    ];
    let first_bits = prop_oneof![3 => Just(1), 1 => 0..500_u64];
    // Often the worst: the first release as late as can be, the others at once.
    let delays = prop_oneof![
        Just(vec![4, 0, 0, 0, 0, 0, 0, 0]),
        proptest::collection::vec(0..=4_u32, 1..6)
    ];
    (
        (1..=3_usize, any::<bool>(), payload, 300..2_500_u32),
        (prop_oneof![Just(0), 1..2_000_u32], first_bits, delays),
        prop_oneof![3 => Just(0), 1 => 0..300_u32],
    )
        .prop_map(
            |(
                (count, is_one_id, payload, period_bits),
                (jitter_bits, first_bits, delays),
                extra_bits,
            )| Stream {
                ids: vec![0; if is_one_id { 1 } else { count }],
                count,
                payload,
                period_bits,
                jitter_bits,
                first_bits,
                delays,
                extra_bits,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn nothing_takes_longer_than_its_bound(streams in streams()) {
        let mut nodes = Nodes::new(&streams);
        for release in releases(&streams) {
            nodes.send(&release, &streams[release.message].payload);
        }
        let messages: Vec<Message> = streams.iter().map(Stream::message).collect();
        for (index, observed) in nodes.longest(messages.len()).into_iter().enumerate() {
            let mut others = messages.clone();
            let message = others.remove(index);
            if let Some(bound) = response(&message, &others, &RULES).bits {
                prop_assert!(observed <= u64::from(bound), "{}: {} > {} of {:?}", index, observed, bound, messages);
            }
        }
    }
}

/// A bound that is never reached could be anything: here it is reached, up to the bit that a less urgent frame must be
/// earlier.
#[test]
fn the_bound_is_reached() {
    let stream = |id, first_bits| Stream {
        ids: vec![id],
        count: 1,
        payload: vec![],
        period_bits: 1_000,
        jitter_bits: 0,
        first_bits,
        delays: vec![0],
        extra_bits: 0,
    };
    let streams = [stream(0x111, 1), stream(0x222, 1), stream(0x333, 0)];
    let mut nodes = Nodes::new(&streams);
    for release in releases(&streams) {
        nodes.send(&release, &[]);
    }
    let messages: Vec<Message> = streams.iter().map(Stream::message).collect();
    let bound = response(&messages[1], &[messages[0], messages[2]], &RULES);
    let observed = nodes.longest(3)[1];
    assert_eq!(Some(observed + 1), bound.bits.map(u64::from));
}
