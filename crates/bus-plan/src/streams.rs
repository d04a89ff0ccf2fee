//! The worst case of a bus from a list of the frames on it: what a family supplies that is not planned frame by frame.

use crate::analysis::{Message, Response, Rules, response};
use can_frame::{BitRate, wire};

/// Busy periods up to this many periods of a stream are looked through.
const HORIZON_PERIODS: u32 = 64;

/// Frames of one kind, from or to every node of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameStream {
    /// What they are, for messages.
    pub name: &'static str,
    /// Frames that may come at once; 0 for a stream that this bus does not have.
    pub count: u32,
    /// Data bytes of each, at most 8.
    pub len: u8,
    /// Shortest time from one such burst to the next, in microseconds.
    pub period_us: u32,
    /// Latest end of the last frame of a burst, from when the burst is offered to the bus, in microseconds.
    pub deadline_us: u32,
}

impl FrameStream {
    /// So many frames of so many bytes at once; times in microseconds.
    #[must_use]
    pub const fn new(
        name: &'static str,
        count: u32,
        len: u8,
        period_us: u32,
        deadline_us: u32,
    ) -> Self {
        Self {
            name,
            count,
            len,
            period_us,
            deadline_us,
        }
    }

    /// The same for the analysis. Every frame counts as as urgent as every other: a node may hold a frame back behind a less urgent
    /// one, and then its identifier does not protect it.
    const fn message(&self, rate: BitRate) -> Message {
        Message {
            first_id: 0,
            last_id: u16::MAX,
            bits: wire::bound_bits(self.len) as u32,
            count: self.count,
            period_bits: at_least_1(bits_of(rate, self.period_us)),
            jitter_bits: 0,
            deadline_bits: bits_of(rate, self.deadline_us),
        }
    }
}

/// Whole bit times within a time.
const fn bits_of(rate: BitRate, us: u32) -> u32 {
    let bits = us as u64 * rate.kbit_per_s() as u64 / 1_000;
    if bits > u32::MAX as u64 {
        u32::MAX
    } else {
        bits as u32
    }
}

const fn at_least_1(bits: u32) -> u32 {
    if bits == 0 { 1 } else { bits }
}

/// Worst-case response times of streams that share a bus, in their order.
///
/// The bound takes every burst of every stream to come at once, each frame at its longest, and everything that comes until the bus is
/// idle again.
#[must_use]
pub fn response_times<const N: usize>(streams: &[FrameStream; N], rate: BitRate) -> [Response; N] {
    let messages = streams.map(|stream| stream.message(rate));
    let longest = messages
        .iter()
        .fold(1, |longest, message| message.period_bits.max(longest));
    let rules = Rules {
        error_interval_bits: None,
        horizon_bits: longest.saturating_mul(HORIZON_PERIODS),
    };
    let mut place = 0;
    messages.map(|message| {
        let mut others = messages;
        // What is judged does not disturb itself.
        if let Some(own) = others.get_mut(place) {
            own.count = 0;
        }
        place += 1;
        response(&message, &others, &rules)
    })
}

/// The first stream whose frames may come too late.
#[must_use]
pub fn first_late<const N: usize>(
    streams: &[FrameStream; N],
    rate: BitRate,
) -> Option<(&'static str, Response)> {
    let responses = response_times(streams, rate);
    let mut pairs = streams.iter().zip(responses);
    pairs
        .find(|(stream, response)| stream.count > 0 && !response.is_met())
        .map(|(stream, response)| (stream.name, response))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(count: u32, len: u8, period_us: u32) -> FrameStream {
        FrameStream::new("test", count, len, period_us, period_us)
    }

    #[test]
    fn everything_at_once_is_the_worst_case() {
        // At 500 kbit/s a frame of 8 bytes has at most 135 bits, one of 0 bytes 55.
        let streams = [stream(4, 8, 10_000), stream(2, 0, 10_000)];
        let bits = response_times(&streams, BitRate::Kbit500).map(|response| response.bits);
        assert_eq!(bits, [Some(4 * 135 + 2 * 55); 2]);
        assert_eq!(first_late(&streams, BitRate::Kbit500), None);
    }

    #[test]
    fn a_bus_that_carries_too_much_is_late() {
        let streams = [stream(1, 8, 10_000), stream(8, 8, 2_000)];
        let (name, response) = first_late(&streams, BitRate::Kbit500).expect("1080 of 1000 bits");
        assert_eq!((name, response.is_met()), ("test", false));
        assert_eq!(first_late(&streams, BitRate::Kbit1000), None);
    }
}
