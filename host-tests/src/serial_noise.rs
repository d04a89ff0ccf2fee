//! Packets in noise: streams of random bytes with packets in them, and an exact statement of what a decoder must find.
//!
//! What is a packet is decided here from the manual alone (section 7.2), byte by byte and for every place in the stream, with
//! the whole stream at hand; the decoder under test sees one byte at a time and must come to the same list.

use std::cell::RefCell;
use std::fmt;

use drive_sim::SplitMix64;
use dyn_serial::{Client, Decoder, Dialect, DriveId, Event, Reply, Request, Timing};

/// How many bytes of what a stream is made of, and what was found in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Bytes of the streams.
    pub bytes: u64,
    /// Intact packets put into the noise.
    pub planted: u64,
    /// Packets found: the planted ones, and noise that happens to be one.
    pub found: u64,
    /// Stray bytes, truncated packets and wrong checksums.
    pub other_events: u64,
}

impl Tally {
    /// Adds another one.
    pub fn add(&mut self, other: Self) {
        self.bytes += other.bytes;
        self.planted += other.planted;
        self.found += other.found;
        self.other_events += other.other_events;
    }
}

/// What a decoder did wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// A packet that is in the stream was not reported, or one that is not in it was: places from the start of the stream.
    Packets {
        /// The first place at which the two lists differ, as the manual has it.
        expected: Option<usize>,
        /// The same, as the decoder has it.
        actual: Option<usize>,
    },
    /// A byte that is in no event, or in two.
    Bytes {
        /// The first place at which the bytes of all events differ from the stream.
        at: usize,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Packets { expected, actual } => write!(
                f,
                "expected a packet at byte {expected:?}, the decoder reported one at {actual:?}"
            ),
            Self::Bytes { at } => write!(f, "byte {at} is lost or in two events"),
        }
    }
}

/// A stream of at least `bytes` random bytes with packets in it, and the places of the intact ones.
pub fn stream(random: &mut SplitMix64, bytes: usize) -> (Vec<u8>, Vec<usize>) {
    let (mut stream, mut planted) = (Vec::with_capacity(bytes + 16), Vec::new());
    while stream.len() < bytes {
        match random.up_to(7) {
            // Without noise in between, two packets are glued together.
            0 | 1 => {
                planted.push(stream.len());
                stream.extend(packet(random));
            }
            2 => stream.extend(damaged(random)),
            3 => {
                let packet = packet(random);
                let length = random.up_to(packet.len() as u64 - 1) as usize;
                stream.extend(&packet[..length]);
            }
            // Start bytes and inner bytes are equally likely.
            _ => {
                let length = random.up_to(12);
                stream.extend((0..length).map(|_| random.next_u64() as u8));
            }
        }
    }
    (stream, planted)
}

/// A packet of any id, code, length and data.
fn packet(random: &mut SplitMix64) -> Vec<u8> {
    let length = random.up_to(3) as u8;
    let mut bytes = vec![random.up_to(127) as u8];
    bytes.push(0x80 | length << 5 | random.up_to(31) as u8);
    bytes.extend((0..=length).map(|_| 0x80 | random.up_to(127) as u8));
    let sum: u32 = bytes.iter().map(|byte| u32::from(*byte)).sum();
    bytes.push(0x80 + (sum % 128) as u8);
    bytes
}

/// A packet with one wrong bit.
fn damaged(random: &mut SplitMix64) -> Vec<u8> {
    let mut packet = packet(random);
    let bit = random.up_to(packet.len() as u64 * 8 - 1) as usize;
    packet[bit / 8] ^= 1 << (bit % 8);
    packet
}

