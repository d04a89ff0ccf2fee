//! Frames, intervals and response times of each identifier.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::conversation::since;
use crate::decoder::Meaning;
use crate::frame::Frame;

/// Nanoseconds of a microsecond.
const US: f64 = 1e3;

/// Smallest, mean and largest of a series, in microseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The smallest.
    pub least_us: f64,
    /// The mean.
    pub mean_us: f64,
    /// The largest.
    pub most_us: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Series {
    count: u64,
    sum_ns: u64,
    least_ns: u64,
    most_ns: u64,
}

impl Series {
    fn add(&mut self, ns: u64) {
        self.least_ns = if self.count == 0 {
            ns
        } else {
            self.least_ns.min(ns)
        };
        self.most_ns = self.most_ns.max(ns);
        self.sum_ns = self.sum_ns.saturating_add(ns);
        self.count += 1;
    }

    fn spread(&self) -> Option<Spread> {
        (self.count > 0).then(|| Spread {
            least_us: self.least_ns as f64 / US,
            mean_us: self.sum_ns as f64 / US / self.count as f64,
            most_us: self.most_ns as f64 / US,
        })
    }
}

/// One identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OfIdentifier {
    name: &'static str,
    drive: Option<u8>,
    frames: u64,
    bytes: u64,
    undecodable: u64,
    last_ns: Option<u64>,
    intervals: Series,
    responses: Series,
}

impl OfIdentifier {
    /// The function, by the name in the documents; empty for a foreign frame.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The drive or node of its first frame; `None` where the identifier is of all of them.
    #[must_use]
    pub const fn drive(&self) -> Option<u8> {
        match self.name.as_bytes() {
            // Its node is in the data.
            b"NMT" => None,
            _ => self.drive,
        }
    }

    /// Frames, requests and replies together.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Data bytes.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Frames that do not decode.
    #[must_use]
    pub const fn undecodable(&self) -> u64 {
        self.undecodable
    }

    /// Time from frame to frame.
    #[must_use]
    pub fn intervals(&self) -> Option<Spread> {
        self.intervals.spread()
    }

    /// Time from request to reply, end to end.
    #[must_use]
    pub fn responses(&self) -> Option<Spread> {
        self.responses.spread()
    }
}

/// Statistics of a log or of an interface.
#[derive(Debug, Clone)]
pub struct Statistics {
    /// One for each 11-bit identifier: there are few, and this is faster than a map.
    standard: Vec<Option<OfIdentifier>>,
    extended: BTreeMap<u32, OfIdentifier>,
    first_ns: Option<u64>,
    last_ns: u64,
    frames: u64,
    least_bits: u64,
}

impl Default for Statistics {
    fn default() -> Self {
        Self {
            standard: vec![None; 1 << 11],
            extended: BTreeMap::new(),
            first_ns: None,
            last_ns: 0,
            frames: 0,
            least_bits: 0,
        }
    }
}

impl Statistics {
    /// Counts a frame that ended at `at_ns`; `None` when the times are not known.
    pub fn count(&mut self, at_ns: impl Into<Option<u64>>, frame: &Frame, meaning: &Meaning) {
        let at_ns = at_ns.into();
        if let Some(at_ns) = at_ns {
            self.first_ns = Some(self.first_ns.map_or(at_ns, |first_ns| first_ns.min(at_ns)));
            self.last_ns = self.last_ns.max(at_ns);
        }
        self.frames += 1;
        self.least_bits += u64::from(frame.least_bits());
        let fresh = || OfIdentifier {
            name: meaning.name(),
            drive: meaning.drive(),
            frames: 0,
            bytes: 0,
            undecodable: 0,
            last_ns: None,
            intervals: Series::default(),
            responses: Series::default(),
        };
        let place = if frame.is_extended() {
            None
        } else {
            self.standard.get_mut(frame.id() as usize)
        };
        let entry = match place {
            Some(place) => place.get_or_insert_with(fresh),
            None => self.extended.entry(frame.id()).or_insert_with(fresh),
        };
        if let Some(interval_ns) = since(at_ns, entry.last_ns) {
            entry.intervals.add(interval_ns);
        }
        entry.frames += 1;
        entry.last_ns = at_ns;
        entry.bytes += frame.data().len() as u64;
        entry.undecodable += u64::from(meaning.is_undecodable());
        if let Some(ns) = meaning.response_ns() {
            entry.responses.add(ns);
        }
    }

    /// Every identifier that was seen, 11-bit ones first, in ascending order; true for 29 bits.
    pub fn identifiers(&self) -> impl Iterator<Item = (u32, bool, &OfIdentifier)> {
        let standard = (0..)
            .zip(&self.standard)
            .filter_map(|(id, entry)| Some((id, false, entry.as_ref()?)));
        let extended = self.extended.iter().map(|(id, entry)| (*id, true, entry));
        standard.chain(extended)
    }

    /// Frames so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Time from the first frame to the last in nanoseconds; `None` when no frame had a time.
    #[must_use]
    pub fn duration_ns(&self) -> Option<u64> {
        self.first_ns
            .map(|first_ns| self.last_ns.saturating_sub(first_ns))
    }

    /// Share of the bus time that the frames take at least, without stuff bits; `None` for fewer than two frames.
    #[must_use]
    pub fn least_load(&self, bit_rate_kbit: u32) -> Option<f64> {
        let bits_in_time = self.duration_ns()? as f64 * f64::from(bit_rate_kbit) / 1e6;
        (bits_in_time > 0.0).then(|| self.least_bits as f64 / bits_in_time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::Decoder;

    #[test]
    fn counts_each_identifier() {
        let (mut statistics, mut decoder) = (Statistics::default(), Decoder::default());
        let frames: [(u64, u32, bool, &[u8]); 5] = [
            (0, 0x029, false, &[]),
            (600, 0x029, false, &[0]),
            (1_000, 0x03C, false, &[1]),
            (2_000, 0x03C, false, &[1, 2, 3]),
            (3_000, 0x029, true, &[]),
        ];
        for (at_us, id, extended, data) in frames {
            let frame = Frame::new(id, extended, data).unwrap();
            let meaning = decoder.hear(at_us * 1_000, &frame);
            statistics.count(at_us * 1_000, &frame, &meaning);
        }
        let seen: Vec<_> = statistics
            .identifiers()
            .map(|(id, extended, entry)| {
                (
                    id,
                    extended,
                    entry.frames(),
                    entry.bytes(),
                    entry.undecodable(),
                )
            })
            .collect();
        assert_eq!(
            seen,
            [
                (0x029, false, 2, 1, 0),
                (0x03C, false, 2, 4, 1),
                (0x029, true, 1, 0, 1)
            ]
        );
        let status = statistics.identifiers().next().unwrap().2;
        assert_eq!(status.name(), "Read_Drive_Status");
        assert_eq!(status.responses().unwrap().mean_us, 600.0);
        assert_eq!(
            (statistics.frames(), statistics.duration_ns()),
            (5, Some(3_000_000))
        );
        // 4 standard frames with 47 bits, one of 67, and 5 data bytes in 3000 bits.
        assert!((statistics.least_load(1_000).unwrap() - 295.0 / 3_000.0).abs() < 1e-12);
    }
}
