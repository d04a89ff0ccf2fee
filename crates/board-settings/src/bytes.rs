//! Settings as bytes: the version, then what postcard makes of [`Settings`].

use postcard::take_from_bytes;

use crate::axis::AxisSettings;
use crate::refusal::{Kind, Refusal};
use crate::settings::{BusSettings, Inputs, MOST_AXES, Name, Settings};

/// The layout that this version writes and reads: the first byte.
pub const VERSION: u8 = 1;
/// No settings take more bytes.
pub const LONGEST: usize = 1_344;

impl Settings {
    /// The bytes of these settings, in the front of `room`.
    ///
    /// # Errors
    /// When there is not enough room: [`LONGEST`] is enough.
    pub fn write<'a>(&self, room: &'a mut [u8]) -> Result<&'a mut [u8], Refusal> {
        let given = room.len();
        let too_small = Kind::Room.because(LONGEST as i64, given as i64);
        let (version, rest) = room.split_first_mut().ok_or(too_small)?;
        *version = VERSION;
        let written = postcard::to_slice(self, rest).map(|bytes| bytes.len());
        let length = written.map_err(|_| too_small)? + 1;
        room.get_mut(..length).ok_or(too_small)
    }

    /// Reads settings.
    ///
    /// # Errors
    /// When the bytes are not settings of this version, whole and without anything behind them. Nothing is said about whether the values
    /// make a board that works.
    pub fn read(bytes: &[u8]) -> Result<Self, Refusal> {
        let at = |rest: &[u8]| (bytes.len() - rest.len()) as i64;
        let cut = |rest: &[u8]| Kind::Layout.because(bytes.len() as i64, at(rest));
        let (version, rest) = bytes.split_first().ok_or(cut(bytes))?;
        if *version != VERSION {
            return Err(Kind::Version.because(VERSION.into(), (*version).into()));
        }
        // Value by value, so that a refusal tells how far the bytes are good.
        let (name, rest) = take_from_bytes::<Name>(rest).map_err(|_| cut(rest))?;
        let (bus, rest) = take_from_bytes::<BusSettings>(rest).map_err(|_| cut(rest))?;
        let (inputs, rest) = take_from_bytes::<Inputs>(rest).map_err(|_| cut(rest))?;
        let (count, mut rest) = take_from_bytes::<u32>(rest).map_err(|_| cut(rest))?;
        if count as usize > MOST_AXES {
            return Err(Kind::AxisCount.because(MOST_AXES as i64, count.into()));
        }
        let mut axes = heapless::Vec::new();
        for place in 0..count as usize {
            let (axis, behind) = take_from_bytes::<AxisSettings>(rest)
                .map_err(|_| Kind::Layout.at(place, bytes.len() as i64, at(rest)))?;
            // There is room: the count was checked.
            let _ = axes.push(axis);
            rest = behind;
        }
        if !rest.is_empty() {
            return Err(Kind::Behind.because(at(rest), bytes.len() as i64));
        }
        Ok(Self {
            name,
            bus,
            inputs,
            axes,
        })
    }
}