/// Length of the packet at the beginning of `bytes`, if there is one, as the manual has it.
fn packet_len(bytes: &[u8]) -> Option<usize> {
    let (start, second) = (*bytes.first()?, *bytes.get(1)?);
    let length = 4 + usize::from(second / 32 % 4);
    let inner = bytes.get(1..length)?;
    if start >= 128 || inner.iter().any(|byte| *byte < 128) {
        return None;
    }
    let sum: u32 = bytes[..length - 1]
        .iter()
        .map(|byte| u32::from(*byte))
        .sum();
    (u32::from(bytes[length - 1]) == 128 + sum % 128).then_some(length)
}

/// Feeds `stream` to `push`, and compares what it reports with what is in the stream. `unfinished` is what it still holds at
/// the end.
///
/// # Errors
/// [`Fault`] with the first difference.
pub fn check(
    stream: &[u8],
    mut push: impl FnMut(u8) -> Option<Event>,
    unfinished: impl FnOnce() -> Vec<u8>,
) -> Result<Tally, Fault> {
    let mut bytes = Vec::with_capacity(stream.len());
    let mut found = Vec::new();
    let mut other_events = 0;
    for event in stream.iter().filter_map(|byte| push(*byte)) {
        match event {
            Event::Packet(packet) => {
                found.push(bytes.len());
                bytes.extend(packet.as_bytes());
            }
            Event::Stray(byte) => bytes.push(byte),
            Event::Truncated(fragment) => bytes.extend(fragment.as_bytes()),
            Event::Checksum { received, .. } => bytes.extend(received.as_bytes()),
        }
        other_events += u64::from(!matches!(event, Event::Packet(_)));
    }
    bytes.extend(unfinished());
    let expected = (0..stream.len()).filter(|at| packet_len(&stream[*at..]).is_some());
    let expected: Vec<usize> = expected.collect();
    if let Some(at) = first_difference(&expected, &found) {
        return Err(Fault::Packets {
            expected: expected.get(at).copied(),
            actual: found.get(at).copied(),
        });
    }
    if let Some(at) = first_difference(stream, &bytes) {
        return Err(Fault::Bytes { at });
    }
    Ok(Tally {
        bytes: stream.len() as u64,
        planted: 0,
        found: found.len() as u64,
        other_events,
    })
}

/// Index of the first element in which two lists differ.
fn first_difference<T: PartialEq>(a: &[T], b: &[T]) -> Option<usize> {
    let at = a.iter().zip(b).position(|(a, b)| a != b);
    at.or((a.len() != b.len()).then(|| a.len().min(b.len())))
}

/// One stream of at least `bytes` bytes made from `seed`, through the decoder, the readers of messages and a client.
///
/// # Errors
/// [`Fault`] with the first difference.
///
/// # Panics
/// When a planted packet is not where it was put: the harness itself is wrong.
pub fn run(seed: u64, bytes: usize) -> Result<Tally, Fault> {
    let mut random = SplitMix64::new(seed);
    let (stream, planted) = stream(&mut random, bytes);
    assert!(
        planted
            .iter()
            .all(|at| packet_len(&stream[*at..]).is_some()),
        "a planted packet is not in its stream"
    );
    let decoder = RefCell::new(Decoder::new());
    let tally = check(
        &stream,
        |byte| {
            let event = decoder.borrow_mut().push(byte);
            if let Some(Event::Packet(packet)) = event {
                // Whatever a packet holds, reading it as a message is a value or an error.
                let _ = (
                    Reply::decode(&packet),
                    Request::decode(&packet, &Dialect::MANUAL),
                );
            }
            event
        },
        || decoder.borrow().unfinished().to_vec(),
    )?;
    feed_client(&stream);
    Ok(Tally {
        planted: planted.len() as u64,
        ..tally
    })
}

/// A client that always asks and hears only noise.
fn feed_client(stream: &[u8]) {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    for (now_us, byte) in (0..).step_by(261).zip(stream) {
        let _ = client.begin(now_us, DriveId::FRESH.into(), &Request::ReadMainGain);
        let _ = client.receive(now_us, *byte);
        let _ = client.poll(now_us);
    }
}
