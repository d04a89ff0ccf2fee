//! A flash in memory with the rules of the real ones, whose supply can be cut at any operation.

use fastrand::Rng;
use record_store::{Area, Flash, Reading};

/// The supply is away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cut;

/// What a cut leaves of the operation that it hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Torn {
    /// Nothing of it: the cut is between two operations.
    Nothing,
    /// A part of it, as the seed says.
    Part,
}

/// The state of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    /// Erased to the end.
    Erased,
    /// Erasing it was cut off: whatever it reads, it must not be programmed.
    Weak,
    /// Programmed to the end.
    Programmed,
    /// Programming it was cut off: it may look erased.
    Touched,
    /// Its correction finds two errors.
    Unreadable,
}

/// Two areas of `BYTES` bytes, with units of `UNIT`.
#[derive(Debug, Clone)]
pub(crate) struct Fake<const UNIT: usize, const BYTES: usize> {
    bytes: [Vec<u8>; 2],
    units: [Vec<Unit>; 2],
    /// Operations until the supply is cut.
    left: Option<usize>,
    torn: Torn,
    is_off: bool,
    random: Rng,
    /// Operations so far.
    pub(crate) operations: usize,
    /// Erases so far.
    pub(crate) erases: usize,
}

impl<const UNIT: usize, const BYTES: usize> Fake<UNIT, BYTES> {
    /// As it comes from the factory, or after anything else: never erased.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let bytes = [(); 2].map(|()| (0..BYTES).map(|_| random.u8(..)).collect());
        Self {
            bytes,
            units: [(); 2].map(|()| vec![Unit::Programmed; BYTES / UNIT]),
            left: None,
            torn: Torn::Nothing,
            is_off: false,
            random,
            operations: 0,
            erases: 0,
        }
    }

    /// The supply will be cut at the operation after so many.
    pub(crate) fn cut_after(&mut self, operations: usize, torn: Torn) {
        (self.left, self.torn) = (Some(operations), torn);
    }

    /// The supply comes back.
    pub(crate) fn restart(&mut self) {
        (self.left, self.is_off) = (None, false);
    }

    pub(crate) const fn is_off(&self) -> bool {
        self.is_off
    }

    /// Changes a bit behind everybody's back.
    pub(crate) fn flip(&mut self, area: Area, byte: usize, mask: u8) {
        self.bytes[area as usize][byte] ^= mask;
    }

    /// Whether an operation is done, done in part, or not at all.
    fn begin(&mut self) -> Result<bool, Cut> {
        if self.is_off {
            return Err(Cut);
        }
        if self.left == Some(0) {
            self.is_off = true;
            return match self.torn {
                Torn::Nothing => Err(Cut),
                Torn::Part => Ok(false),
            };
        }
        self.left = self.left.map(|left| left - 1);
        self.operations += 1;
        Ok(true)
    }

    fn program_unit(&mut self, area: usize, at: usize, bytes: &[u8]) -> Result<(), Cut> {
        let state = self.units[area][at / UNIT];
        assert!(
            matches!(state, Unit::Erased | Unit::Touched),
            "a unit that is {state:?} is programmed at {at}"
        );
        let is_whole = self.begin()?;
        let keeps = is_whole && (state == Unit::Erased || self.random.bool());
        // Nothing is to be seen of some that were cut off.
        let spares_all = self.random.u8(0..4) == 0;
        let place = &mut self.bytes[area][at..at + UNIT];
        for (place, byte) in place.iter_mut().zip(bytes) {
            let spared = match (keeps, spares_all) {
                (true, _) => 0,
                (false, true) => 0xFF,
                (false, false) => self.random.u8(..),
            };
            // Bits only go to 0; a part of them stays behind.
            *place &= byte | spared;
        }
        self.units[area][at / UNIT] = match (keeps, is_whole) {
            (true, _) => Unit::Programmed,
            // A corrected double word with a part of its bits is usually beyond correction.
            (false, _) if UNIT == 8 && self.random.u8(0..4) > 0 => Unit::Unreadable,
            (false, true) if place.iter().any(|byte| *byte != 0xFF) => Unit::Programmed,
            // What reads as erased may be programmed: that is what the controller looks at (RM0440, PROGERR of FLASH_SR).
            (false, _) => Unit::Touched,
        };
        if is_whole { Ok(()) } else { Err(Cut) }
    }

    /// Each unit is old, erased, or has a part of its bits.
    fn erase_in_part(&mut self, area: usize) {
        for unit in 0..BYTES / UNIT {
            let choice = self.random.u8(0..4);
            for byte in &mut self.bytes[area][unit * UNIT..][..UNIT] {
                *byte |= match choice {
                    0 => 0,
                    1 => 0xFF,
                    _ => self.random.u8(..),
                };
            }
            let is_readable = UNIT == 4 || choice < 2 || self.random.bool();
            self.units[area][unit] = if is_readable {
                Unit::Weak
            } else {
                Unit::Unreadable
            };
        }
    }
}

impl<const UNIT: usize, const BYTES: usize> Flash for Fake<UNIT, BYTES> {
    type Error = Cut;
    const UNIT: usize = UNIT;
    const AREA_BYTES: usize = BYTES;

    fn read(&mut self, area: Area, offset: usize, bytes: &mut [u8]) -> Result<Reading, Cut> {
        if self.is_off {
            return Err(Cut);
        }
        let area = area as usize;
        let end = offset + bytes.len();
        bytes.copy_from_slice(&self.bytes[area][offset..end]);
        let units = &self.units[area][offset / UNIT..end.div_ceil(UNIT)];
        let is_bad = units.contains(&Unit::Unreadable);
        Ok(if is_bad {
            match self.random.u8(0..3) {
                0 => bytes.fill_with(|| self.random.u8(..)),
                1 => bytes.fill(0xFF),
                _ => {}
            }
            Reading::Unreadable
        } else {
            Reading::Good
        })
    }

    fn program(&mut self, area: Area, offset: usize, bytes: &[u8]) -> Result<(), Cut> {
        assert!(offset.is_multiple_of(UNIT) && bytes.len().is_multiple_of(UNIT));
        let units = bytes.chunks(UNIT).zip((offset..).step_by(UNIT));
        for (bytes, at) in units {
            self.program_unit(area as usize, at, bytes)?;
        }
        Ok(())
    }

    fn erase(&mut self, area: Area) -> Result<(), Cut> {
        if !self.begin()? {
            self.erase_in_part(area as usize);
            return Err(Cut);
        }
        self.erases += 1;
        self.bytes[area as usize].fill(0xFF);
        self.units[area as usize].fill(Unit::Erased);
        Ok(())
    }
}
