//! What the wheels are told in one cycle.

/// Why the wheels do what they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Phase {
    /// No twist has come yet.
    #[default]
    Waiting,
    /// The latest twist is in force.
    Following,
    /// No new twist came in time: the wheels ramp down to 0, or stand there.
    TimedOut,
}

/// The targets of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Command {
    /// Target of the left wheel in 1/n r/min.
    pub left: i32,
    /// Target of the right wheel in 1/n r/min.
    pub right: i32,
    /// Why.
    pub phase: Phase,
    /// The twist asks for more than a wheel may do: the vehicle is slower on the same curve.
    pub is_limited: bool,
}
