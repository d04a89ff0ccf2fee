//! Transfers of the application: which are refused.

use zlac8030l::{NodeId, SdoRequest, objects};

use crate::core::family::ProcedureRefusal;
use crate::core::state::AxisState;

/// A transfer that was not started; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TransferError {
    /// There is no such wheel.
    #[error("there is no wheel {actual}")]
    NoSuchAxis {
        /// The wheel asked for.
        actual: usize,
    },
    /// The drive is not known yet or lost; or it is to be written to, and is not [`AxisState::Ready`].
    #[error(
        "the wheel is {actual}: reading needs a drive that answers, writing one that is ready and not enabled"
    )]
    State {
        /// The state of the wheel.
        actual: AxisState,
    },
    /// Another transfer waits: wait for its event.
    #[error("another transfer of this wheel waits: wait for its event")]
    Busy,
    /// The master itself writes this object; a second writer could move the wheel.
    #[error("the master writes this object of node {node} itself: use set_target, enable, disable")]
    Owned {
        /// The object.
        node: NodeId,
    },
    /// Saving and restoring parameters (2009h) wears the drive: it needs [`Confirmation::Given`](crate::Confirmation::Given).
    #[error("saving parameters wears the drive: it needs a confirmation")]
    Unconfirmed,
}

impl From<ProcedureRefusal> for TransferError {
    fn from(refusal: ProcedureRefusal) -> Self {
        match refusal {
            ProcedureRefusal::NoSuchAxis { actual } => Self::NoSuchAxis { actual },
            ProcedureRefusal::Busy => Self::Busy,
            ProcedureRefusal::State { actual } => Self::State { actual },
        }
    }
}

/// What the master writes: control word, mode, targets, PDO parameters, supervision, ramps, and what its stops rely on.
pub(super) fn is_owned(request: &SdoRequest) -> bool {
    let address = request.address();
    let written = matches!(request, SdoRequest::Write(..));
    let owned = [
        objects::CONTROL_WORD.address(),
        objects::MODE.address(),
        objects::TARGET_SPEED.address(),
        objects::TARGET_POSITION.address(),
        objects::TARGET_TORQUE.address(),
        objects::PRODUCER_HEARTBEAT_MS.address(),
        objects::OFFLINE_TIME_MS.address(),
        objects::EEPROM_UPDATE.address(),
        objects::QUICK_STOP_OPTION.address(),
        objects::SHUTDOWN_OPTION.address(),
        objects::DISABLE_OPTION.address(),
        objects::HALT_OPTION.address(),
        objects::EMERGENCY_DECELERATION_TIME_MS.address(),
        objects::ROTATION.address(),
        objects::ACCELERATION_TIME_MS.address(),
        objects::DECELERATION_TIME_MS.address(),
        objects::PROFILE_SPEED.address(),
        objects::TORQUE_SLOPE.address(),
        objects::HOLDING_BRAKE.address(),
    ];
    let is_pdo = matches!(
        address.index,
        0x1400..=0x1403 | 0x1600..=0x1603 | 0x1800..=0x1803 | 0x1A00..=0x1A03
    );
    written && (is_pdo || owned.contains(&address))
}
