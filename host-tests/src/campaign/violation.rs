//! A promise that was not kept.

use core::fmt;

/// The promises, as the observer checks them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Promise {
    /// What the drive accepted is what the master believes to have sent, less what still waits in the controller; what a fault on
    /// the wire changes is flagged or within the drift tolerance.
    Books,
    /// At most one request is outstanding with a drive, and a lost one is waited out for two timeouts.
    OneRequest,
    /// No set-point of a group behind an alarm frame until the application says so.
    AlarmStops,
    /// Steps stay within their limit, and ramps within theirs and in proportion.
    Limits,
    /// No set-point of a group behind a fault, other than of its ramp, until the application says so.
    FaultStops,
    /// A reading that is believed is the drive's answer to the request that is outstanding.
    TrueReplies,
    /// Only known commands to known drives, an enable command and a move only when the application asked for it, and no set-point while a
    /// drive moves by itself.
    Commands,
    /// A move of a drive ends where it was to end, or where it was stopped.
    Arrives,
    /// An alarm, and a drive that falls silent for good, shows as a fault. What the other faults do shows in the books and in the
    /// readings: those promises prove them harmless or flagged.
    Noticed,
    /// Without an injected fault there is no fault.
    NoFalseAlarm,
    /// Nothing panics and no event is lost.
    Orderly,
}

/// A promise that was not kept, with what was seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The promise.
    pub promise: Promise,
    /// When, in microseconds of virtual time.
    pub at_us: u64,
    /// What was seen.
    pub what: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            promise,
            at_us,
            what,
        } = self;
        write!(f, "{promise:?} broken at {at_us} us: {what}")
    }
}
