//! Bytes on their way to the host: how they become packets, and what becomes of those that the host does not take. Without the chip.

/// The largest packet of a bulk endpoint at full speed (USB 2.0, section 5.8.3).
pub(crate) const PACKET_BYTES: usize = 64;

/// Cuts the bytes that wait into packets.
pub(crate) struct Packets {
    /// The last packet was full, so the host waits for the end of the transfer.
    is_open: bool,
}

impl Packets {
    /// Nothing was sent yet.
    pub(crate) const fn new() -> Self {
        Self { is_open: false }
    }

    /// Bytes of the next packet; `None` while there is nothing to send. A transfer ends with a packet that is not full, so one without bytes
    /// follows a full one when nothing else does (USB 2.0, section 5.8.3).
    pub(crate) fn next(&mut self, waiting: usize) -> Option<usize> {
        let count = waiting.min(PACKET_BYTES);
        if count == 0 && !self.is_open {
            return None;
        }
        self.is_open = count == PACKET_BYTES;
        Some(count)
    }
}

/// What becomes of bytes that are offered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// So many of them go into the buffer; the others are offered again.
    Kept(usize),
    /// All of them are lost: nobody takes them.
    Lost,
}

/// Gives bytes up that the host does not take, as a serial line loses what nobody reads. The next host gets answers of its own, and none
/// that an earlier one left behind.
pub(crate) struct Patience {
    cycles: u64,
    /// When there was room last.
    since: u64,
    gives_up: bool,
    times: u32,
}

impl Patience {
    /// Waits for so many cycles.
    pub(crate) const fn new(cycles: u64) -> Self {
        Self {
            cycles,
            since: 0,
            gives_up: false,
            times: 0,
        }
    }

    /// What becomes of `offered` bytes in cycle `now`, when the buffer has `room` for so many.
    pub(crate) fn offer(&mut self, now: u64, room: usize, offered: usize) -> Fate {
        if room > 0 || offered == 0 {
            self.gives_up &= room == 0;
            if room > 0 {
                self.since = now;
            }
            return Fate::Kept(room.min(offered));
        }
        if now.saturating_sub(self.since) < self.cycles {
            return Fate::Kept(0);
        }
        if !self.gives_up {
            self.gives_up = true;
            self.times = self.times.saturating_add(1);
        }
        Fate::Lost
    }

    /// How often it has begun to give bytes up.
    pub(crate) const fn times(&self) -> u32 {
        self.times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes of the packets of so many bytes that wait at once, nine at most.
    fn cut(packets: &mut Packets, mut waiting: usize) -> Vec<usize> {
        let sizes = std::iter::from_fn(|| {
            let size = packets.next(waiting)?;
            waiting -= size;
            Some(size)
        });
        sizes.take(9).collect()
    }

    #[test]
    fn every_transfer_ends_with_a_packet_that_is_not_full() {
        let mut packets = Packets::new();
        assert_eq!(cut(&mut packets, 0), []);
        assert_eq!(cut(&mut packets, 1), [1]);
        assert_eq!(cut(&mut packets, 63), [63]);
        assert_eq!(cut(&mut packets, 64), [64, 0]);
        assert_eq!(cut(&mut packets, 65), [64, 1]);
        assert_eq!(cut(&mut packets, 128), [64, 64, 0]);
        assert_eq!(cut(&mut packets, 300), [64, 64, 64, 64, 44]);
        assert_eq!(cut(&mut packets, 0), []);
    }

    #[test]
    fn more_bytes_end_a_transfer_as_an_empty_packet_does() {
        let mut packets = Packets::new();
        assert_eq!(packets.next(64), Some(64));
        assert_eq!(packets.next(3), Some(3));
        assert_eq!(packets.next(0), None);
    }

    #[test]
    fn bytes_are_kept_as_long_as_the_host_takes_some() {
        let mut patience = Patience::new(100);
        assert_eq!(patience.offer(1_000, 256, 300), Fate::Kept(256));
        assert_eq!(patience.offer(1_099, 0, 44), Fate::Kept(0));
        assert_eq!(patience.offer(1_100, 64, 44), Fate::Kept(44));
        assert_eq!(patience.offer(1_199, 0, 1), Fate::Kept(0));
        assert_eq!(patience.times(), 0);
    }

    #[test]
    fn bytes_are_lost_when_nobody_takes_them_and_each_time_counts_once() {
        let mut patience = Patience::new(100);
        assert_eq!(patience.offer(0, 10, 10), Fate::Kept(10));
        assert_eq!(patience.offer(99, 0, 500), Fate::Kept(0));
        assert_eq!(patience.offer(100, 0, 500), Fate::Lost);
        assert_eq!(patience.offer(101, 0, 500), Fate::Lost);
        assert_eq!(patience.times(), 1);
        // Somebody reads again.
        assert_eq!(patience.offer(5_000, 64, 500), Fate::Kept(64));
        assert_eq!(patience.offer(5_099, 0, 436), Fate::Kept(0));
        assert_eq!(patience.offer(5_100, 0, 436), Fate::Lost);
        assert_eq!(patience.times(), 2);
    }

    #[test]
    fn a_full_buffer_that_is_offered_nothing_loses_nothing() {
        let mut patience = Patience::new(100);
        assert_eq!(patience.offer(0, 10, 10), Fate::Kept(10));
        assert_eq!(patience.offer(5_000, 0, 0), Fate::Kept(0));
        assert_eq!(patience.times(), 0);
    }
}
