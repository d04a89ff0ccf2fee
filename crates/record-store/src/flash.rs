//! What a driver of a flash does.

/// One of the two areas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Area {
    /// The first.
    First,
    /// The second.
    Second,
}

impl Area {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::First, Self::Second];

    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// How reading went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The bytes are those of the flash.
    Good,
    /// A unit among them has an error that its correction cannot mend; the bytes mean nothing.
    Unreadable,
}

/// Two areas of flash that can be erased one without the other, and are not used for anything else.
///
/// The traits of embedded-storage are not used: they have one size for everything that is erased, where the sectors of an STM32F4 have
/// several, and a read that finds a damaged word is an error of theirs, where here it is a finding.
pub trait Flash {
    /// What can go wrong.
    type Error;

    /// Bytes that are programmed at once, and once only.
    const UNIT: usize;
    /// Bytes of each area: a multiple of [`Self::UNIT`].
    const AREA_BYTES: usize;

    /// Reads bytes within an area.
    ///
    /// # Errors
    /// Of the driver; a damaged word is none.
    fn read(&mut self, area: Area, offset: usize, bytes: &mut [u8])
    -> Result<Reading, Self::Error>;

    /// Programs whole units that are erased.
    ///
    /// # Errors
    /// Of the driver.
    fn program(&mut self, area: Area, offset: usize, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Erases an area: every byte is 0xFF.
    ///
    /// # Errors
    /// Of the driver.
    fn erase(&mut self, area: Area) -> Result<(), Self::Error>;
}
