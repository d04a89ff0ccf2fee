//! Packets out of a stream of bytes, whatever else is in the stream.
//!
//! Specification: only the first byte of a packet is below 0x80, so such a byte always begins a new packet and never belongs to an
//! old one. From this follow two guarantees.
//!
//! - **No intact packet is lost.** Every run of bytes that is a packet (4 to 7 bytes, the right marks, length and checksum)
//!   is reported, whatever is in front of it and behind it: noise, half a packet, a packet with wrong length bits, another
//!   packet without a gap. Its own start byte is the seam. Two packets never share a byte, so none hides another.
//! - **No byte is unaccounted for.** Every byte is in exactly one event, in the order of the stream, or in the unfinished
//!   packet that the decoder still holds.
//!
//! What no decoder can promise: a packet that is damaged itself is lost, and its sender must send again. Noise can look
//! like a packet: a checksum of 7 bits lets one in 128 random candidates pass. So what an event reports must still be
//! checked against what was asked.

use core::fmt;

use crate::groups::MARK;
use crate::packet::{MAX_PACKET, Packet, announced_len, write_bytes};

/// What the decoder made of the bytes so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Event {
    /// A packet.
    Packet(Packet),
    /// A byte of 0x80 or more outside of a packet: noise, or what is left of a packet whose start byte or length was lost.
    Stray(u8),
    /// A packet that ended early: by a new start byte, which is not part of it, or by silence.
    Truncated(Fragment),
    /// A packet of the announced length with the wrong last byte.
    Checksum {
        /// All of its bytes.
        received: Fragment,
        /// The last byte that would fit the others.
        expected: u8,
    },
}

/// Bytes of a packet that is none, 1 to 7 of them.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Fragment {
    bytes: [u8; MAX_PACKET],
    len: u8,
}

impl Fragment {
    const EMPTY: Self = Self {
        bytes: [0; MAX_PACKET],
        len: 0,
    };

    /// The bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes
            .get(..usize::from(self.len))
            .unwrap_or(&self.bytes)
    }

    fn push(&mut self, byte: u8) {
        if let Some(free) = self.bytes.get_mut(usize::from(self.len)) {
            *free = byte;
            self.len += 1;
        }
    }
}

impl fmt::Display for Fragment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_bytes(f, self.as_bytes())
    }
}

impl fmt::Debug for Fragment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fragment({self})")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Fragment {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=[u8]:02X}", self.as_bytes());
    }
}

/// How many events of each kind there were; a count stops at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LineCounters {
    /// [`Event::Packet`].
    pub packets: u32,
    /// [`Event::Stray`].
    pub stray_bytes: u32,
    /// [`Event::Truncated`].
    pub truncated: u32,
    /// [`Event::Checksum`].
    pub checksum_errors: u32,
}

/// Finds packets in a stream of bytes.
///
/// ```
/// use dyn_serial::{Decoder, Event};
///
/// let mut decoder = Decoder::new();
/// // A packet that lost its end, and a whole one behind it.
/// let stream = [0x03, 0xBB, 0x80, 0x03, 0x99, 0x81, 0x9D];
/// let events: Vec<Event> = stream.iter().filter_map(|byte| decoder.push(*byte)).collect();
/// let [Event::Truncated(lost), Event::Packet(packet)] = events[..] else { unreachable!() };
/// assert_eq!(lost.as_bytes(), [0x03, 0xBB, 0x80]);
/// assert_eq!(packet.as_bytes(), [0x03, 0x99, 0x81, 0x9D]);
/// ```
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Decoder {
    unfinished: Fragment,
    counters: LineCounters,
}

