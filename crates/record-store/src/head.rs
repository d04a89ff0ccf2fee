//! The head of a record.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};

/// Without a table: a kilobyte of flash more would save a few milliseconds at the start.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Sequence number, length and checksum of both and the data; what is behind them stays erased.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Head {
    pub(crate) sequence: u32,
    pub(crate) length: u32,
    pub(crate) checksum: u32,
}

impl Head {
    /// Bytes of a head: whole units of 4 and of 8 bytes.
    pub(crate) const BYTES: usize = 16;

    pub(crate) fn to_bytes(self) -> [u8; Self::BYTES] {
        let [sequence, length, checksum] =
            [self.sequence, self.length, self.checksum].map(u32::to_le_bytes);
        let mut bytes = [0xFF; Self::BYTES];
        let fields = [sequence, length, checksum];
        for (to, from) in bytes.iter_mut().zip(fields.as_flattened()) {
            *to = *from;
        }
        bytes
    }

    pub(crate) fn of_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let word = |at: usize| {
            let bytes = bytes.get(at..).and_then(|rest| rest.first_chunk());
            bytes.map_or(u32::MAX, |bytes| u32::from_le_bytes(*bytes))
        };
        Self {
            sequence: word(0),
            length: word(4),
            checksum: word(8),
        }
    }

    /// The checksum of a record, to be continued with its data.
    pub(crate) fn begin(sequence: u32, length: u32) -> Digest<'static, u32, NoTable> {
        let mut digest = CRC.digest();
        digest.update(&sequence.to_le_bytes());
        digest.update(&length.to_le_bytes());
        digest
    }
}
