//! What is asked of a set-up.

/// Which software version 2025h the user has tried with these settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Firmware {
    /// Exactly this one.
    Version(u16),
    /// Any: the user answers for what 2009h and 2010h mean there.
    Any,
}

/// What is asked of a set-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetUpOptions {
    /// Software version to expect.
    pub firmware: Firmware,
    /// Save everything to the EEPROM in the end, if a stored object was written.
    pub save: bool,
}