impl Decoder {
    /// A decoder that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            unfinished: Fragment::EMPTY,
            counters: LineCounters {
                packets: 0,
                stray_bytes: 0,
                truncated: 0,
                checksum_errors: 0,
            },
        }
    }

    /// Takes the next byte of the stream.
    pub fn push(&mut self, byte: u8) -> Option<Event> {
        if byte < MARK {
            let event = self.cut_off();
            self.unfinished.push(byte);
            return event;
        }
        if self.unfinished.len == 0 {
            count(&mut self.counters.stray_bytes);
            return Some(Event::Stray(byte));
        }
        self.unfinished.push(byte);
        let [_, second, ..] = self.unfinished.bytes;
        let is_whole = usize::from(self.unfinished.len) == announced_len(second);
        // A second byte that is not there yet announces 4 bytes, which one byte never is.
        is_whole.then(|| self.finish())
    }

    /// The line has been silent for longer than the gap within a packet: an unfinished packet is not going to be finished.
    pub fn silence(&mut self) -> Option<Event> {
        self.cut_off()
    }

    /// The bytes of the packet that is not finished.
    #[must_use]
    pub fn unfinished(&self) -> &[u8] {
        self.unfinished.as_bytes()
    }

    /// The events so far, counted.
    #[must_use]
    pub const fn counters(&self) -> &LineCounters {
        &self.counters
    }

    fn cut_off(&mut self) -> Option<Event> {
        let fragment = self.take();
        (fragment.len > 0).then(|| {
            count(&mut self.counters.truncated);
            Event::Truncated(fragment)
        })
    }

    /// The marks and the length were right at every byte, so only the last byte can be wrong.
    fn finish(&mut self) -> Event {
        let received = self.take();
        match Packet::with_checksum(received.bytes) {
            Ok(packet) => {
                count(&mut self.counters.packets);
                Event::Packet(packet)
            }
            Err(expected) => {
                count(&mut self.counters.checksum_errors);
                Event::Checksum { received, expected }
            }
        }
    }

    fn take(&mut self) -> Fragment {
        core::mem::replace(&mut self.unfinished, Fragment::EMPTY)
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn events(stream: &[u8]) -> Vec<Event> {
        let mut decoder = Decoder::new();
        stream
            .iter()
            .filter_map(|byte| decoder.push(*byte))
            .collect()
    }

    fn packet(bytes: &[u8]) -> Event {
        Event::Packet(Packet::parse(bytes).unwrap())
    }

    #[test]
    fn packets_without_a_gap_are_two_packets() {
        let glued = [0x08, 0x8A, 0xB2, 0xC4, 0x03, 0x80, 0x80, 0x83];
        assert_eq!(events(&glued), [packet(&glued[..4]), packet(&glued[4..])]);
    }

    #[test]
    fn length_bits_that_announce_too_much_cost_only_their_packet() {
        // The second byte of the first packet says 7 bytes instead of 4.
        let stream = [0x08, 0xEA, 0xB2, 0xC4, 0x03, 0x80, 0x80, 0x83];
        let [Event::Truncated(lost), good] = events(&stream)[..] else {
            panic!("{:?}", events(&stream));
        };
        assert_eq!(
            (lost.as_bytes(), good),
            (&stream[..4], packet(&stream[4..]))
        );
        assert_eq!(
            std::format!("{lost} {lost:?}"),
            "08 EA B2 C4 Fragment(08 EA B2 C4)"
        );
    }

    #[test]
    fn length_bits_that_announce_too_little_cost_only_their_packet() {
        // The second byte of the first packet says 4 bytes instead of 5.
        let stream = [0x03, 0x83, 0x80, 0xF8, 0x9E, 0x03, 0x80, 0x80, 0x83];
        let [
            Event::Checksum { received, expected },
            Event::Stray(0x9E),
            good,
        ] = events(&stream)[..]
        else {
            panic!("{:?}", events(&stream));
        };
        assert_eq!((received.as_bytes(), expected), (&stream[..4], 0x86));
        assert_eq!(good, packet(&stream[5..]));
    }

    #[test]
    fn silence_ends_an_unfinished_packet_once() {
        let mut decoder = Decoder::new();
        assert_eq!(decoder.push(0x08), None);
        assert_eq!(decoder.push(0x8A), None);
        assert_eq!(decoder.unfinished(), [0x08, 0x8A]);
        assert!(matches!(decoder.silence(), Some(Event::Truncated(_))));
        assert_eq!(decoder.silence(), None);
        // The rest comes too late.
        assert_eq!(decoder.push(0xB2), Some(Event::Stray(0xB2)));
    }

    #[test]
    fn every_kind_of_event_is_counted() {
        let mut decoder = Decoder::new();
        let stream = [
            0xFF, 0x03, 0x08, 0x8A, 0xB2, 0xC4, 0x08, 0x8A, 0xB2, 0xC5, 0xFE,
        ];
        let seen = stream.iter().filter_map(|byte| decoder.push(*byte)).count();
        assert_eq!(seen, 5);
        assert_eq!(
            *decoder.counters(),
            LineCounters {
                packets: 1,
                stray_bytes: 2,
                truncated: 1,
                checksum_errors: 1
            }
        );
    }
}
