//! Settings as bytes: the version, then what postcard makes of [`Settings`], and in version 2 the homing of each axis.

use postcard::take_from_bytes;

use crate::axis::AxisSettings;
use crate::refusal::{Kind, Refusal};
use crate::settings::{BusSettings, Inputs, MOST_AXES, Name, Settings};

/// The newest layout that this version writes and reads: the first byte. Settings without a homing are written as version 1, which every
/// board reads.
pub const VERSION: u8 = 2;
/// The layout without homings.
const WITHOUT_HOMING: u8 = 1;
/// Settings that a board keeps take no more bytes. Without homings none do; with homings of 14 axes they do where nearly every number of theirs
/// takes all its bytes, which no machine needs, and are refused. The records in the flash are so long, so it never changes.
pub const LONGEST: usize = 1_344;

impl Settings {
    /// The bytes of these settings, in the front of `room`.
    ///
    /// # Errors
    /// When there is not enough room: [`LONGEST`] is enough, but for homings with numbers that no machine has. Without the feature `homing`
    /// when there is a homing.
    pub fn write<'a>(&self, room: &'a mut [u8]) -> Result<&'a mut [u8], Refusal> {
        let given = room.len();
        let too_small = Kind::Room.because(LONGEST as i64, given as i64);
        let (version, rest) = room.split_first_mut().ok_or(too_small)?;
        let has_homing = self.axes.iter().any(|axis| axis.homing.is_some());
        *version = if has_homing { VERSION } else { WITHOUT_HOMING };
        let written = postcard::to_slice(self, rest).map(|bytes| bytes.len());
        let mut length = written.map_err(|_| too_small)? + 1;
        if has_homing {
            length += self.write_homings(room.get_mut(length..).unwrap_or_default(), too_small)?;
        }
        room.get_mut(..length).ok_or(too_small)
    }

    #[cfg(feature = "homing")]
    fn write_homings(&self, room: &mut [u8], too_small: Refusal) -> Result<usize, Refusal> {
        let mut length = 0;
        for axis in &self.axes {
            let rest = room.get_mut(length..).unwrap_or_default();
            let written = postcard::to_slice(&axis.homing, rest).map_err(|_| too_small)?;
            length += written.len();
        }
        Ok(length)
    }

    #[cfg(not(feature = "homing"))]
    fn write_homings(&self, _: &mut [u8], _: Refusal) -> Result<usize, Refusal> {
        Err(Kind::NoHoming.because(WITHOUT_HOMING.into(), VERSION.into()))
    }

    /// Reads settings.
    ///
    /// # Errors
    /// When the bytes are not settings of a known version, whole and without anything behind them; without the feature `homing` when they have
    /// a homing. Nothing is said about whether the values make a board that works.
    pub fn read(bytes: &[u8]) -> Result<Self, Refusal> {
        let at = |rest: &[u8]| (bytes.len() - rest.len()) as i64;
        let cut = |rest: &[u8]| Kind::Layout.because(bytes.len() as i64, at(rest));
        let (version, rest) = bytes.split_first().ok_or(cut(bytes))?;
        let has_homings = *version == VERSION;
        if has_homings && !cfg!(feature = "homing") {
            return Err(Kind::NoHoming.because(WITHOUT_HOMING.into(), VERSION.into()));
        }
        if !has_homings && *version != WITHOUT_HOMING {
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
        let mut axes = heapless::Vec::<AxisSettings, MOST_AXES>::new();
        for place in 0..count as usize {
            let (axis, behind) = take_from_bytes::<AxisSettings>(rest)
                .map_err(|_| Kind::Layout.at(place, bytes.len() as i64, at(rest)))?;
            // There is room: the count was checked.
            let _ = axes.push(axis);
            rest = behind;
        }
        #[cfg(feature = "homing")]
        for (place, axis) in axes.iter_mut().enumerate().filter(|_| has_homings) {
            let (homing, behind) = take_from_bytes(rest)
                .map_err(|_| Kind::Layout.at(place, bytes.len() as i64, at(rest)))?;
            (axis.homing, rest) = (homing, behind);
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
