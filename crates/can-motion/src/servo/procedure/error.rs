//! Why a procedure is not started.

use dyn_can::Refusal;

use crate::core::family::ProcedureRefusal;
use crate::core::state::AxisState;

/// Why a procedure was not started; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ProcedureError {
    /// There is no such axis.
    #[error("there is no axis {actual}")]
    NoSuchAxis {
        /// The axis asked for.
        actual: usize,
    },
    /// The axis has a procedure under way, or its drive moves by itself: wait for its end.
    #[error(
        "another procedure of this axis, or a motion of its drive itself, is under way: wait for its end"
    )]
    Busy,
    /// Writes need an axis that is [`AxisState::Ready`], or faulted with a drive that reports no power.
    #[error(
        "the axis is {actual}: writing needs a drive that was checked and reports no power; disable it first"
    )]
    State {
        /// The state of the axis.
        actual: AxisState,
    },
    /// The crate was built without its feature `procedures`.
    #[error("this program was built without procedures")]
    NotBuilt,
    /// The drive does not answer.
    #[error("the drive does not answer")]
    Lost,
    /// The drive's revision does not know the command.
    #[error(transparent)]
    Refused(Refusal),
    /// The procedure needs [`Confirmation::Given`](crate::Confirmation::Given).
    #[error("this changes the machine for good: it needs a confirmation")]
    Unconfirmed,
    /// The axis has used up its writes: see `WearLimits`.
    #[error("all {budget} writes that this axis may make have been made")]
    WearBudget {
        /// The writes that it may make.
        budget: u16,
    },
    /// The latest write was too short ago.
    #[error("the latest write was too short ago: wait {wait_us} us")]
    WearInterval {
        /// How long to wait, in microseconds.
        wait_us: u64,
    },
}

impl From<ProcedureRefusal> for ProcedureError {
    fn from(refusal: ProcedureRefusal) -> Self {
        match refusal {
            ProcedureRefusal::NoSuchAxis { actual } => Self::NoSuchAxis { actual },
            ProcedureRefusal::Busy => Self::Busy,
            ProcedureRefusal::State { actual } => Self::State { actual },
        }
    }
}

impl From<Refusal> for ProcedureError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}
