//! How an adapter takes part in a bus.

/// What the adapter does on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    /// It sends and acknowledges.
    Open,
    /// It only listens, and does not even acknowledge.
    ListenOnly,
}
