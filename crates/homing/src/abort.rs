//! Why a homing ended without a reference.

use core::fmt;

use trajectory::PlanError;

/// A reading that the search needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Awaited {
    /// The position of the drive.
    Position,
    /// The torque of the drive.
    Torque,
    /// The level of the switch.
    Switch,
}

impl fmt::Display for Awaited {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Torque => "torque",
            Self::Switch => "switch",
        })
    }
}

/// How old a reading is, for a text.
struct Age(Option<u64>);

impl fmt::Display for Age {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(us) => write!(f, "{us} us old"),
            None => f.write_str("missing"),
        }
    }
}

/// Why a homing ended without a reference. Counts are those of the drive, torques thousandths of its peak; both are positive in the
/// direction of the search.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Abort {
    /// A reading is too old, or there is none.
    #[error("the {what} must be at most {limit_us} us old, it is {}", Age(*age_us))]
    TooOld {
        /// Which reading.
        what: Awaited,
        /// The oldest that is allowed.
        limit_us: u32,
        /// How old it is; `None` when there is none.
        age_us: Option<u64>,
    },
    /// The shaft did not stand still when the homing began.
    #[error(
        "the axis must stand still at the start, its position changed by {actual_counts} counts, {limit_counts} are allowed"
    )]
    NotStill {
        /// The change that is allowed.
        limit_counts: u32,
        /// The change that was seen.
        actual_counts: u32,
    },
    /// The motor pushes towards the stop already when the homing begins: it stands at the stop, or a load hangs on it.
    #[error(
        "the torque at rest must be below that of a contact, {limit_permille}, it is {actual_permille} thousandths: move the axis off, or raise the limit"
    )]
    TorqueAtRest {
        /// The torque of a contact.
        limit_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
    },
    /// The way of the search is at its end.
    #[error("nothing was found within {way_counts} counts")]
    NotFound {
        /// The way of the search.
        way_counts: u32,
    },
    /// The torque is at its limit and the axis follows: it is hard to move, or the limit is too low.
    #[error(
        "the torque is {actual_permille}, {limit_permille} are allowed, and the following error of {error_counts} counts is not that of a contact, {contact_counts}"
    )]
    TorqueWithoutError {
        /// The highest torque.
        limit_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
        /// The following error of a contact.
        contact_counts: u32,
        /// The following error that was seen.
        error_counts: i64,
    },
    /// The axis does not follow and the torque is not that of a contact: a coupling slips, or the torque is wrong.
    #[error(
        "the following error is {error_counts} counts, {limit_counts} are allowed, and the torque of {actual_permille} is not that of a contact, {contact_permille}"
    )]
    ErrorWithoutTorque {
        /// The largest following error.
        limit_counts: u32,
        /// The following error that was seen.
        error_counts: i64,
        /// The torque of a contact.
        contact_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
    },
    /// The axis does not follow, and the torque has the sign of the other direction: the revision of the drive is another one.
    #[error(
        "the axis is held with a following error of {error_counts} counts, and the torque of {actual_permille} pushes the other way: {contact_permille} are expected. Does the drive report its torque with the other sign, as another revision does?"
    )]
    TorqueAgainst {
        /// The torque of a contact.
        contact_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
        /// The following error that was seen.
        error_counts: i64,
    },
    /// Something is in the way.
    #[error(
        "the following error is {actual_counts} counts, {limit_counts} are allowed: something is in the way"
    )]
    Blocked {
        /// The largest following error.
        limit_counts: u32,
        /// The following error that was seen.
        actual_counts: i64,
    },
    /// The torque is above its limit on the way to a switch.
    #[error(
        "the torque is {actual_permille} thousandths, {limit_permille} are allowed: something is in the way"
    )]
    Overload {
        /// The highest torque.
        limit_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
    },
    /// After a move the axis is not where it should be.
    #[error("the axis must arrive within {limit_counts} counts, it is {actual_counts} off")]
    NotArrived {
        /// The distance that is allowed.
        limit_counts: u32,
        /// The distance that was seen.
        actual_counts: u32,
    },
    /// The motor still pushes after it has backed off.
    #[error(
        "after backing off the torque must be below that of a contact, {limit_permille}, it is {actual_permille} thousandths: the axis sticks"
    )]
    StillPressed {
        /// The torque of a contact.
        limit_permille: u16,
        /// The torque that was read.
        actual_permille: i16,
    },
    /// The slow approach found another place than the fast one, or none: what was found is no stop that stands still.
    #[error("the second approach must find the same place within {limit_counts} counts, it is {} counts off", OffBy(*actual_counts))]
    NotRepeated {
        /// The distance that is allowed.
        limit_counts: u32,
        /// The distance; `None` when nothing was found.
        actual_counts: Option<u32>,
    },
    /// The switch stays operated although the axis has moved off.
    #[error(
        "the switch is still operated {way_counts} counts off its edge: it is stuck, its polarity is another one, or the way back is too short"
    )]
    SwitchStuck {
        /// How far the axis has moved off.
        way_counts: u32,
    },
    /// The switch was operated, and then not any more although the axis did not move off.
    #[error(
        "the switch was operated at {edge_counts} counts and is not any more: it bounces, or is only a short cam"
    )]
    SwitchUnsteady {
        /// Where it was operated.
        edge_counts: i32,
    },
    /// The application asked for the end.
    #[error("it was cancelled")]
    Cancelled,
    /// A move cannot be planned.
    #[error("a move cannot be planned: {0}")]
    Plan(PlanError),
}

/// A distance for a text.
struct OffBy(Option<u32>);

impl fmt::Display for OffBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(counts) => counts.fmt(f),
            None => f.write_str("more than it could go,"),
        }
    }
}

impl From<PlanError> for Abort {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}
