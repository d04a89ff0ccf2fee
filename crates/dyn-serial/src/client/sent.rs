//! What was sent and may come back: two-wire RS485 hears itself, and a drive that is not meant passes packets on.
//!
//! The codes of the two directions overlap. The bytes of Set_MainGain are those of Is_MainGain, those of Read_SpeedGain are those of
//! Is_Status with every bit 0; so a packet that comes back can look like the reply to the next request.

use crate::packet::Packet;

/// Packets that are remembered.
const PACKETS: usize = 8;

/// For so long a packet may come back: longer than any line or converter holds it.
const MEMORY_US: u64 = 1_000_000;

/// A packet with the time until which it may come back.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Entry {
    packet: Packet,
    until_us: u64,
}

/// What a packet that comes back is the echo of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EchoOf {
    /// The packet that was sent last.
    Latest,
    /// One that was sent before it.
    Earlier,
}

/// The packets that were sent last, oldest first, each as often as it was sent.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct SentPackets([Option<Entry>; PACKETS]);

impl SentPackets {
    pub(super) const NONE: Self = Self([None; PACKETS]);

    /// A packet is sent. Where there is no room the oldest counts no more.
    pub(super) fn push(&mut self, packet: Packet, now_us: u64) {
        if self.0.iter().all(Option::is_some) {
            self.forget_through(0);
        }
        if let Some(free) = self.0.iter_mut().find(|entry| entry.is_none()) {
            *free = Some(Entry {
                packet,
                until_us: now_us.saturating_add(MEMORY_US),
            });
        }
    }

    /// Whether this packet may be one that comes back.
    pub(super) fn holds(&self, packet: &Packet, now_us: u64) -> bool {
        self.place(packet, now_us).is_some()
    }

    /// This packet came back; `None` when it cannot have. A line keeps the order: it is the oldest of its kind, and those before it will
    /// not come any more.
    pub(super) fn take(&mut self, packet: &Packet, now_us: u64) -> Option<EchoOf> {
        let place = self.place(packet, now_us)?;
        self.forget_through(place);
        Some(if self.0.iter().all(Option::is_none) {
            EchoOf::Latest
        } else {
            EchoOf::Earlier
        })
    }

    fn place(&self, packet: &Packet, now_us: u64) -> Option<usize> {
        self.0.iter().position(|entry| {
            entry.is_some_and(|entry| entry.packet == *packet && now_us < entry.until_us)
        })
    }

    fn forget_through(&mut self, place: usize) {
        for entry in self.0.iter_mut().take(place + 1) {
            *entry = None;
        }
        let mut kept = [None; PACKETS];
        let entries = self.0.iter().filter(|entry| entry.is_some());
        for (to, from) in kept.iter_mut().zip(entries) {
            *to = *from;
        }
        self.0 = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dialect, DriveId, MainGain, Request};

    fn gain(value: i32) -> Packet {
        let drive = DriveId::new(1).unwrap();
        let request = Request::SetMainGain(MainGain::new(value).unwrap());
        request.encode(drive.into(), &Dialect::MANUAL).unwrap()
    }

    #[test]
    fn what_comes_back_takes_the_packets_before_it_along() {
        let mut sent = SentPackets::NONE;
        for value in 1..=4 {
            sent.push(gain(value), 0);
        }
        assert_eq!(sent.take(&gain(2), 10), Some(EchoOf::Earlier));
        let left = [1, 2, 3, 4].map(|value| sent.holds(&gain(value), 10));
        assert_eq!(left, [false, false, true, true]);
        assert_eq!(sent.take(&gain(1), 10), None);
        assert_eq!(sent.take(&gain(4), 10), Some(EchoOf::Latest));
    }

    #[test]
    fn the_latest_packets_are_remembered_for_a_while() {
        let mut sent = SentPackets::NONE;
        for value in 1..=9 {
            sent.push(gain(value), 0);
        }
        // Once more: it may come back twice.
        sent.push(gain(3), 500_000);
        let held =
            |sent: &SentPackets, now_us| [2, 3, 4, 9].map(|value| sent.holds(&gain(value), now_us));
        assert_eq!(held(&sent, 999_999), [false, true, true, true]);
        assert_eq!(held(&sent, 1_000_000), [false, true, false, false]);
        assert_eq!(held(&sent, 1_500_000), [false; 4]);
        assert_eq!(sent.take(&gain(3), 10), Some(EchoOf::Earlier));
        assert_eq!(sent.take(&gain(3), 10), Some(EchoOf::Latest));
    }
}
