//! Frames on the wire: version, body and checksum, with the zero bytes stuffed away (COBS), ended by a zero byte.
//!
//! | Byte before stuffing | What |
//! |---|---|
//! | 0 | version of the protocol; its place never changes |
//! | 1 to n-5 | body, at most [`LONGEST_BODY`] bytes |
//! | n-4 to n-1 | CRC-32 (ISO-HDLC, as in zip and Ethernet) over everything before, the low byte first; its place never changes |

use cobs::{CobsEncoder, DecodeResult, DecoderState};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use serde::{Deserialize, Serialize};

/// The version of the protocol.
pub const VERSION: u8 = 1;
/// The longest body in bytes.
pub const LONGEST_BODY: usize = 768;

const VERSION_LENGTH: usize = 1;
const CHECKSUM_LENGTH: usize = 4;
/// Version, body and checksum.
const LONGEST: usize = VERSION_LENGTH + LONGEST_BODY + CHECKSUM_LENGTH;
/// With a byte for every 254 that stuffing adds, and the zero at the end.
pub const LONGEST_FRAME: usize = LONGEST + LONGEST.div_ceil(254) + 1;

/// A table would be faster, and a kilobyte: a byte takes a few dozen instructions of the thread.
const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The checksum of frames and of settings: CRC-32 (ISO-HDLC).
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CHECKSUM.checksum(bytes)
}

/// Why bytes are no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// More bytes than the longest frame has, or fewer than the shortest.
    Length,
    /// It ended where the stuffing says that it goes on: a part is missing, or a length was damaged.
    Stuffing,
    /// The checksum is another one.
    Checksum,
    /// The checksum is right, and the version another one.
    Version {
        /// The version that came.
        actual: u8,
    },
}

/// Frames that were lost, by why. A sum ends at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Losses {
    /// [`Loss::Length`].
    pub length: u32,
    /// [`Loss::Stuffing`].
    pub stuffing: u32,
    /// [`Loss::Checksum`].
    pub checksum: u32,
    /// [`Loss::Version`].
    pub version: u32,
    /// The frame is right and its body is no message.
    pub body: u32,
}

impl Losses {
    fn count(&mut self, loss: Loss) {
        let place = match loss {
            Loss::Length => &mut self.length,
            Loss::Stuffing => &mut self.stuffing,
            Loss::Checksum => &mut self.checksum,
            Loss::Version { .. } => &mut self.version,
        };
        *place = place.saturating_add(1);
    }
}

/// What is in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Content<'a> {
    /// The message.
    pub body: &'a [u8],
    /// The checksum that was found right: two frames that differ have different ones, nearly always.
    pub checksum: u32,
}

/// Finds frames in bytes. After damage it is in step again at the next zero byte.
#[derive(Debug)]
pub struct Decoder {
    bytes: [u8; LONGEST],
    length: usize,
    state: DecoderState,
    losses: Losses,
    frames: u32,
}

