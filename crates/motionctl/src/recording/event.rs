//! Something that happened, in words.

use core::fmt;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Happening {
    /// Since the start of the recording.
    pub(crate) at_us: u64,
    /// Place in the motion, not in the master; `None` for the whole bus.
    pub(crate) axis: Option<usize>,
    pub(crate) kind: Kind,
    pub(crate) text: String,
    /// How often in a row; `at_us` is the first time.
    pub(crate) times: u32,
}

/// What kind of thing happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A fault was commanded: by the script or a key.
    Cause,
    /// The master latched a fault.
    Fault,
    /// The master noticed something.
    Notice,
    /// An axis changed its state.
    State,
    /// A phase of the run began.
    Phase,
}

impl Kind {
    /// As files and the page have it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Cause => "commanded",
            Self::Fault => "fault",
            Self::Notice => "notice",
            Self::State => "state",
            Self::Phase => "phase",
        }
    }
}

/// The words, and how often they were said.
impl fmt::Display for Happening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        if self.times > 1 {
            write!(f, " ({} times)", self.times)?;
        }
        Ok(())
    }
}