impl Decoder {
    /// Before the first byte.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; LONGEST],
            length: 0,
            state: DecoderState::Idle,
            losses: Losses {
                length: 0,
                stuffing: 0,
                checksum: 0,
                version: 0,
                body: 0,
            },
            frames: 0,
        }
    }

    /// Frames that were lost.
    #[must_use]
    pub const fn losses(&self) -> &Losses {
        &self.losses
    }

    /// Frames that were right.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Counts a frame whose body is no message.
    pub fn count_bad_body(&mut self) {
        self.losses.body = self.losses.body.saturating_add(1);
    }

    /// Takes a byte; the content of a frame that it ends, or why that is none.
    pub fn push(&mut self, byte: u8) -> Option<Result<Content<'_>, Loss>> {
        let ended = match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => return None,
            Ok(DecodeResult::DataStart) => {
                self.length = 0;
                return None;
            }
            Ok(DecodeResult::DataContinue(byte)) => {
                if let Some(place) = self.bytes.get_mut(self.length) {
                    *place = byte;
                }
                // One more than fits is enough to know that it is too long.
                self.length = (self.length + 1).min(LONGEST + 1);
                return None;
            }
            Ok(DecodeResult::DataComplete) => Ok(()),
            Err(_) => Err(Loss::Stuffing),
        };
        match ended.and_then(|()| self.check()) {
            Ok(checksum) => {
                self.frames = self.frames.saturating_add(1);
                let end = self.length.saturating_sub(CHECKSUM_LENGTH);
                let body = self.bytes.get(VERSION_LENGTH..end).unwrap_or_default();
                Some(Ok(Content { body, checksum }))
            }
            Err(loss) => {
                self.losses.count(loss);
                Some(Err(loss))
            }
        }
    }

    /// Length, then checksum, then version.
    fn check(&self) -> Result<u32, Loss> {
        let frame = self.bytes.get(..self.length).ok_or(Loss::Length)?;
        let (content, checksum) = frame
            .split_last_chunk::<CHECKSUM_LENGTH>()
            .ok_or(Loss::Length)?;
        let version = *content.first().ok_or(Loss::Length)?;
        let checksum = u32::from_le_bytes(*checksum);
        if CHECKSUM.checksum(content) != checksum {
            return Err(Loss::Checksum);
        }
        if version != VERSION {
            return Err(Loss::Version { actual: version });
        }
        Ok(checksum)
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

/// Writes a frame with this message; its length, or `None` when it does not fit.
pub fn encode(message: &impl Serialize, out: &mut [u8]) -> Option<usize> {
    let mut body = [0; LONGEST_BODY];
    let body = postcard::to_slice(message, &mut body).ok()?;
    let mut digest = CHECKSUM.digest();
    digest.update(&[VERSION]);
    digest.update(body);
    let checksum = digest.finalize().to_le_bytes();
    let mut encoder = CobsEncoder::new(out);
    for part in [&[VERSION], &*body, &checksum] {
        encoder.push(part).ok()?;
    }
    let length = encoder.finalize();
    *out.get_mut(length)? = 0;
    Some(length + 1)
}

/// The message in a body; `None` when it is none, and when something follows it.
pub fn decode<'a, M: Deserialize<'a>>(body: &'a [u8]) -> Option<M> {
    let (message, rest) = postcard::take_from_bytes(body).ok()?;
    rest.is_empty().then_some(message)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn frame(message: &impl Serialize) -> Vec<u8> {
        let mut bytes = [0xA5; LONGEST_FRAME];
        let length = encode(message, &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    fn bodies(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Vec<u8>, Loss>> {
        let mut found = Vec::new();
        for &byte in bytes {
            if let Some(result) = decoder.push(byte) {
                found.push(result.map(|content| content.body.to_vec()));
            }
        }
        found
    }

    #[test]
    fn a_frame_is_these_bytes() {
        // CRC-32 of 01 07 00 2A, computed with Python's zlib: 470C672A.
        assert_eq!(
            frame(&(7_u8, 0_u8, 42_u8)),
            [3, 1, 7, 6, 42, 0x2A, 0x67, 0x0C, 0x47, 0]
        );
    }

    #[test]
    fn every_loss_is_counted_and_the_next_frame_is_found() {
        let good = frame(&7_u32);
        let mut bytes = Vec::new();
        // A half frame, a damaged one, one of another version, a long one, an empty one, one that is too short.
        bytes.extend_from_slice(&good[..4]);
        bytes.push(0);
        let mut damaged = good.clone();
        damaged[2] ^= 0x10;
        bytes.extend_from_slice(&damaged);
        let mut other = [9, 7, 0, 0, 0, 0];
        let crc = checksum(&other[..2]).to_le_bytes();
        other[2..].copy_from_slice(&crc);
        let mut stuffed = [0; 10];
        let length = cobs::try_encode(&other, &mut stuffed).unwrap();
        bytes.extend_from_slice(&stuffed[..length]);
        bytes.push(0);
        bytes.extend_from_slice(&[0xFF; 2_000]);
        bytes.extend_from_slice(&[0, 0, 3, 1, 1, 0]);
        bytes.extend_from_slice(&good);
        let mut decoder = Decoder::new();
        let found = bodies(&mut decoder, &bytes);
        assert_eq!(found.last(), Some(&Ok(std::vec![7])));
        assert!(
            found.contains(&Err(Loss::Version { actual: 9 })),
            "{found:?}"
        );
        let losses = *decoder.losses();
        assert_eq!(
            (
                losses.stuffing,
                losses.checksum,
                losses.version,
                losses.length
            ),
            (2, 1, 1, 1),
            "{found:?}"
        );
        assert_eq!(decoder.frames(), 1);
    }

    #[test]
    fn the_longest_body_passes_and_no_longer_one() {
        let mut decoder = Decoder::new();
        for fill in [0_u8, 1, 0xFF] {
            // Two bytes are its length.
            let body = std::vec![fill; LONGEST_BODY - 2];
            let found = bodies(&mut decoder, &frame(&body.as_slice()));
            assert_eq!(found[0].as_ref().unwrap()[2..], body);
            let longer = std::vec![fill; LONGEST_BODY - 1];
            assert_eq!(encode(&longer.as_slice(), &mut [0; 2_000]), None);
        }
        assert_eq!(encode(&7_u32, &mut [0; 7]), None);
    }

    #[test]
    fn a_million_random_bytes_and_damage_make_no_message() {
        let mut random = fastrand::Rng::with_seed(18);
        let mut decoder = Decoder::new();
        let mut found_in_noise = 0;
        for _ in 0..1_000_000 {
            found_in_noise += usize::from(matches!(decoder.push(random.u8(..)), Some(Ok(_))));
        }
        assert_eq!(found_in_noise, 0);
        let seen = decoder.losses().stuffing + decoder.losses().checksum + decoder.losses().length;
        assert!(seen > 3_000, "{seen}");
        let mut found_whole = 0;
        // Valid frames, some damaged: each that is found is one that was sent.
        for number in 0..20_000_u32 {
            let mut bytes = frame(&(number, [number as u8; 20]));
            let is_damaged = random.u8(..) < 128;
            if is_damaged {
                let place = random.usize(0..bytes.len());
                match random.u8(0..3) {
                    0 => bytes[place] ^= 1 << random.u8(0..8),
                    1 => drop(bytes.remove(place)),
                    _ => bytes.insert(place, random.u8(..)),
                }
            }
            bytes.push(0);
            for byte in bytes {
                if let Some(Ok(content)) = decoder.push(byte) {
                    let (found, fill): (u32, [u8; 20]) = decode(content.body).unwrap();
                    assert_eq!((found, fill), (number, [number as u8; 20]));
                    found_whole += usize::from(!is_damaged);
                }
            }
        }
        assert!(found_whole > 9_000, "{found_whole}");
    }
}
